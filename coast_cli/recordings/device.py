"""What a recording was made on: the tubes that a file, an option or the configuration names, and the bending length."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import BadInput, nearest
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from collections.abc import Mapping

    from coast_cli.mechanics.tube import NotchedTube
    from coast_cli.recordings.columns import ColumnLayout
    from coast_cli.recordings.table import Table
    from coast_cli.spec.config import Config

SHORTEST = 1e-6  # m, of a bending length, as in a configuration


@dataclass(frozen=True)
class Defaults:
    """What a file may leave out, and the tubes that its names must be among (None where no config is given).

    ``has_tubes`` is None where it is not known whether the device has tubes: without a configuration.
    """

    outer: str | None = None
    middle: str | None = None
    bending_length: float | None = None
    outer_tubes: Mapping[str, NotchedTube] | None = None
    middle_tubes: Mapping[str, NotchedTube] | None = None
    has_tubes: bool | None = None


def defaults_of(config: Config | None, pair: str | None, bending_length_mm: float | None) -> Defaults:
    """Return what the files of a call may leave out.

    Raises:
        BadInput: the pair names a tube that is not there, or the length is not one.
    """
    outer_tubes = middle_tubes = has_tubes = None
    if config is not None:
        from coast_cli.spec.transmission import is_transmission

        has_tubes = not is_transmission(config)
    if config is not None and has_tubes:
        from coast_cli.spec.build import build

        design = build(config)
        outer_tubes = {tube.name: tube for tube in design.outer}
        middle_tubes = {tube.name: tube for tube in design.middle}
        pair = pair or design.joint_pair
    outer, middle = (None, None) if pair is None else split_pair(pair)
    for name, tubes in ((outer, outer_tubes), (middle, middle_tubes)):
        if name and tubes is not None and name not in tubes:
            raise BadInput(
                "the pair names a tube that the config does not have",
                found=name,
                allowed=", ".join(tubes) or "none",
                hint=nearest(name, tubes) or None,
            )
    length = None if bending_length_mm is None else bending_length_mm * MILLIMETRE
    if length is not None and not (np.isfinite(length) and length >= SHORTEST):
        allowed = f"a length in mm from {SHORTEST / MILLIMETRE:g}"
        raise BadInput("the bending length must be positive", found=bending_length_mm, allowed=allowed)
    return Defaults(outer, middle, length, outer_tubes, middle_tubes, has_tubes)


def split_pair(pair: str) -> tuple[str | None, str]:
    """Split ``OUTER/MIDDLE`` into its names; ``MIDDLE`` alone is a joint of one tube."""
    outer, slash, middle = pair.partition("/")
    if not slash:
        outer, middle = "", outer
    if not middle.strip() or "/" in middle:
        raise BadInput("not a pair of tubes", found=pair, allowed="OUTER/MIDDLE, or MIDDLE for a joint of one tube")
    return outer.strip() or None, middle.strip()


class TextColumn:
    """A text column asked run by run: the one text of a stretch of rows, refused where it changes within a run."""

    def __init__(self, table: Table, layout: ColumnLayout, quantity: str) -> None:
        self._table = table
        self._column = layout.columns.get(quantity)
        if self._column is not None:
            self._starts, self._texts = table.texts(self._column.name)

    def __bool__(self) -> bool:
        return self._column is not None

    @property
    def name(self) -> str | None:
        """The column's name in the file."""
        return self._column.name if self._column else None

    def of(self, start: int, stop: int) -> str:
        """Return the text of the rows from ``start`` to ``stop``."""
        if self._column is None:
            return ""
        first = int(np.searchsorted(self._starts, start, side="right")) - 1
        last = int(np.searchsorted(self._starts, stop - 1, side="right")) - 1
        texts = self._texts[first : last + 1]
        for offset, text in enumerate(texts):
            if text != texts[0]:
                raise self._table.error(
                    "changes within a run",
                    name=self.name,
                    row=int(self._starts[first + offset]),
                    found=text,
                    allowed=texts[0] or "empty",
                )
        return texts[0]


def _checked_tube(
    table: Table, column: TextColumn, start: int, name: str, tubes: Mapping[str, NotchedTube] | None
) -> str:
    if tubes is not None and name not in tubes:
        raise table.error(
            "a tube that the config does not have",
            name=column.name,
            row=start,
            found=name,
            allowed=", ".join(tubes) or "none",
            hint=nearest(name, tubes) or None,
        )
    return name


def joint_names(
    table: Table, outer: TextColumn, middle: TextColumn, stretch: tuple[int, int], defaults: Defaults
) -> tuple[str | None, str]:
    """Return the tubes of a joint run: each from its column where there is one, else from the default pair."""
    name_outer: str | None = defaults.outer
    name_middle: str | None = defaults.middle
    if outer:
        name_outer = outer.of(*stretch) or None
        if name_outer:
            _checked_tube(table, outer, stretch[0], name_outer, defaults.outer_tubes)
    if middle:
        name_middle = middle.of(*stretch) or None
        if name_middle:
            _checked_tube(table, middle, stretch[0], name_middle, defaults.middle_tubes)
    if name_middle is None and defaults.has_tubes:
        raise table.error(
            "no middle tube is named",
            name=middle.name,
            row=stretch[0],
            allowed="a middle column, a pair OUTER/MIDDLE, or joint.pair in the configuration",
        )
    return name_outer, name_middle or ""


def shape_tubes(
    table: Table, texts: Mapping[str, TextColumn], stretch: tuple[int, int], defaults: Defaults
) -> tuple[str | None, str | None]:
    """Return the tubes of a shape: from ``tube``, from ``outer`` and ``middle``, else the default pair."""
    if not texts["tube"]:
        if not texts["outer"] and not texts["middle"] and defaults.middle is None:
            raise table.error(
                "no tube is named", allowed="a tube column, outer and middle columns, or a pair for the file"
            )
        outer = texts["outer"].of(*stretch) if texts["outer"] else ""
        middle = texts["middle"].of(*stretch) if texts["middle"] else ""
        if not texts["outer"] and not texts["middle"]:
            return defaults.outer, defaults.middle
        if not outer and not middle:
            raise table.error("no tube is named", row=stretch[0], allowed="an outer tube, a middle tube or both")
        if outer:
            _checked_tube(table, texts["outer"], stretch[0], outer, defaults.outer_tubes)
        if middle:
            _checked_tube(table, texts["middle"], stretch[0], middle, defaults.middle_tubes)
        return outer or None, middle or None
    name = texts["tube"].of(*stretch)
    if not name:
        raise table.error("an empty cell", name=texts["tube"].name, row=stretch[0], allowed="the name of a tube")
    if "/" in name:
        outer_name, middle_name = split_pair(name)
        return outer_name, middle_name
    if defaults.outer_tubes is None or defaults.middle_tubes is None:
        return None, name
    known = {**defaults.outer_tubes, **defaults.middle_tubes}
    _checked_tube(table, texts["tube"], stretch[0], name, known)
    return (name, None) if name in defaults.outer_tubes else (None, name)
