"""The forward model of shapes: many parameter sets of many photographs in one batch of beams.

A tube is the beam of ``mechanics.beam`` with its natural curvature turned to the side it lies on. An assembled pair is one
beam over the overlap, rigidities and weights summed and natural curvature their rigidity-weighted mean (P (8), coupled):
a photographed pair sags as one. Long tubes are homogenised over whole pitches, cell ends in the middle of rings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.shapes.photograph import Photograph
from coast_cli.effects.effect import acting
from coast_cli.effects.shape_stages import Loads, OnBench, OnImage, OnPair, OnPieces, OnShapes, Pieces
from coast_cli.effects.stages import OnTubes
from coast_cli.mechanics.beam import solve_segments
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube

_CELLS = 56
_SAME_NODE = 1e-9
_CACHED = 512


@dataclass(frozen=True, slots=True)
class State:
    """One set of parameters: modulus (Pa) and natural curvature (1/m, towards its own side) by tube number; effects.

    ``spread``: by how much a tube differs from what an effect has for all of them, as a share, by tube number.
    """

    modulus: Mapping[int, float]
    natural: Mapping[int, float]
    effects: tuple[OnShapes, ...]
    spread: Mapping[int, float]


Job = tuple[int, State]


@dataclass(frozen=True, slots=True)
class Line:
    """The model's line at the points of one photograph, for m states, each (m, n).

    Attributes:
        x, y: m. along_x, along_y: unit tangent. curvature: 1/m.
    """

    x: FloatArray
    y: FloatArray
    along_x: FloatArray
    along_y: FloatArray
    curvature: FloatArray


@dataclass(frozen=True, slots=True)
class _Layout:
    """How a photograph's pieces become cells: common pieces, cell starts, and where its points lie among the nodes."""

    own: tuple[NDArray[np.int64], ...]
    length: FloatArray
    chosen: NDArray[np.int64] | None
    nodes: FloatArray
    cell: NDArray[np.int64]
    local: FloatArray


