"""The verdict of a solve: whether it converged, and if not, what to do about it. A failed solve is a value, not a NaN."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a solve reached its tolerance; ``message`` says what happened and, on failure, what to change."""

    converged: bool
    message: str = "converged"
    iterations: int = 0
    residual: float = 0.0
