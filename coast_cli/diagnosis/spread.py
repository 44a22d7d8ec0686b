"""How sure fitted numbers are, as a model file keeps it: standard deviations and correlations by configuration key."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.effects.effect import Effect

    Floats = NDArray[np.float64]

_DIGITS = 6  # significant ones of what a file keeps, so that machines agree


@dataclass(frozen=True, eq=False)
class Spread:
    """Fitted numbers by their dotted keys: standard deviation in the unit of the key, and correlation, [p, p]."""

    keys: tuple[str, ...]
    std: Floats
    correlation: Floats

    def table(self, has: Callable[[str], bool]) -> dict[str, Any] | None:
        """Return the table of a model file, of the numbers that it has; None where no deviation of them is known."""
        known = [k for k, key in enumerate(self.keys) if 0.0 < self.std[k] < np.inf and has(key)]
        if not known:
            return None
        return {
            "keys": [self.keys[k] for k in known],
            "std": [_rounded(self.std[k]) for k in known],
            "correlation": [[_rounded(self.correlation[row, column]) for column in known] for row in known],
        }


def spread_of(keys: Sequence[str], scale: Sequence[float], covariance: Floats) -> Spread:
    """Return the spread of numbers fitted in coordinates, to first order.

    Args:
        scale: what one unit of each coordinate is in its number; the number itself where its logarithm is fitted.
    """
    std = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    safe = np.where((std > 0.0) & np.isfinite(std), std, 1.0)
    correlation = np.clip(np.nan_to_num(covariance) / np.outer(safe, safe), -1.0, 1.0)
    np.fill_diagonal(correlation, 1.0)
    return Spread(tuple(keys), std * np.abs(scale), correlation)


def effect_keys(effects: Sequence[Effect]) -> list[str]:
    """Return the configuration keys of the parameters of effects, in the order in which a fit has them."""
    return [f"corrections.{effect.id}.{parameter.name}" for effect in effects for parameter in effect.parameters]


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
