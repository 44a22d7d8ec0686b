"""What a recording is once it is read: runs of arrays in SI units, each sample with the line it came from.

Angles are in radians, curvatures in 1/m, lengths in metres, forces in newtons, times in seconds. A run is one
continuous history, its samples in order; a dropped frame is NaN in the response and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Generic, Literal, TypeVar

from coast_cli.rows import short_repr

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from coast_cli.recordings.branches import Branches

    Floats = NDArray[np.float64]
    Integers = NDArray[np.int64]

ResponseKind = Literal["curvature", "bend", "notch", "position", "force"]
Natural = Literal["up", "down"]


@dataclass(frozen=True, eq=False)
class JointRun:
    """One history of a tendon-driven joint of ``n`` samples.

    Attributes:
        name: the run, unique in the recording.
        source: the file it came from, as the user named it.
        line: line of each sample in that file, [n], counted from 1.
        time: [n] s, or None where the recording has no clock.
        outer: name of the outer tube, or None for a joint of one notched tube.
        middle: name of the middle tube; empty for a device without tubes.
        bending_length: X2, [n] m; NaN for a device without one.
        stroke: X1 as commanded, deadband included, [n] m, or None for a joint driven by tension.
        tension: at the actuator, [n] N, or None.
        response: [n, k], NaN where the frame was dropped; k = 1, or the number of notches for ``kind = "notch"``.
        kind: "curvature" (1/m), "bend" of the whole segment (rad), "notch", the bend of each from the clamp (rad), or of
            other devices "position" (m) and "force" (N).
        load: force that the far end carries, [n] N, or None.
        load_moment: moment that the far end carries, [n] N m, or None.
    """

    __repr__ = short_repr

    name: str
    source: str
    line: Integers
    time: Floats | None
    outer: str | None
    middle: str
    bending_length: Floats
    stroke: Floats | None
    tension: Floats | None
    response: Floats
    kind: ResponseKind
    load: Floats | None = None
    load_moment: Floats | None = None

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.line)

    @property
    def carried(self) -> Floats | None:
        """What the far end carries, [n], N or N m; None where that was not recorded."""
        return self.load if self.load is not None else self.load_moment

    @property
    def pair(self) -> str:
        """The tubes as the user writes them: ``OUTER/MIDDLE``, or the middle tube alone."""
        return f"{self.outer}/{self.middle}" if self.outer else self.middle

    @property
    def drive(self) -> Floats:
        """What moved the joint, [n]: the stroke (m) where there is one, else the tension (N)."""
        drive = self.stroke if self.stroke is not None else self.tension
        if drive is None:
            raise ValueError("a joint run needs a stroke or a tension")
        return drive

    def only(self, rows: slice | NDArray[np.bool_]) -> JointRun:
        """Return some of the run's samples, in their order."""
        parts = ("line", "time", "bending_length", "stroke", "tension", "response", "load", "load_moment")
        known = {name: value for name in parts if (value := getattr(self, name)) is not None}
        return replace(self, **{name: value[rows] for name, value in known.items()})

    @cached_property
    def branches(self) -> Branches:
        """Load and release branches, holds and cycles, found from the drive."""
        from coast_cli.recordings.branches import find_branches

        return find_branches(self.drive, self.time)

    @property
    def direction(self) -> Integers:
        """How the drive moved to reach each sample, [n]: +1 load, -1 release, 0 hold."""
        return self.branches.direction

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Samples with a whole response, [n]."""
        import numpy as np

        whole: NDArray[np.bool_] = np.all(np.isfinite(self.response), axis=1)
        return whole


@dataclass(frozen=True, eq=False)
class ShapeRun:
    """Points along one tube, or one assembled pair, from the clamp to the tip.

    Attributes:
        name, source, line: as in `JointRun`.
        outer, middle: tube names; one of them is None for a single tube.
        x, y: [n] m, x along the clamped direction, gravity along -y.
        natural: side to which the natural curvature points, or None where it is not said.
    """

    __repr__ = short_repr

    name: str
    source: str
    line: Integers
    outer: str | None
    middle: str | None
    x: Floats
    y: Floats
    natural: Natural | None

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.line)

    @property
    def pair(self) -> str:
        """The tube's name, or ``OUTER/MIDDLE`` for an assembled pair."""
        return "/".join(name for name in (self.outer, self.middle) if name)


_MOST_SHOWN = 10
Run = TypeVar("Run", bound=JointRun | ShapeRun)


@dataclass(frozen=True, eq=False)
class Recording(Generic[Run]):
    """Runs of one kind.

    Attributes:
        kind: "joint" or "shape".
        runs: in the order of the files; names are unique.
        sources: (path as given, SHA-256 of the bytes) of each file.
        notes: what the user should know, one sentence each.
    """

    kind: Literal["joint", "shape"]
    runs: tuple[Run, ...]
    sources: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Recordings:
    """What one call was given: joint recordings, shapes, or both, in m, N, s, rad and 1/m; at least one of them is there."""

    joint: Recording[JointRun] | None = None
    shape: Recording[ShapeRun] | None = None
    sources: tuple[tuple[str, str], ...] = field(default=())
    notes: tuple[str, ...] = field(default=())

    def __repr__(self) -> str:
        """Return which runs there are, in a few lines."""
        joint, shape = self.joint.runs if self.joint else (), self.shape.runs if self.shape else ()
        lines = [f"  {run.name}: {run.pair}, {len(run)} rows" for run in joint[:_MOST_SHOWN]]
        lines += [f"  {run.name}: {run.pair}, {len(run)} points" for run in shape[:_MOST_SHOWN]]
        more = len(self.run_names) - len(lines)
        return "\n".join([f"Recordings: {len(self.run_names)} runs", *lines, *([f"  and {more} more"] if more else [])])

    @property
    def run_names(self) -> tuple[str, ...]:
        """Names of all runs, joints first."""
        joint = tuple(run.name for run in self.joint.runs) if self.joint else ()
        shape = tuple(run.name for run in self.shape.runs) if self.shape else ()
        return joint + shape
