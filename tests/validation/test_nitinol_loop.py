"""A laser-cut superelastic specimen that others pulled and let go: this law as a bent bar must follow its loops.

The recording lies outside the project (confluentmedical/nitinol-bayes-cal, commit e233ba6; Paranjape et al., Comput.
Mater. Sci. 192, 110357, 2021). Its README: no single-valued law is under 5.1 N RMS, one law for each branch 3.0 N.
The struts of the diamond bend, so that extension stands for curvature and force for moment; the opening of the diamond
adds a factor that is linear in the extension. Run with ``-s`` to print what is left.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from coast_cli.mechanics.fibres import bar_fibres, moment_history
from coast_cli.mechanics.superelastic import Superelastic

LOOP = Path(__file__).parents[2].parent / "shared" / "recordings" / "nitinol_loop" / "diamond_load_unload.csv"
pytestmark = pytest.mark.skipif(not LOOP.is_file(), reason="not here")

BAR = bar_fibres(0.5, 2.0)  # skin at 1, so that curvature is the skin's strain
START = np.array([480.0, 0.6, 72.0, 0.5, 0.5, 20.0, 0.0])
LOW = [10.0, 0.05, 1.0, 0.02, 0.05, 0.0, -2.0]
HIGH = [5000.0, 1.0, 500.0, 0.98, 5.0, 500.0, 5.0]


def force(values, extension):
    """Return the force (N) along a history of extension (mm); strain is counted in mm of extension."""
    modulus, martensite, upper, lower, length, slope, opening = values
    law = Superelastic(modulus, martensite * modulus, upper, lower * upper, length, slope)
    return 3.0 * moment_history(BAR, law, extension)[0] * (1.0 + opening * extension)


def test_loops_of_a_diamond():
    recording = np.genfromtxt(LOOP, delimiter=",", names=True)
    extension, load = recording["extension_mm"], recording["load_n"]
    few, zero = slice(None, None, 6), load[:20].mean()
    fit = least_squares(
        lambda values: force(values, extension[few]) + zero - load[few],
        START,
        x_scale=np.abs(START) + 0.1,
        bounds=(LOW, HIGH),
        xtol=1e-6,
        ftol=1e-6,
    )
    found = force(fit.x, extension) + zero
    error = np.sqrt(np.mean((found - load) ** 2))
    print(f"\nleft over: {error:.2f} N RMS of 5.1 N of the best single-valued law; values {np.round(fit.x, 3)}")
    assert error < 0.7  # 0.60; asked for: 1.0
    top = int(np.argmax(extension))
    for at in (0.25, 0.43, 0.6):  # both plateaus, at the same extension
        up, down = np.argmin(np.abs(extension[:top] - at)), len(load) - 1 - np.argmin(np.abs(extension[::-1] - at))
        width = load[up] - load[down]
        assert found[up] - found[down] == pytest.approx(width, rel=0.15)
    inner = np.flatnonzero((recording["time_s"] > 285.0) & (recording["time_s"] < 400.0))
    assert np.sqrt(np.mean((found[inner] - load[inner]) ** 2)) < 0.9  # 0.84
