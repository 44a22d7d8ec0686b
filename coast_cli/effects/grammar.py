"""Where each effect of the catalogue stands in the grammar of laws: at which stages, and with what memory.

A name is a point of the grammar. A law without a name at the same stage and with the same memory is the name's own form made
free, and does not speak against it; one that stands elsewhere and fits better does.
"""

from __future__ import annotations

from collections.abc import Mapping

from coast_cli.effects.effect import Effect
from coast_cli.effects.unnamed import Memory, Place, UnnamedLaw

Cell = tuple[Place, Memory]

_CELLS: Mapping[str, tuple[Cell, ...]] = {
    "leadscrew_pitch_error": (("drive", "period"),),
    "backlash": (("drive", "friction"), ("tendon", "friction")),
    "bending_length_offset": (("drive", "none"), ("structure", "none"), ("transmission", "none")),
    "bending_length_label": (("drive", "none"), ("structure", "none"), ("transmission", "none")),
    "lost_steps": (("drive", "step"), ("tendon", "step"), ("drive", "path"), ("drive", "none")),
    "transmission_compliance": (("drive", "none"), ("tendon", "none")),
    "tendon_superelasticity": (("tendon", "none"), ("drive", "none")),
    "tendon_creep": (("tendon", "relaxation"), ("drive", "relaxation"), ("tendon", "path"), ("drive", "path")),
    "tendon_permanent_set": (("tendon", "maximum"), ("drive", "maximum")),
    "capstan_hysteresis": (("transmission", "friction"), ("structure", "friction")),
    "distributed_notch_friction": (("transmission", "none"), ("transmission", "friction"), ("structure", "none")),
    "chord_section": (("structure", "none"), ("transmission", "none")),
    "notch_end_effect": (("structure", "none"), ("transmission", "none")),
    "precurvature": (("structure", "none"), ("sensor", "none")),
    "tip_load": (("structure", "none"),),
    "gravity": (("structure", "none"),),
    "tube_superelasticity": (("structure", "none"), ("transmission", "none")),
    "tube_hysteresis": (("structure", "friction"), ("structure", "none"), ("transmission", "friction")),
    "notch_closure": (("structure", "none"), ("transmission", "none")),
    "snap_through": (("structure", "friction"), ("structure", "none"), ("structure", "maximum")),
    "coulomb_friction": (("structure", "friction"),),
    "viscous_friction": (("structure", "relaxation"), ("drive", "relaxation"), ("structure", "none")),
    "thermal_drift": (
        ("structure", "none"),
        ("transmission", "none"),
        ("sensor", "none"),
        ("structure", "relaxation"),
    ),
    "sensor_lag": (("sensor", "relaxation"),),
    "camera_scale": (("sensor", "none"),),
    "camera_offset": (("sensor", "none"), ("structure", "none")),
    "camera_saturation": (("sensor", "none"),),
    "frozen_frames": (("sensor", "none"), ("sensor", "relaxation")),
    "periodic_disturbance": (("sensor", "period"), ("structure", "period"), ("drive", "period")),
    "load_cell_scale": (("load_cell", "none"),),
    "load_cell_offset": (("load_cell", "none"),),
    "load_friction": (("sensor", "friction"), ("drive", "friction")),
    "run_differs": (("sensor", "none"), ("drive", "none")),
}


def cells_of_effect(effect: Effect) -> frozenset[Cell]:
    """Return the cells at which an effect stands; those of a user's own effect are its stage's, with any memory."""
    if isinstance(effect, UnnamedLaw):
        return frozenset({(effect.place, effect.memory)})
    own: tuple[Cell, ...] = getattr(effect, "grammar_cells", ())
    if own:
        return frozenset(own)
    if effect.id in _CELLS:
        return frozenset(_CELLS[effect.id])
    memories: tuple[Memory, ...] = ("none", "friction", "relaxation", "maximum", "path", "step", "period")
    return frozenset((effect.stage, memory) for memory in memories)


def stands_at(effect: Effect, law: UnnamedLaw) -> bool:
    """Return whether an effect stands where a law does."""
    return (law.place, law.memory) in cells_of_effect(effect)
