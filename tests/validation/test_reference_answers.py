"""Three answers to 13 digits: a tube under gravity at three natural curvatures, to 122 degrees."""

import numpy as np
import pytest

from coast_cli.mechanics.beam import solve_beam
from coast_cli.mechanics.tube import NotchedTube

# natural curvature (1/m): tip angle (rad), tip x, tip y (m)
REFERENCE = {
    5.0: (-0.66270797828223, 0.087982123270705, -0.066789038374872),
    -5.0: (-1.40985211612583, 0.060216743875269, -0.086052930077382),
    -15.0: (-2.12682804094436, 0.030065655053199, -0.090728647097830),
}


def reference_tube(natural_curvature: float) -> NotchedTube:
    notches = np.ones(188)
    return NotchedTube(
        "reference",
        0.2e-3,
        0.165e-3,
        0.35e-3 * notches,
        0.3e-3 * notches,
        0.3e-3 * notches,
        45e9,
        6450.0,
        natural_curvature,
    )


@pytest.mark.parametrize("natural_curvature", REFERENCE)
def test_tip(natural_curvature):
    tip_angle, tip_x, tip_y = REFERENCE[natural_curvature]
    tube = reference_tube(natural_curvature)
    solution = solve_beam(tube, gravity=9.81)
    assert solution.verdict.converged
    assert solution.tip_angle == pytest.approx(tip_angle, abs=1e-13)
    assert np.hypot(solution.x[-1] - tip_x, solution.y[-1] - tip_y) < 1e-13 * tube.length
