"""The style that pictures of designs share, and how a picture becomes a file; matplotlib is the [plot] extra.

Colours are those of Okabe and Ito, which colour-blind readers and grey printers tell apart.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from coast_cli.errors import UsageError
from coast_cli.output.atomic import write_files

FORMATS = (".png", ".svg", ".pdf")
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKS = ("o", "s", "^", "D", "v", "P", "X")
_STYLE: Any = {
    "svg.hashsalt": "coast",
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "0.92",
    "axes.axisbelow": True,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}


def draw(path: Path, size: tuple[float, float], paint: Callable[[Any], object]) -> None:
    """Write a picture of ``size`` (inches), painted onto a matplotlib Figure; the same data gives the same bytes.

    Raises:
        UsageError: matplotlib is not installed, the suffix is no picture, or the file cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise UsageError(f"--plot {path}: the suffix does not say a picture; allowed: {', '.join(FORMATS)}.")
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError:
        raise UsageError("plots need matplotlib: install coast-cli[plot].") from None
    undated = {".pdf": "CreationDate", ".svg": "Date"}.get(suffix, "Software")
    with rc_context(_STYLE):
        figure = Figure(figsize=size, layout="constrained")
        paint(figure)
        write_files(
            {path: lambda stream: figure.savefig(stream, format=suffix[1:], dpi=150, metadata={undated: None})},
            binary=True,
        )
