"""Beams: one and many, any notch pattern, verdicts, the compiled kernel, and whatever input may come."""

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from coast_cli.mechanics.beam import equilibrium as beam_module
from coast_cli.mechanics.beam import (
    solve_alike_curvatures,
    solve_beam,
    solve_beams,
    solve_curvatures,
    solve_segments,
    solve_tips,
)
from coast_cli.mechanics.section import full_section, notched_section
from coast_cli.mechanics.tube import NotchedTube

GRAVITY = 9.81


def tube(count=188, natural_curvature=5.0, depth=0.35e-3, **changes) -> NotchedTube:
    one = np.ones(count)
    values = {"cut": 0.3e-3 * one, "uncut": 0.3e-3 * one, "youngs_modulus": 45e9, "density": 6450.0} | changes
    return NotchedTube("tube", 0.2e-3, 0.165e-3, depth * one, natural_curvature=natural_curvature, **values)


def many(count: int, *, seed: int, deepest: float, curvature: float = 15.0):
    """Arrays of random notched tubes as ``solve_segments`` takes them."""
    rng = np.random.default_rng(seed)
    ro = rng.uniform(0.19e-3, 0.21e-3, count)
    ring = full_section(ro, 0.825 * ro)
    notch = notched_section(ro, 0.825 * ro, rng.uniform(1.25, deepest, count) * ro)
    modulus = rng.uniform(40e9, 60e9, count)
    rigidity = np.tile(modulus[:, None] * np.stack((ring.second_moment, notch.second_moment), axis=1), (1, 188))
    weight = np.tile(6450.0 * np.stack((ring.area, notch.area), axis=1), (1, 188))
    return np.full(376, 0.3e-3), rigidity, weight, rng.uniform(-curvature, curvature, count)[:, None]


def test_many_beams_equal_one_by_one():
    tubes = [tube(natural_curvature=k, count=n) for k, n in ((5.0, 188), (-15.0, 125), (0.0, 1), (2.0, 30))]
    together = solve_beams(tubes, GRAVITY)
    for row, one in enumerate(tubes):
        alone = solve_beam(one, GRAVITY)
        nodes = alone.s.size
        assert together.converged[row]
        assert together.x[row, :nodes] == pytest.approx(alone.x, abs=1e-13)
        assert together.angle[row, :nodes] == pytest.approx(alone.angle, abs=1e-12)
        assert np.ptp(together.angle[row, nodes - 1 :]) == 0.0


def test_equilibrium_holds_at_every_node():
    solution = solve_beam(tube(), GRAVITY)
    pieces = tube().segments
    shear = GRAVITY * np.cumsum((pieces.weight * pieces.length)[::-1])[::-1]
    # m(0) balances the weight of every piece at its lever arm.
    middle = 0.5 * (solution.x[1:] + solution.x[:-1])
    assert solution.moment[0] == pytest.approx(-GRAVITY * np.sum(pieces.weight * pieces.length * middle), rel=1e-6)
    assert np.diff(solution.moment) == pytest.approx(
        (shear - 0.5 * GRAVITY * pieces.weight * pieces.length) * np.diff(solution.x), rel=1e-4
    )
    assert solution.curvature * pieces.length == pytest.approx(np.diff(solution.angle))
    assert solution.moment[-1] == 0.0


def test_the_clamp_and_the_length_are_kept():
    solution = solve_beam(tube(natural_curvature=-15.0), GRAVITY)
    assert solution.angle[0] == pytest.approx(0.0, abs=1e-12)
    assert (solution.x[0], solution.y[0], solution.s[0]) == (0.0, 0.0, 0.0)
    chords = np.hypot(np.diff(solution.x), np.diff(solution.y))
    arcs = np.diff(solution.s)
    assert np.all(chords <= arcs * (1.0 + 1e-12))
    assert chords == pytest.approx(arcs, rel=1e-4)


def test_pieces_cut_further_change_nothing():
    pieces = tube().segments
    whole = solve_segments(pieces.length, pieces.rigidity, pieces.weight, 5.0, gravity=(0.0, -GRAVITY))
    halves = [np.repeat(column, 2) for column in (pieces.length / 2.0, pieces.rigidity, pieces.weight)]
    halved = solve_segments(*halves, 5.0, gravity=(0.0, -GRAVITY))
    assert halved.x[0, ::2] == pytest.approx(whole.x[0], abs=1e-13)
    assert halved.angle[0, ::2] == pytest.approx(whole.angle[0], abs=1e-12)


