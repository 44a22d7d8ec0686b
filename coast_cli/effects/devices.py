"""Devices without tubes: what a transmission does when its drive has a history, and which effects can act on it.

The drive passes the effects of the drive stage, the ratio makes a response of it, friction and material change that
(``OnDevice``), and the sensor reads it. What acts on tendon, tubes or notches has no stage here and is no candidate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from coast_cli.effects.catalogue import CATALOGUE, OF_DEVICES, effects_of, in_order
from coast_cli.effects.corrections import Correction, own_values, unnamed_law
from coast_cli.effects.effect import Effect, History, acting
from coast_cli.effects.library.bending_length_label import BendingLengthLabel
from coast_cli.effects.library.bending_length_offset import BendingLengthOffset
from coast_cli.effects.library.camera_offset import CameraOffset
from coast_cli.effects.library.camera_scale import CameraScale
from coast_cli.effects.stages import OnDevice, OnDrive, OnSensor
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.transmission import Transmission

_STAGES = (OnDrive, OnDevice, OnSensor)
# They change a length that a device does not have, or do what its zero and its ratio do, which are fitted.
_LEFT_OUT = (BendingLengthLabel, BendingLengthOffset, CameraOffset, CameraScale)


def has_stage(effect: type[Effect]) -> bool:
    """Return whether an effect acts on a device without tubes at all."""
    return effect not in _LEFT_OUT and issubclass(effect, _STAGES)


def device_effects() -> dict[str, type[Effect]]:
    """Return the effects that a device without tubes can have, by id, in the order in which they act."""
    found = effects_of("joint") | OF_DEVICES
    return {identifier: effect for identifier, effect in found.items() if has_stage(effect)}


def predict_device(device: Transmission, effects: Sequence[Effect], runs: Sequence[History]) -> list[FloatArray]:
    """Return the response (n, 1) to every run, SI.

    A run starts where its first recorded response says: inside its play, or with its friction turned either way.
    """
    ordered = in_order(effects)
    # The cable stretches before the play of the far end, whose state the first response shows.
    places = {identifier: place for place, identifier in enumerate(CATALOGUE)}
    drives = sorted(acting(ordered, OnDrive), key=lambda effect: places.get(effect.id, len(places)))
    found = []
    for commanded in runs:
        history = _started(device, commanded)
        for effect in drives:
            history = effect.drive(history)
        response = device.response(history.drive, history.load)
        for device_effect in acting(ordered, OnDevice):
            response = device_effect.carry(response, history)
        response = response[:, np.newaxis]
        for sensor in acting(ordered, OnSensor):
            response = sensor.sense(response, commanded)
        found.append(response)
    return found


def _started(device: Transmission, history: History) -> History:
    """Return a history with the drive that its first recorded response stands for."""
    if history.first_response is None:
        return history
    load = 0.0 if history.load is None or history.load.size == 0 else float(history.load[0])
    return replace(history, start=device.drive_of(history.first_response, load))


def build_device_effects(corrections: Mapping[str, Correction]) -> tuple[Effect, ...]:
    """Return the effects of a ``[corrections]`` table that act on a device without tubes."""
    effects: list[Effect] = []
    known = device_effects()
    for identifier, values in corrections.items():
        if identifier.startswith("unnamed_"):
            effects.append(unnamed_law(identifier, values))
        elif identifier in known:
            effect = known[identifier]
            own = own_values(effect, values, "joint")
            effects += [effect(**own)] if own else []
    return in_order(effects)
