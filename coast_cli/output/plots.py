"""The picture of a result, as its command's ``--plot`` draws it."""

from __future__ import annotations

from functools import singledispatch

from coast_cli.design.exploration import Exploration
from coast_cli.design.path import PathPlan
from coast_cli.design.rank import Ranking
from coast_cli.design.stroke import StrokeTable
from coast_cli.diagnosis.answer import Diagnosis
from coast_cli.diagnosis.compare import Comparison
from coast_cli.output.comparison_plot import plot_comparison
from coast_cli.output.design_plot import plot_front, plot_pairs, plot_strokes
from coast_cli.output.diagnosis_plot import plot_diagnosis
from coast_cli.output.path_plot import plot_path
from coast_cli.output.picture import Picture, require_matplotlib


@singledispatch
def _picture(result: object) -> Picture:
    raise TypeError(f"there is no picture of a {type(result).__name__}")


_picture.register(Ranking, lambda one: plot_pairs(one.columns, one.rigidity))
_picture.register(StrokeTable, lambda one: plot_strokes(one.columns))
_picture.register(Exploration, lambda one: plot_front(one.rows, one.bench.columns, one.rigidity))
_picture.register(PathPlan, plot_path)
_picture.register(Comparison, lambda one: plot_comparison(one)[0])
_picture.register(Diagnosis, plot_diagnosis)


def picture_of(result: object) -> Picture:
    """Return the picture of a result.

    Raises:
        UsageError: matplotlib is not installed.
        TypeError: there is no picture of such a result.
    """
    require_matplotlib()
    return _picture(result)
