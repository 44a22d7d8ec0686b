"""What a law is to the rig: how it is drawn, which protocol can show it, and what is true of it.

`amplitude` names the parameter that is scaled until the law stands the wanted number of noise widths above the
refitted base model; `limits` keep it physical; `floor` is the least size (noise widths) at which a case counts.
The laws themselves are listed in `laws_catalogue`, `laws_outside` and `laws_bench`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from examples.concealed.design import Joint, Robot
from examples.concealed.protocol import RELEASING, Needs, Protocol

Parameters = dict[str, object]


@dataclass(frozen=True)
class Context:
    """Sizes that parameters scale with: largest curvature (1/m) and actuator tension (N), stroke span (mm).

    Duration and row spacing (s), stroke speed (mm/s), the robot, number of runs.
    """

    joint: Joint
    robot: Robot
    curvature: float
    tension: float
    span_mm: float
    duration: float
    dt: float
    bend: bool
    runs: int

    @property
    def speed(self) -> float:
        """Typical stroke speed (mm/s): there and back once in a run."""
        return 2 * self.span_mm / self.duration


@dataclass(frozen=True)
class Nature:
    """What is true of a law, in the words of the contract.

    `stages` are the names that are right (twins that no recording of joints can part are both right), `variables` holds
    for each variable of the law the words that are right; a constant has none. `dissipative` is None for a sensor or a bench.
    """

    stages: tuple[str, ...]
    variables: tuple[tuple[str, ...], ...]
    memory: bool
    rate: bool
    dissipative: bool | None


@dataclass(frozen=True)
class Recipe:
    """One law: its component and kind, when a recording can show it, how it is drawn, what is true of it."""

    component: str
    kind: str
    needs: Needs
    draw: Callable[[np.random.Generator, Context], Parameters]
    amplitude: str
    limits: tuple[float, float]
    nature: Nature
    axes: tuple[str, ...] = ()
    wrist: float = 0.0
    floor: float = 2.4
    reach: Callable[[np.random.Generator, Joint], float] | None = None


def sign(rng: np.random.Generator) -> float:
    """Return plus or minus one."""
    return float(rng.choice([-1.0, 1.0]))


def reverses_at_two_heights(p: Protocol) -> bool:
    """Return whether releases start from two heights: one cannot tell a constant from a proportion."""
    return p.has("partial", "cycles") or (
        sum(run.kind in RELEASING for run in p.runs) >= 2 and p.has("partial", "cycles", "ladder_down")
    )


def returns(p: Protocol) -> bool:
    """Return whether some run is released."""
    return p.has(*RELEASING)


def two_rates(p: Protocol) -> bool:
    """Return whether the recording has a clock and its rates differ."""
    return p.has_time and p.rates() > 2.5 and p.has(*RELEASING)


def timed(p: Protocol) -> bool:
    """Return whether the recording has a clock and comes back to where it was at another time."""
    return p.has_time and p.has("cycles", "rates", "ladder_down", "partial")


# Words of the contract that mean the same to a joint: a bend is a curvature over a length, and a tension too on load.
BEND = ("curvature", "bend")
LENGTH = ("bending_length", "position")
