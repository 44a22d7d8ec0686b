"""How columns share the width of a terminal: the important ones first, long texts folded, the rest left out and named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from unicodedata import combining, east_asian_width

GAP = 2
_FOLDS_FROM = 24  # characters; a text that is wider may be folded
_NARROWEST_TEXT = 16
_LONGEST_WORD = 30  # that is not broken, as the names of effects and of figures are


@dataclass(frozen=True)
class LaidColumn:
    """A column of a table: its name, the lines of its heading, its cells as texts, and on which side they stand."""

    name: str
    heading: list[str]
    cells: list[str]
    to_right: bool

    @property
    def width(self) -> int:
        """What it takes unfolded."""
        return max(map(cell_width, (*self.heading, *self.cells)))

    @property
    def least(self) -> int:
        """What it takes at least."""
        if self.to_right or self.width <= _FOLDS_FROM:
            return self.width
        longest = max(cell_width(word) for cell in self.cells for word in cell.split(" "))
        return max(_NARROWEST_TEXT, min(longest, _LONGEST_WORD), *map(len, self.heading))


def choose(columns: Sequence[LaidColumn], order: Sequence[str], width: int) -> list[LaidColumn]:
    """Return the columns that fit side by side, in their own order: the most important first, as ``order`` has them."""
    ranked = sorted(columns, key=lambda column: order.index(column.name) if column.name in order else len(order))
    taken, room = set[str](), width + GAP
    for column in ranked:
        if column.least + GAP <= room:
            taken.add(column.name)
            room -= column.least + GAP
    return [column for column in columns if column.name in taken]


def widths(columns: Sequence[LaidColumn], width: int | None) -> list[int]:
    """Return the width of each column; what is left of ``width`` goes to folded ones, from the left."""
    if width is None:
        return [column.width for column in columns]
    found = [column.least for column in columns]
    room = width - sum(found) - GAP * (len(found) - 1)
    for place, column in enumerate(columns):
        more = min(column.width - found[place], max(room, 0))
        found[place] += more
        room -= more
    return found


def fits(columns: Sequence[LaidColumn], width: int) -> bool:
    """Say whether columns stand side by side in a width."""
    return sum(column.least for column in columns) + GAP * (len(columns) - 1) <= width


def cell_width(text: str) -> int:
    """Return how many columns of a terminal a text takes: two for a wide character, none for a combining one."""
    if text.isascii():
        return len(text)
    return sum(0 if combining(mark) else 2 if east_asian_width(mark) in "WF" else 1 for mark in text)


def fold(text: str, width: int) -> list[str]:
    """Break a text into lines of at most ``width`` at its spaces, and within a word only where it must be."""
    lines = [""]
    for word in text.split(" "):
        joined = f"{lines[-1]} {word}" if lines[-1] else word
        if cell_width(joined) <= width:
            lines[-1] = joined
            continue
        if lines[-1]:
            lines.append("")
        for mark in word:
            if cell_width(lines[-1] + mark) > width:
                lines.append("")
            lines[-1] += mark
    return lines


def pad(text: str, width: int, *, to_right: bool) -> str:
    """Fill a text up with spaces, before it where it stands right."""
    space = " " * (width - cell_width(text))
    return space + text if to_right else text + space
