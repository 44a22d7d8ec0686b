"""Exploring: the front against brute force, streams that resume, the same answer whoever does the work."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from coast_cli.design.exploration import Beginning, explore
from coast_cli.design.explore import explore_block, tasks
from coast_cli.design.front import Front, undominated
from coast_cli.design.work import results_in_order, workers
from coast_cli.errors import BadInput
from coast_cli.mechanics.pairs import pair_table
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config_text
from tests.one_pair import pair_figures

GRID = """
[explore]
sampling = "grid"
refinements = 0
[explore.outer]
depth_mm = { min = 0.314, max = 0.400, step = 0.0215 }
[explore.middle]
depth_mm = { min = 0.243, max = 0.287, step = 0.011 }
"""
SOBOL = """
[explore]
tubes = 64
refinements = 5
[explore.outer]
depth_mm = { min = 0.314, max = 0.400 }
[explore.middle]
depth_mm = { min = 0.243, max = 0.287 }
"""


def text_with(reference_text, table):
    """The reference input without limits, which would hide most of the space."""
    return reference_text[: reference_text.index("[checks]")] + table


def run(text, **options):
    config = load_config_text(text, "test.toml")
    found = explore(config, **{"every": True, **options})
    return list(found.rows), found.notes


def costs(rows):
    return np.array(
        [
            [r["total_precurvature_rad"], abs(np.log(r["rigidity_ratio_mean"])), r["total_rigidity_mean_n_m2"]]
            for r in rows
        ]
    )


def brute_force(text, steps, *, one_by_one):
    """Every pair of a grid of depths, and kept where no other beats it."""
    config = load_config_text(text)
    text = text[: text.index("[joint]")]
    for role, low, high in (("outer", 0.314, 0.400), ("middle", 0.243, 0.287)):
        samples = sorted((s.depth_mm, s.natural_curvature_per_m) for s in getattr(config, role).samples)
        stock = text.split(f"[[{role}.samples]]")[0]
        rest = f"[{'middle' if role == 'outer' else 'inner'}]"
        made = "".join(
            f'[[{role}.samples]]\nname = "{role}{n}"\ndepth_mm = {depth!r}\n'
            f"natural_curvature_per_m = {float(np.interp(depth, *zip(*samples, strict=True)))!r}\n"
            for n, depth in enumerate(np.linspace(low, high, steps).tolist())
        )
        text = stock + made + text[text.index(rest) :]
    design = build(load_config_text(text))
    if one_by_one:
        found = [pair_figures(one, two, design.gravity) for two in design.middle for one in design.outer]
        table = np.array([[f.total_precurvature, abs(np.log(f.ratio_mean)), f.total_mean] for f in found])
    else:
        known = pair_table(design.outer, design.middle, design.gravity)
        columns = (known.total_precurvature, np.abs(np.log(known.ratio_mean)), known.total_mean)
        table = np.stack([column.ravel() for column in columns], axis=1)
    beaten = [bool(np.any(np.all(table <= row, axis=1) & np.any(table < row, axis=1))) for row in table]
    return table[~np.array(beaten)]


@given(arrays(float, st.tuples(st.integers(1, 30), st.integers(1, 5)), elements=st.integers(0, 3).map(float)))
def test_undominated_is_what_no_other_dominates(costs):
    beaten = [bool(np.any(np.all(costs <= row, axis=1) & np.any(costs < row, axis=1))) for row in costs]
    np.testing.assert_array_equal(undominated(costs), ~np.array(beaten))


@given(arrays(float, st.tuples(st.integers(1, 40), st.integers(1, 4)), elements=st.integers(0, 5).map(float)))
def test_a_front_that_grows_is_the_front_of_all(costs):
    front = Front()
    for part in np.array_split(np.arange(len(costs)), 3):
        front.add(costs[part], {"row": part})
    np.testing.assert_array_equal(np.sort(front.columns["row"]), np.flatnonzero(undominated(costs)))


def test_a_front_too_long_is_thinned_evenly(monkeypatch):
    """A quarter circle, all of it undominated: what is left is as close everywhere, and nothing kept is dominated."""
    monkeypatch.setattr("coast_cli.design.front.MOST", 200)
    angle = np.random.default_rng(0).uniform(0.0, np.pi / 2.0, 5000)
    costs = np.stack((1.0 - np.cos(angle), 1.0 - np.sin(angle)), axis=1)
    front = Front()
    for part in np.array_split(np.arange(5000), 7):
        front.add(costs[part], {"row": part})
    assert front.thinned
    assert 50 <= front.size <= 200
    assert undominated(front.costs).all()
    nearest = np.linalg.norm(costs[:, None] - front.costs, axis=2).min(axis=1)
    assert nearest.max() < 2.0 * 2.0**0.5 / 50  # at most two boxes


def test_a_grid_is_brute_force(reference_text):
    text = text_with(reference_text, GRID)
    rows, _ = run(text)
    expected = brute_force(text, 5, one_by_one=True)
    found = costs(rows)
    assert len(found) == len(expected)
    np.testing.assert_allclose(found[np.lexsort(found.T)], expected[np.lexsort(expected.T)], rtol=1e-9)


def test_the_refined_front_lies_no_worse_than_a_fine_grid(reference_text):
    """Every member of the front of 41 x 41 pairs has a found one that is no more than 1 % of the range worse."""
    text = text_with(reference_text, SOBOL)
    fine = brute_force(text, 41, one_by_one=False)
    found = costs(run(text)[0])
    size = np.ptp(fine, axis=0)
    worse = np.max((found[None] - fine[:, None]) / size, axis=2).min(axis=1)
    assert worse.max() < 0.01
    beyond = np.max((fine[None] - found[:, None]) / size, axis=2).min(axis=1)
    assert beyond.max() < 0.03  # nor does it promise what the grid cannot have


def test_only_pairs_that_pass_the_checks_are_on_the_front(reference_text):
    config_text = reference_text + GRID
    rows, notes = run(config_text)
    assert rows
    assert all(row["total_precurvature_rad"] <= 0.30 and row["stroke_mm"] <= 6.0 for row in rows)
    assert any("pass the checks" in note for note in notes)


def test_natural_curvature_says_where_it_comes_from(reference_text):
    rows, _ = run(text_with(reference_text, GRID))
    assert {row["natural_curvature"] for row in rows} <= {"measured", "interpolated"}
    held = GRID.replace("refinements = 0", 'refinements = 0\noutside_samples = "hold"')
    held = held.replace("0.400, step = 0.0215", "0.42, step = 0.0265")
    rows, _ = run(text_with(reference_text, held))
    assert "held" in {row["natural_curvature"] for row in rows}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("min = 0.314, max = 0.400", "min = 0.400, max = 0.314", "inverted"),
        ("max = 0.400, step = 0.0215", "max = 0.400", "a grid needs a step"),
        ("max = 0.400", "max = 0.45", "no sample was measured there"),
        ("step = 0.0215", "step = 0.00000002", "from 1e-06"),
        ("[explore.middle]", "[explore.middel]", "Did you mean middle"),
        ("refinements = 0", "refinements = 0\nobjectives = ['beauty']", "a list of total_precurvature"),
        ("refinements = 0", "refinements = 0\nobjectives = ['stroke']", "max_stroke_mm"),
    ],
)
def test_bad_ranges_are_refused_in_one_sentence(reference_text, old, new, said):
    table = GRID.replace(old, new)
    assert table != GRID
    with pytest.raises(BadInput, match=said):
        run(text_with(reference_text, table))


def test_ranges_without_a_pair_are_refused(reference_text):
    table = GRID + "outer_diameter_mm = { min = 0.41, max = 0.45, step = 0.04 }\n"
    with pytest.raises(BadInput, match="hold no pair that can be made"):
        run(text_with(reference_text, table))


def test_an_interrupted_exploration_goes_on_where_it_was(reference_text):
    text = text_with(reference_text, SOBOL.replace("refinements = 5", "refinements = 1"))
    kept = []
    whole = run(text, chunk=16, save=lambda columns, state: kept.append((columns, state)))
    assert len(kept) == 16
    rest = []
    resumed = run(
        text, chunk=16, beginning=Beginning(7, kept[6][1]), save=lambda columns, state: rest.append((columns, state))
    )
    assert resumed == whole
    assert len(rest) == 9
    ends = [{name: column.tolist() for name, column in saved[-1][1].items()} for saved in (rest, kept)]
    assert ends[0] == ends[1]


def test_processes_give_the_same_blocks(reference_text):
    text = text_with(reference_text, GRID)
    blocks = tasks(text, "test.toml", 2)
    assert len(blocks) == 9
    alone = [explore_block(task) for task in blocks]
    with workers(2, None) as executor:
        together = list(results_in_order(*executor, explore_block, blocks))
    for one, two in zip(alone, together, strict=True):
        assert {name: column.tobytes() for name, column in one.columns.items()} == {
            name: column.tobytes() for name, column in two.columns.items()
        }


@pytest.mark.parametrize("step", ["", ", step = 0.15"], ids=["patterns of their own", "shared patterns"])
def test_every_pair_of_two_blocks_is_that_pair_alone(reference_text, step):
    """Blocks are cut from tubes in the order of their patterns, so each block holds few of them."""
    cuts = f"cut_mm = {{ min = 0.20, max = 0.50{step} }}\nlength_mm = "
    table = SOBOL.replace("64", "6").replace("[explore.middle]", f"{cuts}112.8\n[explore.middle]") + f"{cuts}75.0\n"
    text = text_with(reference_text, table)
    design = build(load_config_text(text))
    columns = [explore_block(task).columns for task in tasks(text, "test.toml", 3)]
    assert len(columns) == 4
    every = {name: np.concatenate([part[name] for part in columns]) for name in columns[0]}
    assert sorted(zip(every["outer"], every["middle"], strict=True)) == [
        (i, k) for i in range(1, 7) for k in range(1, 7)
    ]
    counts = [every["outer_count"][every["outer"] == number][0] for number in range(1, 7)]
    assert counts == sorted(counts)
    for row in range(36):
        outer, middle = (
            made(sample, samples, {key: every[f"{role}_{key}"][row] for key in ("depth_mm", "cut_mm", "count")}, sign)
            for role, sample, samples, sign in (
                ("outer", design.outer[0], design.config.outer.samples, 1.0),
                ("middle", design.middle[0], design.config.middle.samples, -1.0),
            )
        )
        alone = pair_figures(outer, middle, design.gravity)
        found = [
            every[name][row] for name in ("total_precurvature_rad", "rigidity_ratio_mean", "total_rigidity_series_n_m2")
        ]
        np.testing.assert_allclose(found, [alone.total_precurvature, alone.ratio_mean, alone.total_series], rtol=1e-9)


def made(tube, samples, values, sign):
    """A sample with another notch, its natural curvature interpolated."""
    known = sorted((sample.depth_mm, sample.natural_curvature_per_m) for sample in samples)
    one = np.ones(int(values["count"]))
    return replace(
        tube,
        depth=values["depth_mm"] * 1e-3 * one,
        cut=values["cut_mm"] * 1e-3 * one,
        uncut=tube.uncut[0] * one,
        natural_curvature=sign * float(np.interp(values["depth_mm"], *zip(*known, strict=True))),
    )


def test_the_front_alone_is_that_of_a_run_that_keeps_every_pair(reference_text):
    """Blocks then carry no columns, so that a run of any size holds only its front."""
    text = text_with(reference_text, SOBOL.replace("refinements = 5", "refinements = 1"))
    kept = []
    alone = run(text, chunk=32, every=False, save=lambda columns, _: kept.append(len(columns)))
    assert kept == [0] * 4
    assert alone == run(text, chunk=32)