class Forward:
    """The forward model of a set of photographs under one gravity (m/s^2)."""

    def __init__(self, photographs: Sequence[Photograph], gravity: float) -> None:
        self.photographs = tuple(photographs)
        self.gravity = gravity
        self._layouts = {fine: tuple(_layout(p, fine=fine) for p in photographs) for fine in (False, True)}
        self._pieces: dict[tuple[object, ...], Pieces] = {}

    def lines(self, jobs: Sequence[Job]) -> list[Line]:
        """Return the line of each job, each of shape (1, n); all beams of one fineness are solved together."""
        fine = [any(effect.is_local for effect in state.effects) for _, state in jobs]
        found: list[Line | None] = [None] * len(jobs)
        for fineness in sorted(set(fine)):
            places = [place for place, own in enumerate(fine) if own is fineness]
            lines = self._alike([jobs[place] for place in places], self._layouts[fineness])
            for place, line in zip(places, lines, strict=True):
                found[place] = self._seen(*jobs[place], line)
        return [line for line in found if line is not None]

    def _alike(self, jobs: Sequence[Job], layouts: tuple[_Layout, ...]) -> list[Line]:
        beams = [self._beam(index, state, layouts[index]) for index, state in jobs]
        most = max(beam.length.size for beam in beams)

        def table(name: str, filler: float) -> FloatArray:
            filled = np.full((len(beams), most), filler)
            for row, beam in zip(filled, beams, strict=True):
                values = getattr(beam, name)
                row[: values.size] = values
            return filled

        length, flexibility, bend = table("length", 0.0), table("flexibility", 1.0), table("bend", 0.0)
        rigidity = np.where(length > 0.0, length / flexibility, 1.0)
        span = np.where(length > 0.0, length, 1.0)
        pull = np.array([beam.loads.gravity * self.gravity for beam in beams])
        force = np.array([beam.loads.upward_force for beam in beams])
        zero = np.zeros(len(beams))
        solved = solve_segments(
            length,
            rigidity,
            table("load", 0.0) / span,
            bend / span,
            gravity=np.stack([zero, -pull], axis=1),
            tip_force=np.stack([zero, force], axis=1),
            base_angle=np.array([beam.loads.base_angle for beam in beams]),
        )
        found: dict[int, Line] = {}
        groups: dict[int, list[int]] = {}
        for place, (index, _) in enumerate(jobs):
            groups.setdefault(index, []).append(place)
        for index, places in groups.items():
            count = layouts[index].nodes.size
            rows = np.array(places)
            parts = [array[rows][:, :count] for array in (solved.x, solved.y, solved.angle)]
            line = self._line(layouts[index], [beams[place] for place in places], parts)
            for row, place in enumerate(places):
                at = slice(row, row + 1)
                found[place] = Line(line.x[at], line.y[at], line.along_x[at], line.along_y[at], line.curvature[at])
        return [found[place] for place in range(len(jobs))]

    def _beam(self, index: int, state: State, layout: _Layout) -> _Beam:
        photograph = self.photographs[index]
        loads = Loads()
        for effect in acting(state.effects, OnBench):
            if photograph.is_pair or not isinstance(effect, OnPair):
                loads = effect.loads(loads)
        rigidity, weight, natural, sideways = (np.zeros(layout.length.size) for _ in range(4))
        offset = np.zeros(layout.length.size)
        for place, ((number, tube), own) in enumerate(zip(photograph.tubes, layout.own, strict=True)):
            pieces = self._tube_pieces(number, tube, state)
            stiff = state.modulus[number] * pieces.rigidity[own]
            side = photograph.upward if place == 0 else -photograph.upward
            curved = stiff * side * (state.natural[number] * pieces.own[own] + pieces.natural[own])
            rigidity += stiff
            weight += pieces.weight[own]
            natural += curved * np.cos(loads.roll) if place else curved
            if place:
                sideways += curved * np.sin(loads.roll)
            else:
                offset = photograph.upward * pieces.offset[own]
        return _cells(
            layout, rigidity, weight, natural / rigidity + loads.held_curvature, sideways / rigidity, offset, loads
        )

    def _tube_pieces(self, number: int, tube: NotchedTube, state: State) -> Pieces:
        """Return the pieces of a tube of unit modulus without its own natural curvature."""
        acting = tuple(
            effect.differing(state.spread.get(number, 0.0))
            for effect in state.effects
            if effect.acts_on(number) and isinstance(effect, OnTubes | OnPieces)
        )
        key = (number, acting)
        if key not in self._pieces:
            if len(self._pieces) > _CACHED:
                self._pieces.clear()
            self._pieces[key] = _pieces_of(tube, acting)
        return self._pieces[key]

    def _line(self, layout: _Layout, beams: Sequence[_Beam], parts: Sequence[FloatArray]) -> Line:
        """Return the line at the points: arcs between nodes, stretched and turned out of the plane where effects say so."""
        x, y, angle = parts
        dx, dy, turn = np.diff(x), np.diff(y), np.diff(angle)
        changed = False
        for row, beam in enumerate(beams):
            if beam.loads.axis_share:
                elastic = turn[row] - beam.bend
                shrink = beam.loads.axis_share * (beam.offset_bend + beam.offset_share * elastic)
                dx[row] *= 1.0 - shrink / beam.length
                dy[row] *= 1.0 - shrink / beam.length
                changed = True
            if beam.loads.roll:
                turned = np.cumsum(beam.sideways) - beam.sideways / 2.0
                dx[row] *= np.cos(turned)
                dy[row] *= np.cos(turned)
                changed = True
        if changed:
            start = np.zeros((len(beams), 1))
            x, y = (np.concatenate((start, np.cumsum(d, axis=1)), axis=1) for d in (dx, dy))
        return _interpolated(layout, x, y, angle)

    def _seen(self, index: int, state: State, line: Line) -> Line:
        """Return the line as the camera shows it."""
        seeing = acting(state.effects, OnImage)
        if not seeing:
            return line
        run = self.photographs[index].run
        centre = float(run.x.mean()), float(run.y.mean())
        small = 1e-6
        ends = []
        for step in (0.0, small):
            x, y = line.x + step * line.along_x, line.y + step * line.along_y
            for effect in seeing:
                x, y = effect.see(x, y, centre)
            ends.append((x, y))
        (x, y), (ahead_x, ahead_y) = ends
        size = np.hypot(ahead_x - x, ahead_y - y)
        return Line(x, y, (ahead_x - x) / size, (ahead_y - y) / size, line.curvature)


@dataclass(frozen=True, slots=True)
class _Beam:
    """One beam, cell by cell: length (m), flexibility (1/(N m)), natural turn (rad), mass (kg), turn out of the plane (rad).

    ``offset_bend`` and ``offset_share`` give the shortening of the line: from natural turn (m) and per elastic turn (m).
    """

    length: FloatArray
    flexibility: FloatArray
    bend: FloatArray
    load: FloatArray
    sideways: FloatArray
    offset_bend: FloatArray
    offset_share: FloatArray
    loads: Loads