def test_hard_set_has_a_verdict_each():
    rng = np.random.default_rng(3)
    solution = solve_segments(*many(400, seed=3, deepest=1.95, curvature=20.0), gravity=(0.0, -GRAVITY))
    assert solution.converged.all()
    assert (solution.equilibria > 1).any()
    words = {solution.verdict(beam).message for beam in range(400)}
    assert any("equilibria were found" in message for message in words)
    assert rng is not None


def test_path_that_turns_back_is_said():
    # A soft strip that curls up into a hook: its weight unrolls the hook with a snap.
    solution = solve_segments(np.full(20, 0.005), 1e-6, 8.1e-3, 51.8, gravity=(0.0, -9.81), base_angle=-0.68)
    assert solution.converged.all()
    assert solution.turned_at[0] == pytest.approx(0.22, abs=0.05)
    assert "turned back" in solution.verdict(0).message


def test_a_string_is_refused_in_words():
    solution = solve_segments(np.full(50, 0.02), 1e-8, 1e-2, 0.0, gravity=(0.0, -9.81))
    verdict = solution.verdict(0)
    assert not verdict.converged
    assert "too soft" in verdict.message
    assert np.all(np.isfinite(solution.x))


def test_compiled_tips_equal_the_scalar_path():
    pytest.importorskip("numba", reason="not here: the extra [fast]")
    columns = many(2100, seed=5, deepest=1.9)
    tips = solve_tips(*columns, gravity=(0.0, -GRAVITY), threads=2)
    shapes = solve_segments(*columns, gravity=(0.0, -GRAVITY))
    assert tips.converged.all()
    assert tips.x == pytest.approx(shapes.x[:, -1], abs=1e-12 * 0.1128)
    assert tips.y == pytest.approx(shapes.y[:, -1], abs=1e-12 * 0.1128)
    assert tips.angle == pytest.approx(shapes.angle[:, -1], abs=2e-12)
    for row in (0, 700, 2099):
        alone = solve_segments(
            *(np.atleast_2d(c)[min(row, np.atleast_2d(c).shape[0] - 1)] for c in columns), gravity=(0.0, -GRAVITY)
        )
        assert tips.x[row] == pytest.approx(alone.x[0, -1], abs=1e-12 * 0.1128)


def test_tips_without_numba(monkeypatch):
    monkeypatch.setattr(beam_module, "find_spec", lambda _: None)
    columns = many(1100, seed=6, deepest=1.5)
    tips = solve_tips(*columns, gravity=(1.0, -9.0), tip_force=(1e-5, 0.0), tip_moment=1e-7, base_angle=0.2)
    shapes = solve_segments(*columns, gravity=(1.0, -9.0), tip_force=(1e-5, 0.0), tip_moment=1e-7, base_angle=0.2)
    assert tips.x == pytest.approx(shapes.x[:, -1], abs=1e-14)


@pytest.mark.parametrize(("deepest", "curvature"), [(1.5, 15.0), (1.93, 40.0)], ids=["plain", "some soft"])
def test_curvatures_by_one_march_equal_the_full_solution(deepest, curvature):
    length, *columns = many(300, seed=7, deepest=deepest, curvature=curvature)
    length = np.where(np.arange(376) < np.where(np.arange(300) % 3 == 0, 250, 376)[:, None], length, 0.0)
    found = solve_curvatures(length, *columns, gravity=GRAVITY)
    whole = solve_segments(length, *columns, gravity=(0.0, -GRAVITY))
    assert np.array_equal(found.converged, whole.converged)
    error = np.max(np.abs(found.curvature - whole.curvature), axis=1)
    assert np.all(error <= 1e-9 * np.max(np.abs(whole.curvature), axis=1))


def test_a_beam_that_cannot_be_solved_has_no_curvature_either():
    columns = np.full((2, 40), 1e-3), np.array([[1e-4], [1e-30]]) * np.ones(40), np.full((2, 40), 1e-2)
    found = solve_curvatures(*columns, 0.0, gravity=GRAVITY)
    assert found.converged.tolist() == [True, False]
    assert np.all(np.isfinite(found.curvature))


