"""The catalogue of shapes: every effect that a photographed tube or pair can have, in the order in which they act."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from coast_cli.effects.corrections import Correction, own_values
from coast_cli.effects.library.base_tilt import BaseTilt
from coast_cli.effects.library.camera_tilt import CameraTilt
from coast_cli.effects.library.lens_distortion import LensDistortion
from coast_cli.effects.library.local_stiffness_defect import LocalStiffnessDefect
from coast_cli.effects.library.neutral_axis_offset import NeutralAxisOffset
from coast_cli.effects.library.notch_depth_error import NotchDepthError
from coast_cli.effects.library.precurvature_gradient import PrecurvatureGradient
from coast_cli.effects.library.roll_misalignment import RollMisalignment
from coast_cli.effects.shape_effect import ShapeEffect
from coast_cli.effects.shapes.camera_scale import CameraScale
from coast_cli.effects.shapes.chord_section import ChordSection
from coast_cli.effects.shapes.coulomb_friction import CoulombFriction
from coast_cli.effects.shapes.gravity import Gravity
from coast_cli.effects.shapes.notch_end_effect import NotchEndEffect
from coast_cli.effects.shapes.tip_load import TipLoad

SHAPE_CATALOGUE: dict[str, type[ShapeEffect]] = {
    effect.id: effect
    for effect in (
        NotchDepthError,
        ChordSection,
        NotchEndEffect,
        PrecurvatureGradient,
        LocalStiffnessDefect,
        RollMisalignment,
        CoulombFriction,
        NeutralAxisOffset,
        BaseTilt,
        TipLoad,
        Gravity,
        LensDistortion,
        CameraTilt,
        CameraScale,
    )
}


def in_order(effects: Iterable[ShapeEffect]) -> tuple[ShapeEffect, ...]:
    """Return effects in the order in which they act, whatever order they are listed in."""
    rank = {identifier: place for place, identifier in enumerate(SHAPE_CATALOGUE)}
    return tuple(sorted(effects, key=lambda effect: rank[effect.id]))


def build_shape_effects(corrections: Mapping[str, Correction]) -> tuple[ShapeEffect, ...]:
    """Return the effects of shapes in a ``[corrections]`` table; what only a joint has is left out.

    The table was checked when it was read (``corrections.faults``).
    """
    effects = []
    for identifier, values in corrections.items():
        effect = SHAPE_CATALOGUE.get(identifier)
        own = own_values(effect.parameters, effect.scope, values, "shapes") if effect is not None else {}
        if effect is not None and own:
            effects.append(effect(**own))
    return in_order(effects)
