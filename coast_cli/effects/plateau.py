"""The stress-strain curve of the tubes with fitted plateaus, and how the segment bends by it.

Where a tube has a curve of its own (``[materials.NAME.superelastic]``), the fitted plateaus take the place of the configured
ones and the rest of that curve stays; a linear tube gets a curve of one modulus.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.release import LoadAndRelease, load_and_release
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.superelastic import Superelastic

_LENGTH = 0.046  # of the plateau in strain (physics.md, sizes worth knowing)
_NARROWEST = 0.98  # lower plateau over upper
_SHORTEST = 0.5  # lower plateau's length over the upper one's


def fitted_law(
    own: Superelastic | None, modulus: float, upper: float, lower: float, stiffness_lost: float
) -> Superelastic:
    """Return a curve with these plateaus (Pa): the tube's own where it has one, else of one modulus (Pa)."""
    lower, slope = min(lower, _NARROWEST * upper), (1.0 - stiffness_lost) * modulus
    if own is None:
        return Superelastic(modulus, modulus, upper, lower, _LENGTH, slope)
    law = replace(own.with_modulus(modulus), upper_plateau=upper, lower_plateau=lower, plateau_modulus=slope)
    if (
        law.lower_length < _SHORTEST * law.transformation_strain
    ):  # plateaus this high leave martensite no room to be softer
        softer = (1.0 - _SHORTEST) * law.transformation_strain / (upper - lower)
        law = replace(law, martensite_modulus=1.0 / (1.0 / modulus + softer))
    return law


def fitted_tubes(joint: Joint, upper: float, lower: float, stiffness_lost: float) -> list[tuple[float, LoadAndRelease]]:
    """Return load and release of each tube with its fraction of the joint's rigidity."""
    found, modulus = [], joint.youngs_modulus
    for tube, towards_notch in ((joint.outer, False), (joint.middle, True)):
        if tube is not None:
            part = tube.rigidity_series / tube.youngs_modulus / joint.second_moment
            law = fitted_law(tube.superelastic, modulus, upper, lower, stiffness_lost)
            found.append((part, load_and_release(tube.row, law, modulus, towards_notch=towards_notch)))
    return found


def softened(joint: Joint, tubes: list[tuple[float, LoadAndRelease]], curvature: FloatArray) -> FloatArray:
    """Return what fitted curves of the tubes add to the moment over the rigidity (1/m), beyond the configured ones."""
    change = np.zeros_like(curvature)
    for part, tube in tubes:
        change += part * (tube.load.carried(curvature.reshape(1, -1)).reshape(curvature.shape) - curvature)
    if joint.softening.parts:
        change -= joint.softening.carried(curvature) - curvature
    return change


def has_own_curve(joint: Joint) -> bool:
    """Return whether a tube of the joint has a stress-strain curve of its own."""
    return any(tube is not None and tube.superelastic is not None for tube in (joint.outer, joint.middle))