finite = st.floats(-1e300, 1e300, allow_nan=False, allow_subnormal=False)
positive = st.floats(1e-300, 1e300, allow_subnormal=False)


@settings(max_examples=150, deadline=None, phases=(Phase.explicit, Phase.reuse, Phase.generate))
@given(length=positive, rigidity=positive, weight=st.one_of(st.just(0.0), positive), curvature=finite, gravity=finite)
def test_any_numbers_give_a_verdict_and_no_nan(length, rigidity, weight, curvature, gravity):
    solution = solve_segments([length, length], rigidity, weight, curvature, gravity=(0.0, gravity))
    verdict = solution.verdict(0)
    assert verdict.message
    for values in (solution.x, solution.y, solution.angle, solution.moment):
        assert np.all(np.isfinite(values))


@example(count=32, depth=1.875, curvature=0.0, gravity=50.0, cut=1.95e-3)  # hangs: its tip turns the clamp 1e5-fold
@settings(max_examples=60, deadline=None)
@given(
    count=st.integers(1, 40),
    depth=st.floats(1.0, 1.9),
    curvature=st.floats(-20.0, 20.0),
    gravity=st.sampled_from([0.0, 1e-6, 9.81, 50.0]),
    cut=st.floats(0.05e-3, 2e-3),
)
def test_ordinary_tubes_always_converge(count, depth, curvature, gravity, cut):
    one = np.ones(count)
    solution = solve_beam(
        tube(count, curvature, depth * 0.2e-3, cut=cut * one, section="chord", uncut=0.2e-3 * one), gravity
    )
    assert solution.verdict.converged
    assert abs(solution.angle[0]) < 1e-9


@pytest.mark.parametrize("section", ["sector", "chord"])
def test_section_at_the_edge_of_validity(section):
    # |d - ro| = ri: the cut just misses the bore.
    solution = solve_beam(tube(50, 5.0, 0.2e-3 + 0.165e-3, section=section), GRAVITY)
    assert solution.verdict.converged


def test_without_gravity_a_tube_keeps_its_natural_shape():
    solution = solve_beam(tube(natural_curvature=7.0), 0.0)
    assert solution.angle == pytest.approx(7.0 * solution.s, abs=1e-13)


def test_a_hundred_thousand_notches():
    count = 100_000
    one = np.ones(count)
    solution = solve_beam(tube(count, cut=0.1128 / 2 / count * one, uncut=0.1128 / 2 / count * one), GRAVITY)
    assert solution.verdict.converged
    # Ever finer notches approach the homogenised tube; 188 of them are 0.004 rad away.
    assert solution.tip_angle == pytest.approx(-0.66270797828223, abs=5e-3)


def test_compiled_curvatures_equal_the_full_solution():
    pytest.importorskip("numba", reason="not here: the extra [fast]")
    length, *columns = many(700, seed=8, deepest=1.93, curvature=30.0)
    length = np.broadcast_to(length, columns[0].shape)
    found = solve_curvatures(length, *columns, gravity=GRAVITY, compiled=True)
    whole = solve_segments(length, *columns, gravity=(0.0, -GRAVITY))
    assert np.array_equal(found.converged, whole.converged)
    error = np.max(np.abs(found.curvature - whole.curvature), axis=1)
    assert np.all(error <= 1e-9 * np.max(np.abs(whole.curvature), axis=1))


@pytest.mark.parametrize("count", [1, 3, 40, 188])
def test_alike_pitches_bend_as_all_their_pieces(count):
    rng = np.random.default_rng(9)
    made = [
        tube(count, k, depth * 0.2e-3)
        for k, depth in zip(rng.uniform(-15, 15, 60), rng.uniform(1.2, 1.93, 60), strict=True)
    ]
    pieces = [one.segments for one in made]
    columns = [np.stack([getattr(piece, name) for piece in pieces]) for name in ("length", "rigidity", "weight")]
    natural = np.array([one.natural_curvature for one in made])
    found = solve_alike_curvatures(*(column[:, :2] for column in columns), natural, count=count, gravity=GRAVITY)
    whole = solve_segments(*columns, natural[:, None], gravity=(0.0, -GRAVITY))
    assert np.array_equal(found.converged, whole.converged)
    error = np.max(np.abs(found.curvature - whole.curvature), axis=1)
    assert np.all(error <= 1e-9 * np.max(np.abs(whole.curvature), axis=1))
