"""Corrections with a memory of their own, step by step: what each adds for a value on trial, kept once the step is taken.

Row by row they are what ``Effect.slack``, ``drive`` and ``sense`` of the forward model give for the whole history.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, expm1
from typing import Protocol

import numpy as np

from coast_cli.effects.library.tendon_creep import TendonCreep
from coast_cli.effects.library.tendon_permanent_set import TendonPermanentSet
from coast_cli.effects.unnamed import UnnamedLaw, Variable
from coast_cli.units import MILLIMETRE

_FEW = 1e-8

Values = Mapping[Variable, float]  # of the variables that a law may depend on, SI


class Slack(Protocol):
    """Tendon length that a correction adds."""

    def at(self, dt: float, tension: float, values: Values) -> float:
        """Return the length (m) if the tension (N) were this, ``dt`` s after the step before."""

    def keep(self) -> None:
        """Take the last trial."""


def relaxed(state: float, before: float, target: float, step: float) -> float:
    """Return a first-order lag after ``step`` time constants, with the target linear on the way."""
    decay = exp(-step)
    ramp = step / 2.0 if step < _FEW else 1.0 + expm1(-step) / step
    return decay * state + (1.0 - decay - ramp) * before + ramp * target


class Creep:
    """``TendonCreep``: a fraction of the elastic stretch that comes late."""

    def __init__(self, effect: TendonCreep, stiffness: float) -> None:
        self._effect, self._fraction = effect, effect.fraction / stiffness
        self._state: tuple[float, float] | None = None
        self._tried = (0.0, 0.0)

    def at(self, dt: float, tension: float, values: Values) -> float:
        """Return the delayed stretch, m."""
        target = self._fraction * tension
        stretch = 0.0
        if self._state is not None:
            stretch = relaxed(*self._state, target, dt / self._effect.time_constant_s)
        self._tried = stretch, target
        return stretch

    def keep(self) -> None:
        """Take the last trial."""
        self._state = self._tried


class PermanentSet:
    """``TendonPermanentSet``: slack by the largest tension so far."""

    def __init__(self, effect: TendonPermanentSet) -> None:
        self._effect, self._largest, self._tried = effect, 0.0, 0.0

    def at(self, dt: float, tension: float, values: Values) -> float:
        """Return the slack, m."""
        self._tried = max(self._largest, tension)
        return self._effect.slack_mm_per_n * MILLIMETRE * max(self._tried - self._effect.threshold_n, 0.0)

    def keep(self) -> None:
        """Take the last trial."""
        self._largest = self._tried


class StepLaw:
    """A law without a name: what it adds, or where its play has been pushed to."""

    def __init__(self, law: UnnamedLaw) -> None:
        self._law = law
        self._before: float | None = None
        self._state = 0.0
        self._tried = (0.0, 0.0)

    @property
    def rubs(self) -> bool:
        """Whether it acts as a play."""
        return self._law.memory == "friction"

    def added(self, dt: float, values: Values) -> float:
        """Return what it adds, in its stage's unit."""
        value = values[self._law.variable]
        state = self._next(dt, value)
        self._tried = value, state
        memory = self._law.memory
        seen = state - value if memory == "relaxation" else state if memory in ("maximum", "path") else value
        if memory == "step":
            seen = float(value > self._law.setting)
        return self._of(seen)

    def moved(self, at: float, unit: float, values: Values) -> float:
        """Return where the play is after ``at`` has pushed it; ``unit`` of its width in SI."""
        half = self._of(values[self._law.variable]) * unit
        state = at - half if self._before is None else min(max(self._state, at - half), at + half)
        self._tried = at, state
        return state

    def keep(self) -> None:
        """Take the last trial."""
        self._before, self._state = self._tried

    def _of(self, seen: float) -> float:
        return float(self._law.of(np.array([seen]))[0])

    def _next(self, dt: float, value: float) -> float:
        memory, before = self._law.memory, self._before
        if memory == "maximum":
            return max(self._state, value)
        if memory == "path":
            return self._state + (0.0 if before is None else abs(value - before))
        if memory == "relaxation":
            return value if before is None else relaxed(self._state, before, value, dt / self._law.setting)
        return 0.0


class LawSlack:
    """A law without a name in the tendon."""

    def __init__(self, law: UnnamedLaw) -> None:
        self._law = StepLaw(law)

    def at(self, dt: float, tension: float, values: Values) -> float:
        """Return the length that it adds, m."""
        return self._law.added(dt, {**values, "tension": tension}) * MILLIMETRE

    def keep(self) -> None:
        """Take the last trial."""
        self._law.keep()
