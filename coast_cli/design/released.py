"""The strokes that hold a joint on its way back: from the largest curvature asked for, with what its corrections remember."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from coast_cli.design.drive_history import drive_along
from coast_cli.effects.effect import Effect, acting
from coast_cli.effects.stages import OnSlack
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.errors import UsageError
from coast_cli.mechanics.joint import Joint, StrokeSolution
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.verdict import Verdict


def released_stroke(
    joint: Joint, effects: Sequence[Effect], bending_length: FloatArray, curvature: FloatArray
) -> StrokeSolution:
    """Return the strokes, tensions and strains that hold curvatures (1/m) on release, arrays of (n,).

    At each bending length (m) the joint is pulled to the largest curvature and let back through the others. NaN stands where
    nothing holds a curvature.

    Raises:
        UsageError: there is no release branch: no correction remembers, or there is no tendon.
    """
    if joint.tendon is None:
        raise UsageError("branch release: a stroke needs a [tendon] table.")
    if not any(_remembers(effect) for effect in effects):
        raise UsageError(
            "branch release: there is no such branch: the model releases as it loads, as no correction of friction or play "
            "remembers; a diagnosed model has them."
        )
    stroke, tension, strain = (np.empty_like(curvature) for _ in range(3))
    for length in np.unique(bending_length):
        rows = np.flatnonzero(bending_length == length)
        falling, place = np.unique(-curvature[rows], return_inverse=True)
        driven = drive_along(joint, joint.tendon, effects, -falling, np.full(falling.size, length))
        stroke[rows], tension[rows] = driven.stroke[place], driven.tension[place]
        strain[rows] = driven.stretch[place] / joint.tendon.length
    return StrokeSolution(curvature, stroke, tension, strain, Verdict(converged=True))


def _remembers(effect: Effect) -> bool:
    """Return whether an effect lets load and release differ."""
    if isinstance(effect, UnnamedLaw) and effect.memory != "none":
        return True
    return effect.reverses or bool(acting([effect], OnSlack)) or "release" in effect.needs
