"""Labels of every kind of figure: inside it, clear of each other, and large enough to be read at half size.

Boxes are those that matplotlib itself draws, so that no browser and no picture of another machine is needed.
"""

from itertools import combinations

import pytest

import coast_cli as coast
from tests.conftest import REFERENCE, ROOT

pytest.importorskip("matplotlib", reason="not here: matplotlib, the extra [plot]")

RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"
SMALLEST_POINTS = 7.5  # at half size as large as a footnote's index
OVERLAP = 1.0  # pixels that boxes may share: they have a margin round their letters


@pytest.fixture(scope="module")
def pictures():
    from coast_cli.design.shape import shape_columns
    from coast_cli.output.design_plot import plot_shapes, plot_tolerance
    from coast_cli.output.diagnosis_plot import plot_place

    config = coast.load_config(REFERENCE)
    design = coast.build(config)
    recordings = coast.read_recordings(RECORDING, config)
    diagnosis = coast.diagnose(config, recordings, max_effects=1)
    table = coast.stroke_table(design.joint(), [0.02, 0.03, 0.04], curvatures=[10.0, 20.0, 30.0, 40.0])
    path = coast.read_path(ROOT / "examples" / "path" / "branch.csv")
    plan = coast.plan_path(design.joint(), design.effects, path, path.rows, within=2e-3)
    rows, _, sampled = coast.tolerance_rows(design, "OT4/MT1", samples=64, seed=0, ranked=False, index_samples=2)
    shapes = shape_columns(list(design.middle), design.gravity, method="arc", points=51)
    return {
        "ranking": coast.rank(config).plot(),
        "strokes": table.plot(),
        "comparison": coast.compare(config, recordings).plot(),
        "diagnosis": diagnosis.plot(),
        "place": plot_place(diagnosis),
        "path": plan.plot(),
        "tolerance": plot_tolerance("OT4/MT1", rows, sampled),
        "shapes": plot_shapes(shapes),
    }


def drawn(picture):
    """Return the boxes of all labels of a figure, by what they say, its legends, and its own box."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    figure = picture.figure()
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    legends = [one for axes in (*figure.get_axes(), figure) for one in axes.findobj(is_legend)]
    hidden = unseen(figure) | {id(text) for legend in legends for text in legend.findobj(Text)}
    texts = [
        text
        for text in figure.findobj(Text)
        if text.get_visible() and text.get_text().strip() and id(text) not in hidden
    ]
    labels = {id(text): (text.get_text(), text.get_window_extent(renderer), text.get_fontsize()) for text in texts}
    frames = {id(one): one.get_window_extent(renderer) for one in legends}
    return list(labels.values()), list(frames.values()), figure.bbox


def is_legend(artist):
    return type(artist).__name__ == "Legend"


def unseen(figure):
    """Return the labels of ticks outside their axes, and of axes that are not shown, by identity."""
    found = set()
    for axes in figure.get_axes():
        if not axes.get_visible():
            found |= {id(text) for text in axes.findobj(is_text)}
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            edge = 1e-9 * (high - low)
            ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
            outside = [tick for tick in ticks if not low - edge <= tick.get_loc() <= high + edge]
            found |= {id(label) for tick in outside for label in (tick.label1, tick.label2)}
    return found


def is_text(artist):
    return hasattr(artist, "get_text")


def shared(one, other):
    """Return how many pixels two boxes share in the direction in which they share less."""
    across = min(one.x1, other.x1) - max(one.x0, other.x0)
    along = min(one.y1, other.y1) - max(one.y0, other.y0)
    return min(across, along)


NAMES = ["ranking", "strokes", "comparison", "diagnosis", "place", "path", "tolerance", "shapes"]


@pytest.mark.parametrize("name", NAMES)
def test_labels_are_inside_and_clear_of_each_other(pictures, name):
    labels, legends, whole = drawn(pictures[name])
    assert len(labels) >= 4
    for said, box, _ in labels:
        assert min(box.x0 - whole.x0, box.y0 - whole.y0, whole.x1 - box.x1, whole.y1 - box.y1) >= -OVERLAP, said
    meeting = [(a[0], b[0]) for a, b in combinations(labels, 2) if shared(a[1], b[1]) > OVERLAP]
    assert meeting == []
    for one, other in combinations(legends, 2):
        assert shared(one, other) <= OVERLAP


@pytest.mark.parametrize("name", NAMES)
def test_letters_are_read_at_half_size(pictures, name):
    labels, _, _ = drawn(pictures[name])
    assert min(size for _, _, size in labels) >= SMALLEST_POINTS


def test_the_test_sees_labels_that_collide():
    from coast_cli.output.picture import Picture

    def paint(figure):
        axes = figure.subplots()
        axes.plot([0.0, 1.0])
        for place in (0.5, 0.51):
            axes.annotate("a name", (place, 0.5))

    labels, _, _ = drawn(Picture((3.0, 2.0), paint))
    names = [box for said, box, _ in labels if said == "a name"]
    assert shared(*names) > OVERLAP
