"""What the engine asks of a recording, whatever it is of: numbers to move, residuals, candidates, and what counts.

``joint`` and ``shapes`` each pose such a problem; ``fit``, ``contest`` and ``judge`` know nothing else of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from coast_cli.diagnosis.space import BaseParameter, ParameterSpace, Point
from coast_cli.effects.effect import Effect, RecordingKind
from coast_cli.mechanics.section import FloatArray

if TYPE_CHECKING:
    from coast_cli.diagnosis.fit import Fit
    from coast_cli.diagnosis.noise_model import NoiseBank

# What an effect is in a hypothesis: its id, and what was chosen for it (a tube, say); 0 by default.
Variant = tuple[str, float]


@dataclass(frozen=True, slots=True)
class Channel:
    """One quantity of the residual, with noise of its own.

    Attributes:
        rows: its place in the residual. bank: its noise models. level: rough noise, in its unit.
        loosened: share of the residual's RMS at the start below which the first pass takes no noise to be.
    """

    rows: slice
    bank: NoiseBank
    level: float
    loosened: float = 0.0


@dataclass(frozen=True, slots=True)
class Contender:
    """An effect that may be there, of one variant's kind.

    Attributes:
        starts: from which it is fitted.
        expected: theory says that it is there, so that it is tried whatever a first step says.
    """

    starts: tuple[Effect, ...]
    expected: bool = False


@dataclass(frozen=True, slots=True)
class Effort:
    """How wide a contest searches.

    Attributes:
        fitted, finished: how many candidates start and end the race, alone and beside others.
        starts: of one candidate that race, each with at least ``second`` of the best one's gain.
        far_behind: nats of plain error behind the best at which the race is given up, but for the first two.
        least_gain: nats of a first step, and ``least_share`` of the best one's, under which a candidate is not fitted.
        enough: share of the base model's error below which sets do not grow.
        most_behind: times the plain error of another set, no larger, above which a set does not lead: noise slow enough
            explains anything.
        exchanges: whether every effect of a leading set is exchanged for its rivals.
    """

    fitted: tuple[int, int]
    finished: tuple[int, int]
    starts: int
    steps: int
    second: float = 0.0
    far_behind: float = float("inf")
    least_gain: float = 0.0
    least_share: float = 0.0
    enough: float = 0.0
    most_behind: float = float("inf")
    exchanges: bool = False


class Problem(Protocol):
    """A recording and a model, ready to be fitted. Residuals are recorded less predicted, SI, channel after channel."""

    @property
    def recording(self) -> RecordingKind:
        """Which side of an effect shows."""

    @property
    def base(self) -> tuple[BaseParameter, ...]:
        """The free parameters of the base model."""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """What the residual consists of; the first is what errors are reported of."""

    @property
    def effort(self) -> Effort:
        """How wide to search."""

    @property
    def noise_floor(self) -> float:
        """The noise of the first channel that the recording itself shows, generous by its own uncertainty."""

    @property
    def misfit(self) -> float:
        """Factor (1 or more) on variances of parameters, for the small smooth misfit that every recording has."""

    def space(self, effects: Sequence[Any]) -> ParameterSpace:
        """Return what a fit of these effects moves."""

    def residuals(self, points: Sequence[Point]) -> list[FloatArray]:
        """Return the residual (n,) at each point, all in one batch."""

    def candidates(self, parent: Sequence[Any]) -> list[Contender]:
        """Return what may be added to a set."""

    def ordered(self, effects: Sequence[Any]) -> tuple[Any, ...]:
        """Return effects in the order in which they act."""

    def variant(self, effect: Any) -> Variant:  # noqa: ANN401
        """Return what an effect is in a hypothesis."""

    def two_sided(self, effect: Any) -> bool:  # noqa: ANN401
        """Return whether the effect can be turned round."""

    def scaled(self, effect: Any, amount: float) -> Any:  # noqa: ANN401
        """Return an effect made ``amount`` times as strong, inside its ranges."""

    def prior_penalty_nats(self, effects: Sequence[Any]) -> float:
        """Return by how much a set starts behind, for being less likely beforehand."""

    def most_effects(self) -> int:
        """Return how many effects the recording can support."""

    def is_needed(self, larger: Fit, smaller: Fit, base: Fit) -> bool:
        """Return whether what a larger set changes is large enough to be named."""
