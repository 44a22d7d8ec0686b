"""A law in plain words: what it adds, to what, and how its curve runs, with its numbers and units."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from coast_cli.diagnosis.unnamed.forms import Display, curve_of
from coast_cli.effects.unnamed import Place, UnnamedLaw, Variable
from coast_cli.mechanics.section import FloatArray

_LEVEL = 0.15  # of the curve's largest value, within which it is constant
_TURN = 0.1  # of the curve's span, by which it must come back to count as a turn
_NOTHING = 0.005  # of its largest value, below which the curve is said to be zero
_LATE = 0.3  # of the range, over which it hardly changes before it begins or after it ends
# What a stage adds where the curve is above zero, and where it is below.
_ADDED: Mapping[Place, tuple[str, str]] = {
    "drive": ("an added stroke", "a lost stroke"),
    "tendon": ("an added length of the tendon", "a shortening of the tendon"),
    "transmission": ("an added loss of tension (ln of the ratio)", "a gain of tension (ln of the ratio)"),
    "structure": (
        "an added bending moment (as EI times curvature)",
        "a missing bending moment (as EI times curvature)",
    ),
    "sensor": ("a response that the camera shows too large", "a response that the camera shows too small"),
    "load_cell": ("a tension that the load cell reads too large", "a tension that the load cell reads too small"),
}
# The same where it works against the motion.
_AGAINST: Mapping[Place, str] = {
    "drive": "play of the drive to either side",
    "tendon": "friction in the tendon's stretch to either side",
    "transmission": "friction along the tendon (ln of the tension ratio, turning round with the motion)",
    "structure": "an added bending moment on load and as much less on release (as EI times curvature)",
    "sensor": "play in what the camera shows to either side",
    "load_cell": "play in what the load cell reads to either side",
}
_SUBJECTS: Mapping[Place, str] = {
    "drive": "the drive",
    "tendon": "the tendon",
    "transmission": "the transmission",
    "structure": "the structure",
    "sensor": "the camera",
    "load_cell": "the load cell",
}
_NAMES: Mapping[Variable, str] = {
    "stroke": "the stroke",
    "tension": "the tension",
    "curvature": "the curvature",
    "bending_length": "the bending length",
    "position": "the place along the segment",
    "time": "time",
    "rate": "the speed of the drive",
    "path": "the path travelled",
    "run": "the number of the run",
}


def subject(law: UnnamedLaw) -> str:
    """Return the component that a law belongs to, e.g. ``the structure``."""
    return _SUBJECTS[law.place]


def added_by(law: UnnamedLaw, display: Display) -> str:
    """Return what a law adds and how its curve runs, a noun with numbers and units."""
    words = _Words(law, display)
    if law.memory == "friction":
        return f"{_AGAINST[law.place]}, {words.runs(words.y, participle=True)}"
    if law.memory == "step":
        return f"{words.signed} of {words.much(abs(float(words.y[-1])))} that sets in at {law.setting:.3g} s"
    if law.memory == "period":
        swing, period = 0.5 * float(np.ptp(words.y)), f"{law.setting / words.scale:.3g} {words.per}"
        return f"{words.added} that swings by {words.much(swing)} with {words.name}, period {period}"
    if law.memory == "relaxation":
        return words.late()
    if law.variable == "rate":
        return f"{words.added} that {words.runs(words.y)}"
    return f"{words.signed} that {words.runs(words.sign * words.y)}"


class _Words:
    """One law's curve in display units, x and y, and its parts of speech."""

    def __init__(self, law: UnnamedLaw, display: Display) -> None:
        self.law = law
        self.symbol, self.per, self.scale = display.axis(law)
        self.unit, size = display.amplitude(law)
        along, values = curve_of(law)
        self.x, self.y = along / self.scale, values / size
        self.name = "the bend" if self.symbol == "theta" else _NAMES[law.variable]
        above = _ADDED[law.place]
        self.added = "an added tension" if law.place == "drive" and self.unit == "N" else above[0]
        below = "a lost tension" if law.place == "drive" and self.unit == "N" else above[1]
        self.sign = -1.0 if float(self.y.max()) < _LEVEL * -float(self.y.min()) else 1.0
        self.signed = self.added if self.sign > 0.0 else below

    def much(self, value: float) -> str:
        """Return an amount with its unit."""
        return f"{_number(value)} {self.unit}".rstrip()

    def late(self) -> str:
        """Return a lag: what comes late, or comes at once and fades."""
        slope = float(np.linalg.lstsq(self.x[:, np.newaxis], self.y, rcond=None)[0][0])
        ratio = (
            f"{self.much(abs(slope))} per {self.per}" if self.unit != self.per else f"{_number(100.0 * abs(slope))} %"
        )
        how = "comes late" if slope > 0.0 else "comes at once and fades"
        what = f"a part of what {subject(self.law)} shows" if self.law.kind == "sensor" else self.added
        return f"{what} that {how}, {ratio} of {self.name}, with a time constant of {self.law.setting:.2g} s"

    def runs(self, y: FloatArray, *, participle: bool = False) -> str:
        """Return how a curve runs: constant, up or down, from where and to where, or over one turn, or several."""
        ing = {"rises": "rising", "falls": "falling", "goes": "going"} if participle else {}
        over, span = self._over(), float(np.ptp(y))
        if span <= _LEVEL * float(np.max(np.abs(y), initial=0.0)):
            return f"{'' if participle else 'is '}{self.much(float(np.mean(y)))} throughout"
        turns = _turns(y, _TURN * span)
        verbs = ["rises" if after > before else "falls" for before, after in pairwise(y[turns].tolist())]
        first = ing.get(verbs[0], verbs[0])
        if len(verbs) == 1:
            return f"{first} with {over} {self._one_way(y)}"
        if len(verbs) == 2:
            top, end = self._at(y, turns[1]), self._at(y, turns[2])
            then = ing.get(verbs[1], verbs[1])
            return f"{first} with {over} from {self._at(y, 0)} to {top} and then {then} to {end}"
        low, high = _number(float(y.min())), self.much(float(y.max()))
        return f"{ing.get('goes', 'goes')} up and down with {over}, between {low} and {high}"

    def _at(self, y: FloatArray, place: int) -> str:
        return f"{self._size(y, place)} at {_number(float(self.x[place]))} {self.per}".rstrip()

    def _size(self, y: FloatArray, place: int) -> str:
        return self.much(float(y[place]) if abs(y[place]) > _NOTHING * float(np.max(np.abs(y))) else 0.0)

    def _one_way(self, y: FloatArray) -> str:
        """Return both ends of a curve that runs one way, and where it begins or ends to change if not all along."""
        moved = np.abs(y - y[0]) / float(np.ptp(y))
        begins, ends = int(np.argmax(moved > _TURN)), int(np.argmax(moved > 1.0 - _TURN))
        reach = float(np.ptp(self.x))
        if self.x[begins] - self.x[0] > _LATE * reach:
            return f"beyond {_number(float(self.x[begins]))} {self.per}, from {self._size(y, 0)} to {self._at(y, -1)}"
        if self.x[-1] - self.x[ends] > _LATE * reach:
            return f"from {self._at(y, 0)} to {self._at(y, ends)} and stays there"
        return f"from {self._at(y, 0)} to {self._at(y, -1)}"

    def _over(self) -> str:
        if self.law.memory == "maximum":
            return f"the largest {self.name.removeprefix('the ')} so far"
        if self.law.memory == "path":
            return f"the path that {self.name} has travelled"
        return self.name


def _turns(y: FloatArray, least: float) -> list[int]:
    """Return where a curve begins, turns by more than ``least``, and ends."""
    found, way, extreme = [0], 0.0, 0
    for place in range(1, y.size):
        step = float(y[place] - y[extreme])
        if way == 0.0:
            way = np.sign(step) if abs(step) > least else 0.0
            extreme = place if way else extreme
        elif step * way >= 0.0:
            extreme = place
        elif abs(step) > least:
            found.append(extreme)
            extreme, way = place, -way
    return [*found, y.size - 1]


def _number(value: float) -> str:
    """Return a number with two digits, three from a hundred on, without an exponent where it can do without."""
    shown = f"{value:.2g}" if abs(value) < 99.5 else f"{value:.3g}"
    return f"{float(shown):g}"
