"""Beams of alike pitches: the two pieces of one pitch stand for all, so that their numbers stay in the first cache."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from coast_cli.mechanics.beam.problem import BeamProblem, Piece, Ripple, cell_ends
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class PeriodicProblem:
    """m beams of ``repeats`` alike pitches of two pieces; ``pitch`` is one of them, with the loads of the whole beam."""

    pitch: BeamProblem
    repeats: int

    @property
    def piece_count(self) -> int:
        """Number of pieces."""
        return 2 * self.repeats

    @property
    def count(self) -> int:
        """Number of beams."""
        return self.pitch.count

    @property
    def base(self) -> FloatArray:
        """Angle of the clamp, rad."""
        return self.pitch.base

    @property
    def tip_loads(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Thrust, shear and moment at the tip."""
        return self.pitch.tip_loads

    @property
    def pieces(self) -> Sequence[Piece]:
        """The pieces from tip to clamp: the same two rows again and again."""
        return [*self.pitch.pieces] * self.repeats

    @cached_property
    def whole_load(self) -> FloatArray:
        """Size of all forces, N."""
        return self.pitch.whole_load * self.repeats

    def turn_bounds(self, moment: FloatArray) -> FloatArray:
        """Return what ``BeamProblem.turn_bounds`` does, shape (2n, m)."""
        return np.tile(self.pitch.turn_bounds(moment, self.whole_load), (self.repeats, 1))

    def coarse(self, cells: int) -> BeamProblem:
        """Return what ``BeamProblem.coarse`` does."""
        chosen = cell_ends(self.piece_count, cells)
        pitches = np.diff(chosen)[:, None] / 2.0

        def merged(column: FloatArray) -> FloatArray:
            if chosen.size == 0:
                return np.tile(column, (self.repeats, 1))
            half = column[:1] / 2.0
            return np.concatenate((half, pitches * (column[0] + column[1]), half, column[1:]))

        return self.pitch.changed(merged)

    def ripple(self, cells: int) -> Ripple:
        """Return what ``BeamProblem.ripple`` does."""
        chosen = cell_ends(self.piece_count, cells)
        found = Ripple(*np.zeros((4, chosen.size + 2 if chosen.size else self.piece_count, self.count)))
        columns = self.pitch.length, self.pitch.flexibility, self.pitch.load
        found.fill(slice(1, chosen.size), *((column[0] / 2.0, column[1], column[0] / 2.0) for column in columns))
        return found
