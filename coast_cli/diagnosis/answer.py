"""The five answers of a diagnosis, as a frozen result that every output format reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from coast_cli.diagnosis.locate import Region
from coast_cli.effects.effect import Effect, RecordingKind

if TYPE_CHECKING:
    from coast_cli.diagnosis.curves import JointCurve, ShapeCurve
    from coast_cli.diagnosis.spread import Spread
    from coast_cli.diagnosis.unnamed.words import Description
    from coast_cli.spec.config import Config

Verdict = Literal["agrees", "parameters", "physics", "sensor", "ambiguous", "unnamed", "unexplained", "insufficient"]


@dataclass(frozen=True, slots=True)
class Value:
    """A fitted number: value, standard deviation, and whether it lies on a bound."""

    value: float
    std: float
    at_bound: bool


@dataclass(frozen=True, slots=True)
class Named:
    """A named effect with its fitted parameters and the calibrated probability that it is the right name."""

    id: str
    kind: str
    component: str
    title: str
    equation: str
    confidence: float
    parameters: Mapping[str, Value]


@dataclass(frozen=True, slots=True)
class Errors:
    """RMS errors of a model: of the response in its table unit, of the tip in mm; and over how many samples."""

    count: int
    response: float
    tip_mm: float


@dataclass(frozen=True, slots=True)
class Level:
    """Errors on the rows fitted and on those held out, in the response's unit; None where nothing was held out."""

    train: float
    held_out: float | None


@dataclass(frozen=True, slots=True)
class SideBySide:
    """The model as configured, with its parameters refitted, and with the effects, side by side."""

    unit: str
    held_out_runs: tuple[str, ...]
    rule: str
    configured: Level
    refitted: Level
    with_effects: Level
    tip_mm_refitted: float
    tip_mm_with_effects: float


@dataclass(frozen=True, slots=True)
class Test:
    """Something that was asked of rows or runs: the chance that noise alone does as badly, and whether it was passed."""

    name: str
    p: float
    passed: bool


@dataclass(frozen=True)
class Diagnosis:
    """What ``coast diagnose`` answers; parameters are in the units of their names, errors in that of the response.

    Attributes:
        verdict, reason: the first answer and a sentence on it.
        noise, noise_unit: level of the noise that the recording itself shows.
        where: regions of the mismatch, largest share first.
        effects: named, the most important first; with the verdict ``parameters`` only effects of that kind, and none with
            agrees, unexplained or insufficient.
        alternatives: ids of other sets that the data cannot tell from the named one.
        attempts: ids of the best set where it was not good enough to be named.
        parameters: base parameters as refitted, beside ``configured``.
        comparison: errors side by side; None where nothing could be fitted.
        next_recording: what would settle what is open, in bench words.
        notes: what limits the answer, a sentence each.
        model_effects, model_parameters: the corrected model, for the model file.
        carried: of joint and shapes in one call, what the shapes say and what of it the joint was diagnosed with.
        model_tubes: numbers of its tubes by their keys there, one or one for each notch.
        curves: of every run, what the refitted base and the corrected model predict; none where nothing was fitted.
        model_spread: how sure the numbers of the corrected model are; None where that is not known.
        unnamed: what is known of a law without a name, alone or beside the names; None where there is none.
        recording: kind of recording that was diagnosed.
        probabilities: of each name that was given or considered, and of ``something_else``: that none of them is right.
        tests: what the answer rests on. evidence: what speaks against the names, by figure (``joint/odds.py``).
    """

    verdict: Verdict
    reason: str
    noise: float
    noise_unit: str
    where: tuple[Region, ...] = ()
    effects: tuple[Named, ...] = ()
    alternatives: tuple[tuple[str, ...], ...] = ()
    attempts: tuple[str, ...] = ()
    parameters: Mapping[str, Value] = field(default_factory=dict)
    configured: Mapping[str, float] = field(default_factory=dict)
    comparison: SideBySide | None = None
    next_recording: str = ""
    notes: tuple[str, ...] = ()
    model_effects: tuple[Effect, ...] = ()
    model_parameters: Mapping[str, float] = field(default_factory=dict)
    model_tubes: Mapping[str, float | list[float]] = field(default_factory=dict)
    carried: Carried | None = None
    model_spread: Spread | None = field(default=None, compare=False)
    curves: tuple[JointCurve, ...] | tuple[ShapeCurve, ...] = field(default=(), compare=False)
    unnamed: Description | None = None
    recording: RecordingKind = "joint"
    probabilities: Mapping[str, float] = field(default_factory=dict)
    tests: tuple[Test, ...] = ()
    evidence: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Return the answers in a few lines."""
        effects = "; ".join(
            f"{effect.title} ({effect.id}, confidence {100.0 * effect.confidence:.0f} %)" for effect in self.effects
        )
        fitted = ", ".join(f"{name} {value.value:.5g} +- {value.std:.2g}" for name, value in self.parameters.items())
        lines = [f"Diagnosis: {self.verdict}. {self.reason}"]
        lines += [f"  named: {effects or 'nothing'}", f"  fitted: {fitted or 'nothing'}"]
        if self.comparison is not None and self.comparison.with_effects.held_out is not None:
            level = self.comparison.with_effects.held_out
            lines.append(f"  held-out error {level:.3g}, noise {self.noise:.3g} {self.noise_unit}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Return the answers for a notebook."""
        from html import escape

        return f"<pre>{escape(repr(self))}</pre>"

    def config_used(self, config: Config) -> Config:
        """Return the configuration that was diagnosed: as given, or corrected by what shapes taught."""
        return config if self.carried is None or self.carried.config is None else self.carried.config


@dataclass(frozen=True, slots=True)
class Shared:
    """A number that shapes and strokes both measure: by each alone, by both, and whether the two agree.

    ``joint`` is None where the strokes cannot tell it from their own base parameters.
    """

    name: str
    shapes: Value
    joint: Value | None
    together: Value | None
    agree: bool | None


@dataclass(frozen=True)
class Carried:
    """What the shapes of a call say, and what of it was carried over to its joint.

    Attributes:
        shapes: their diagnosis. shared: numbers that both measure.
        without, with_it: the joint's errors as configured and with its base refitted, without what the shapes found in the
            tubes and with it; None where they found nothing there.
        config: the configuration corrected by the shapes, which the joint was diagnosed with; None where it was not.
    """

    shapes: Diagnosis
    shared: tuple[Shared, ...] = ()
    without: tuple[Level, Level] | None = None
    with_it: tuple[Level, Level] | None = None
    config: Config | None = None
