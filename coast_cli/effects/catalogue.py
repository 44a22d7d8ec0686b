"""The catalogue: every effect by its id, in the order in which effects act; its stages say on which recordings it shows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from coast_cli.effects.corrections import Correction, faults, own_values, unnamed_law
from coast_cli.effects.effect import STAGES, Effect, RecordingKind
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.base_tilt import BaseTilt
from coast_cli.effects.library.bending_length_label import BendingLengthLabel
from coast_cli.effects.library.bending_length_offset import BendingLengthOffset
from coast_cli.effects.library.camera_offset import CameraOffset
from coast_cli.effects.library.camera_saturation import CameraSaturation
from coast_cli.effects.library.camera_scale import CameraScale
from coast_cli.effects.library.camera_tilt import CameraTilt
from coast_cli.effects.library.capstan_hysteresis import CapstanHysteresis
from coast_cli.effects.library.chord_section import ChordSection
from coast_cli.effects.library.clipped_weight import ClippedWeight
from coast_cli.effects.library.coulomb_friction import CoulombFriction
from coast_cli.effects.library.distributed_notch_friction import DistributedNotchFriction
from coast_cli.effects.library.frozen_frames import FrozenFrames
from coast_cli.effects.library.gravity import Gravity
from coast_cli.effects.library.kink import Kink
from coast_cli.effects.library.leadscrew_pitch_error import LeadscrewPitchError
from coast_cli.effects.library.lens_distortion import LensDistortion
from coast_cli.effects.library.load_cell_offset import LoadCellOffset
from coast_cli.effects.library.load_cell_scale import LoadCellScale
from coast_cli.effects.library.load_friction import LoadFriction
from coast_cli.effects.library.local_stiffness_defect import LocalStiffnessDefect
from coast_cli.effects.library.lost_steps import LostSteps
from coast_cli.effects.library.neutral_axis_offset import NeutralAxisOffset
from coast_cli.effects.library.notch_closure import NotchClosure
from coast_cli.effects.library.notch_depth_error import NotchDepthError
from coast_cli.effects.library.notch_end_effect import NotchEndEffect
from coast_cli.effects.library.periodic_disturbance import PeriodicDisturbance
from coast_cli.effects.library.precurvature import Precurvature
from coast_cli.effects.library.precurvature_gradient import PrecurvatureGradient
from coast_cli.effects.library.roll_misalignment import RollMisalignment
from coast_cli.effects.library.run_differs import RunDiffers
from coast_cli.effects.library.sensor_lag import SensorLag
from coast_cli.effects.library.snap_through import SnapThrough
from coast_cli.effects.library.specimen_hysteresis import SpecimenHysteresis
from coast_cli.effects.library.tendon_creep import TendonCreep
from coast_cli.effects.library.tendon_permanent_set import TendonPermanentSet
from coast_cli.effects.library.tendon_superelasticity import TendonSuperelasticity
from coast_cli.effects.library.thermal_drift import ThermalDrift
from coast_cli.effects.library.tip_load import TipLoad
from coast_cli.effects.library.transmission_compliance import TransmissionCompliance
from coast_cli.effects.library.tube_hysteresis import TubeHysteresis
from coast_cli.effects.library.tube_superelasticity import TubeSuperelasticity
from coast_cli.effects.library.viscous_friction import ViscousFriction
from coast_cli.errors import BadInput

# Listed in the order in which they act; a lag or a lens comes before the camera's scale and offset.
CATALOGUE: dict[str, type[Effect]] = {
    effect.id: effect
    for effect in (
        LeadscrewPitchError,
        TransmissionCompliance,
        Backlash,
        BendingLengthOffset,
        BendingLengthLabel,
        LostSteps,
        TendonSuperelasticity,
        TendonCreep,
        TendonPermanentSet,
        CapstanHysteresis,
        DistributedNotchFriction,
        NotchDepthError,
        ChordSection,
        NotchEndEffect,
        PrecurvatureGradient,
        LocalStiffnessDefect,
        Kink,
        ClippedWeight,
        RollMisalignment,
        NeutralAxisOffset,
        BaseTilt,
        Precurvature,
        TipLoad,
        Gravity,
        TubeSuperelasticity,
        TubeHysteresis,
        NotchClosure,
        SnapThrough,
        CoulombFriction,
        ViscousFriction,
        ThermalDrift,
        SensorLag,
        LensDistortion,
        CameraTilt,
        CameraScale,
        CameraOffset,
        PeriodicDisturbance,
        RunDiffers,
        CameraSaturation,
        FrozenFrames,
        LoadCellScale,
        LoadCellOffset,
    )
}


# Effects that only devices without tubes have; a specimen's loop has the id of the tubes', with forces for stresses.
OF_DEVICES: dict[str, type[Effect]] = {effect.id: effect for effect in (LoadFriction, SpecimenHysteresis)}


def in_order(effects: Iterable[Effect]) -> tuple[Effect, ...]:
    """Return effects in the order in which they act, whatever order they are listed in.

    Stages come first to last, inside a stage the catalogue's order counts, and laws that it does not hold act last there.
    """
    rank = {identifier: place for place, identifier in enumerate(CATALOGUE)}
    return tuple(sorted(effects, key=lambda e: (STAGES.index(e.stage), rank.get(e.id, len(rank)), e.id)))


def effects_of(recording: RecordingKind) -> dict[str, type[Effect]]:
    """Return the effects that a kind of recording can show, by id, in the order in which they act."""
    return {identifier: effect for identifier, effect in CATALOGUE.items() if recording in effect.recordings}


def build_effects(corrections: Mapping[str, Correction], recording: RecordingKind = "joint") -> tuple[Effect, ...]:
    """Return the effects of a ``[corrections]`` table that act on joints, or those that act on photographs.

    Raises:
        BadInput: an effect or a parameter is unknown, or a value lies outside its range.
    """
    fault = next(faults(corrections, CATALOGUE, OF_DEVICES), None)
    if fault is not None:
        key = ".".join(("corrections", *fault.path))
        raise BadInput(fault.message, key=key, found=fault.found, allowed=fault.allowed, hint=fault.hint)
    known = effects_of(recording)
    effects: list[Effect] = []
    for identifier, values in corrections.items():
        if identifier.startswith("unnamed_"):
            law = unnamed_law(identifier, values)
            effects += [law] if recording in law.recordings else []
        elif identifier in known:
            own = own_values(known[identifier], values, recording)
            effects += [known[identifier](**own)] if own else []
    return in_order(effects)
