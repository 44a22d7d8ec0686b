"""The signature of an effect: what the reference joint does in one drive without it and with it, at a size that shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import RUN, Effect, History, Parameter
from coast_cli.effects.forward import Layout, predict
from coast_cli.effects.stations import stations_for
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.rounding import without_rounding
from coast_cli.mechanics.section import FloatArray
from coast_cli.spec.build import build
from coast_cli.spec.load import REFERENCE, load_config
from coast_cli.units import MEGAPASCAL, MILLIMETRE

SHOWN = 0.15  # change of the response that is looked for, RMS, over the largest response
_SIZES = np.geomspace(1e-5, 1.0, 26)  # tried, of the way from the null to the end of the range
_LENGTH = 30.0 * MILLIMETRE


@dataclass(frozen=True)
class Signature:
    """Responses to one drive, row by row; SI.

    Attributes:
        effect: with the values it was simulated at.
        stroke: m, shape (n,). base, changed: curvature without and with the effect, 1/m, shape (n,).
    """

    effect: Effect
    stroke: FloatArray
    base: FloatArray
    changed: FloatArray

    @property
    def change(self) -> float:
        """Root mean square of the change over the largest response."""
        return float(np.sqrt(np.mean((self.changed - self.base) ** 2)) / np.max(np.abs(self.base)))


def signature(kind: type[Effect]) -> Signature:
    """Return the signature of an effect of joints on the reference input's joint, S4, at 30 mm.

    The drive goes up, holds for a minute, comes down, and goes up again by half and back, so that friction, memory, creep and
    lag all show. The size is the smallest tried at which the change is ``SHOWN``, or the one that changes most.
    """
    joint = build(load_config(REFERENCE)).joint()
    run = _drive(joint)
    layout = Layout("curvature", curvature_limit=120.0)
    base = without_rounding(predict(joint, (), [run], layout)[0].response[:, 0])
    scales = _scales(joint, run, base)
    found: list[Signature] = []
    for size in _SIZES:
        for side in ("high", "low"):
            effect = kind(**{p.name: _value(p, scales, float(size), side) for p in kind.parameters})
            changed = without_rounding(predict(joint, (effect,), [run], layout)[0].response[:, 0])
            found.append(Signature(effect, run.drive, base, changed))
        if max(found[-1].change, found[-2].change) >= SHOWN:
            break
    return max(found, key=lambda one: min(one.change, SHOWN))


def _drive(joint: Joint) -> History:
    """Return a stroke over time at one bending length: up, hold, down, half up, down; a row every half second."""
    rest, top = joint.deadband, joint.deadband + 3.0 * MILLIMETRE
    half = 0.5 * (rest + top)
    corners = ((0.0, rest), (30.0, top), (90.0, top), (120.0, rest), (135.0, half), (150.0, rest))
    time = np.linspace(0.0, 150.0, 301)
    stroke = np.interp(time, [t for t, _ in corners], [s for _, s in corners])
    return History(time, stroke, None, np.full_like(time, _LENGTH))


def _scales(joint: Joint, run: History, base: FloatArray) -> dict[str, float]:
    """Return the largest of each kind of number in the recording, which starts of a fit are multiples of."""
    tension = float(np.max(predict(joint, (), [run], Layout("curvature"))[0].tension))
    curvature = float(np.max(base))
    segment = stations_for(joint, (), _LENGTH, "curvature", 1).segment
    strain = curvature * float(segment.strain_per_curvature.mean())
    return {
        "": 1.0,
        "curvature": curvature,
        "strain": strain,
        "stress": strain * joint.youngs_modulus / MEGAPASCAL,
        "closure": curvature / float(segment.closing_curvature.mean()),
        "response": curvature,
        "tension": tension,
        "duration": 150.0,
        "stroke": float(np.max(run.drive)) / MILLIMETRE,
        "period": 30.0,
    }


def _value(parameter: Parameter, scales: dict[str, float], size: float, side: str) -> float:
    """Return a size that is so much of its range away from the null, and a shape as a fit starts with it."""
    if parameter.role == "size":
        end = parameter.high if side == "high" else parameter.low
        return parameter.null + size * (end - parameter.null)
    if parameter == RUN or not parameter.starts:
        return parameter.null
    start = parameter.starts[0] * scales.get(parameter.relative_to, 1.0)
    return float(np.clip(start, parameter.low, parameter.high))
