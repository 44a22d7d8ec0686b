"""The style that all pictures share, and how a picture becomes bytes or a file; matplotlib is the [plot] extra.

Colours are those of Okabe and Ito, which colour-blind readers and grey printers tell apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings, filterwarnings

from coast_cli.errors import UsageError
from coast_cli.output.atomic import write_files

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg", ".pdf")
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
RECORDED = "0.45"  # grey: what was seen, beside models in colours
MARKS = ("o", "s", "^", "D", "v", "P", "X")
_UNDATED = {"pdf": "CreationDate", "svg": "Date", "png": "Software"}  # what would tell the clock or the version
_STYLE: Any = {
    "svg.hashsalt": "coast",
    "text.parse_math": False,  # a name with $ in it is a name
    "savefig.dpi": 150,
    "font.size": 9.0,
    "legend.fontsize": 8.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "0.92",
    "axes.axisbelow": True,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}


@dataclass(frozen=True)
class Picture:
    """What is drawn: its size (width and height in inches) and how it is painted onto a matplotlib Figure."""

    size: tuple[float, float]
    paint: Callable[[Any], object]

    def render(self, format: str) -> bytes:
        """Return the picture as ``png``, ``svg`` or ``pdf``; the same data gives the same bytes.

        Raises:
            UsageError: matplotlib is not installed.
        """
        stream = BytesIO()
        with _styled():
            self._painted().savefig(stream, format=format, metadata={_UNDATED[format]: None})
        return stream.getvalue()

    def figure(self) -> Figure:
        """Return the picture on a new matplotlib Figure, to be changed further.

        Raises:
            UsageError: matplotlib is not installed.
        """
        with _styled():
            return self._painted()

    def _painted(self) -> Figure:
        from matplotlib.figure import Figure

        figure = Figure(figsize=self.size, layout="constrained")
        self.paint(figure)
        _settle(figure)
        return figure

    def _repr_png_(self) -> bytes | None:
        """Return the picture for a notebook; without matplotlib it shows as text."""
        return self.render("png") if can_draw() else None

    def write(self, path: str | Path) -> None:
        """Write the picture in the format of the suffix.

        Raises:
            UsageError: matplotlib is not installed, the suffix is no picture, or the file cannot be written.
        """
        path = Path(path)
        suffix = path.suffix.lower()
        if suffix not in FORMATS:
            raise UsageError(f"picture {path}: the suffix does not say a picture; allowed: {', '.join(FORMATS)}.")
        content = self.render(suffix[1:])
        write_files({path: lambda stream: stream.write(content)}, binary=True)


@contextmanager
def _styled() -> Iterator[None]:
    require_matplotlib()
    from matplotlib import rc_context

    with rc_context(_STYLE), catch_warnings():
        filterwarnings("ignore", "Glyph .* missing")  # a name in a script that the font lacks
        yield


def short(name: str, most: int = 20) -> str:
    """Return a name that leaves room for what it is drawn beside."""
    return name if len(name) <= most else name[: most - 1] + "…"


def can_draw() -> bool:
    """Return whether matplotlib is installed."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        return False
    return True


def require_matplotlib() -> None:
    """Refuse to draw where matplotlib is not installed.

    Raises:
        UsageError: saying what to install.
    """
    if not can_draw():
        raise UsageError("plots and reports need matplotlib: pip install matplotlib.")


def _settle(figure: Any) -> None:  # noqa: ANN401
    """Solve the layout once and round it: the solver's last digits change from call to call."""
    import numpy as np

    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.get_axes():
        axes.set_position(np.round(axes.get_position(original=True).bounds, 6))