def _cells(
    layout: _Layout,
    rigidity: FloatArray,
    weight: FloatArray,
    natural: FloatArray,
    sideways: FloatArray,
    offset: FloatArray,
    loads: Loads,
) -> _Beam:
    length = layout.length
    flexibility = length / rigidity
    columns = np.stack(
        [
            length,
            flexibility,
            natural * length,
            weight * length,
            sideways * length,
            offset * natural * length,
            offset * flexibility,
        ]
    )
    span, soft, bend, load, turn, shrink, share = _merged(columns, layout.chosen)
    return _Beam(span, soft, bend, load, turn, shrink, share / soft, loads)


def _merged(columns: FloatArray, chosen: NDArray[np.int64] | None) -> FloatArray:
    """Sum columns (k, n) over cells that end in the middle of the chosen pieces."""
    if chosen is None:
        return columns
    half = np.concatenate((columns[:, chosen] / 2.0, np.zeros((columns.shape[0], 1))), axis=1)
    cells = np.add.reduceat(columns, chosen, axis=1)
    return np.concatenate((half[:, :1], cells - half[:, :-1] + half[:, 1:]), axis=1)


def _pieces_of(tube: NotchedTube, effects: Sequence[OnShapes]) -> Pieces:
    tube = replace(tube, youngs_modulus=1.0)
    for effect in acting(effects, OnTubes):
        tube = effect.geometry(tube)
    segments = tube.segments
    offset = np.zeros(segments.length.size)
    offset[1::2] = tube.notch.neutral_axis
    none = np.zeros(segments.length.size)
    pieces = Pieces(segments.length, segments.rigidity, segments.weight, none, offset, none + 1.0)
    for local in acting(effects, OnPieces):
        pieces = local.pieces(pieces)
    return pieces


def _layout(photograph: Photograph, *, fine: bool) -> _Layout:
    ends = [np.cumsum(tube.segments.length) for _, tube in photograph.tubes]
    if len(ends) == 1 or (ends[0].size == ends[1].size and np.allclose(ends[0], ends[1], rtol=0.0, atol=_SAME_NODE)):
        own = tuple(np.arange(end.size) for end in ends)
        length = photograph.tubes[0][1].segments.length
        chosen = None
        if length.size > 2 * _CELLS and not fine:
            chosen = np.unique(np.linspace(0, (length.size - 1) // 2, _CELLS).round().astype(np.int64)) * 2
    else:
        breaks = np.unique(np.concatenate(ends).round(9))
        breaks = np.concatenate((breaks[breaks < photograph.length - _SAME_NODE], [photograph.length]))
        length = np.diff(breaks, prepend=0.0)
        middle = np.cumsum(length) - length / 2.0
        own = tuple(np.minimum(np.searchsorted(end, middle), end.size - 1) for end in ends)
        chosen = None
    cells = _merged(length[np.newaxis], chosen)[0]
    nodes = np.concatenate(([0.0], np.cumsum(cells)))
    cell = np.clip(np.searchsorted(nodes, photograph.at, side="right") - 1, 0, cells.size - 1)
    return _Layout(own, length, chosen, nodes, cell, (photograph.at - nodes[cell]) / cells[cell])


def _interpolated(layout: _Layout, x: FloatArray, y: FloatArray, angle: FloatArray) -> Line:
    """Return places at the points: each cell is an arc laid from its node, closed on the next one."""
    j, u = layout.cell, layout.local
    start, turn = angle[:, j], np.diff(angle)[:, j]
    h = np.diff(layout.nodes)[j]
    here = start + turn * u
    middle = start + 0.5 * turn * u
    chord = u * h * np.sinc(turn * u / (2.0 * np.pi))
    whole = h * np.sinc(turn / (2.0 * np.pi))
    half = start + 0.5 * turn
    miss_x = x[:, j + 1] - x[:, j] - whole * np.cos(half)
    miss_y = y[:, j + 1] - y[:, j] - whole * np.sin(half)
    return Line(
        x=x[:, j] + chord * np.cos(middle) + u * miss_x,
        y=y[:, j] + chord * np.sin(middle) + u * miss_y,
        along_x=np.cos(here),
        along_y=np.sin(here),
        curvature=turn / h,
    )


def missed_by(photograph: Photograph, line: Line) -> tuple[FloatArray, FloatArray]:
    """Return by how much the points miss a line across it, (m, n), and along it at the points that are placed, (m, k).

    A point that is not placed is compared with the nearest point of the line, to second order in the distance along it.
    """
    dx, dy = photograph.run.x - line.x, photograph.run.y - line.y
    across = dy * line.along_x - dx * line.along_y
    along = dx * line.along_x + dy * line.along_y
    free = ~photograph.placed
    across[:, free] -= 0.5 * line.curvature[:, free] * along[:, free] ** 2
    return across, along[:, photograph.placed]
