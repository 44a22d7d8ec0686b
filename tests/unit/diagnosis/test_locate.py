"""The region of a mismatch does not depend on what rounding leaves of a parameter that nothing shows."""

import numpy as np
import pytest

from coast_cli.diagnosis.locate import Samples, locate

ROUNDING = 3e-26  # what is zero on one processor and this on another


def samples(unseen):
    """Return residuals that stand out on release, and two base parameters, of which the second is seen as given (n,)."""
    rng = np.random.default_rng(0)
    release = np.arange(120) >= 60
    residual = rng.standard_normal(120) * np.where(release, 1.0, 0.1)
    directions = np.column_stack((np.linspace(0.0, 1.0, 120), unseen))
    names = np.where(release, "release", "load")
    return Samples(residual, directions, {}, {"direction": names})


@pytest.mark.parametrize("seen", [0.0, 1.0], ids=["nowhere", "on release alone"])
def test_rounding_of_a_parameter_that_is_not_seen_changes_nothing(seen):
    release = np.where(np.arange(120) >= 60, seen, 0.0)
    noise = np.random.default_rng(1).standard_normal(120)
    (exact,) = locate(samples(release), 0.1, 0.0)
    (rounded,) = locate(samples(release + ROUNDING * noise), 0.1, 0.0)
    assert (exact.axis, exact.value) == ("direction", "release")
    assert (rounded.axis, rounded.value, rounded.share) == (exact.axis, exact.value, exact.share)
    assert rounded.nats == pytest.approx(exact.nats, rel=1e-9)
