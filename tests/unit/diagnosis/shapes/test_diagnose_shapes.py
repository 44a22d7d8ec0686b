"""The five answers on shapes of an independent beam: named, placed, fitted, held out, or honestly left open."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from coast_cli.diagnosis.shapes import diagnose_shapes
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import load_config, load_config_text
from tests.photographed_tube import LENGTH, Bench, config_text, csv_text

TUBES = {"A": (0.314, 4.0), "B": (0.336, 4.0), "C": (0.280, 4.0)}
OTHER_CURVATURES = {"A": (0.314, 4.0), "B": (0.300, 7.0), "C": (0.280, 2.5)}
NOISE = 30e-6
SOLID = Path(__file__).parents[3] / "validation" / "data" / "solid"


def _bench(tube: str, **changes: float) -> Bench:
    return Bench(depth=TUBES[tube][0] * 1e-3, natural=TUBES[tube][1], **changes)


def _diagnosis(tmp_path, photographs, *, noise=NOISE, named=(), config=None, **how):
    path = tmp_path / "shapes.csv"
    path.write_text(csv_text(photographs, noise, **how), encoding="utf-8")
    document = load_config_text(config or config_text(TUBES), "tubes.toml")
    return diagnose_shapes(document, read_recordings([path], document).shape.runs, named_hold_out=named)


def _both(tube: str, **changes: float) -> list[tuple[str, Bench, bool]]:
    return [(tube, _bench(tube, **changes), up) for up in (True, False)]


def _value(diagnosis, identifier: str, parameter: str) -> float:
    return next(e for e in diagnosis.effects if e.id == identifier).parameters[parameter].value


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_clean_shapes_agree(tmp_path, seed):
    found = _diagnosis(tmp_path, _both("A") + _both("B"), seed=seed)
    assert found.verdict in ("agrees", "parameters")
    assert found.effects == ()
    assert found.noise == pytest.approx(0.03, rel=0.25)


def test_a_wrong_modulus_of_one_tube_is_a_group(tmp_path):
    found = _diagnosis(tmp_path, _both("A", modulus=38e9))
    assert found.verdict == "parameters"
    assert ("notch_end_effect",) in found.alternatives
    assert "another tube" in found.next_recording
    assert found.parameters["materials.nitinol.youngs_modulus_gpa"].value == pytest.approx(38.0, rel=0.02)


def test_a_tilted_clamp(tmp_path):
    found = _diagnosis(tmp_path, _both("A", tilt=np.radians(1.5)))
    assert [effect.id for effect in found.effects] == ["base_tilt"]
    assert _value(found, "base_tilt", "angle_deg") == pytest.approx(1.5, abs=0.1)


def test_a_weight_at_the_tip(tmp_path):
    found = _diagnosis(tmp_path, _both("A", tip_force=1.5e-4))
    assert [effect.id for effect in found.effects] == ["tip_load"]
    force = found.effects[0].parameters["force_mn"]
    assert abs(force.value + 0.15) < 3.5 * force.std  # a modulus trades against it
    assert force.std < 0.02


def test_a_gradient_of_natural_curvature(tmp_path):
    found = _diagnosis(tmp_path, _both("A", gradient=60.0) + _both("B"))
    assert found.effects[0].id == "precurvature_gradient"
    assert _value(found, "precurvature_gradient", "per_m_per_mm") == pytest.approx(0.06, rel=0.1)
    assert any(region.axis == "pair" and region.value == "A" for region in found.where)


@pytest.mark.parametrize("share", [0.2, 0.45])
def test_a_soft_place_is_found_within_one_pitch(tmp_path, share):
    at = share * LENGTH
    found = _diagnosis(tmp_path, _both("A", soft_at=at, soft_angle_per_moment=2e4))
    assert found.effects[0].id == "local_stiffness_defect"
    assert _value(found, "local_stiffness_defect", "arc_length_mm") == pytest.approx(1e3 * at, abs=0.6)
    assert found.where[0].axis == "arc_length"
    assert found.where[0].low - 0.6 < 1e3 * at < found.where[0].high + 0.6


@pytest.mark.parametrize(("seed", "share", "mass_mg"), [(1, 0.55, 10.0), (2, 0.7, 25.0)])
def test_a_weight_clipped_on_half_way(tmp_path, seed, share, mass_mg):
    clipped = _both("A", clip_at=share * LENGTH, clip_mass=1e-6 * mass_mg)
    found = _diagnosis(tmp_path, clipped + _both("B"), seed=seed, noise=0.5 * NOISE)
    assert found.verdict == "physics"
    assert found.effects[0].id == "clipped_weight"
    assert _value(found, "clipped_weight", "arc_length_mm") == pytest.approx(1e3 * share * LENGTH, abs=3.0)
    assert _value(found, "clipped_weight", "mass_mg") == pytest.approx(mass_mg, rel=0.15)


@pytest.mark.parametrize(("seed", "share", "angle_deg"), [(1, 0.3, 3.0), (2, 0.6, -6.0)])
def test_a_kink(tmp_path, seed, share, angle_deg):
    kinked = _both("A", kink_at=share * LENGTH, kink_angle=np.radians(angle_deg))
    found = _diagnosis(tmp_path, kinked, seed=seed)
    assert [effect.id for effect in found.effects] == ["kink"]
    assert _value(found, "kink", "arc_length_mm") == pytest.approx(1e3 * share * LENGTH, abs=1.0)
    assert _value(found, "kink", "angle_deg") == pytest.approx(angle_deg, abs=0.3)
    assert found.where[0].low < 1e3 * share * LENGTH + 0.6
    assert found.where[0].high > 1e3 * share * LENGTH - 0.6


@pytest.mark.parametrize(("seed", "growth"), [(1, 0.4), (2, -0.9)])
def test_natural_curvature_that_grows_along_every_tube_in_proportion_to_its_own(tmp_path, seed, growth):
    photographs = [
        (tube, Bench(depth=depth * 1e-3, natural=natural, growth=growth), up)
        for tube, (depth, natural) in OTHER_CURVATURES.items()
        for up in (True, False)
    ]
    found = _diagnosis(tmp_path, photographs, seed=seed, config=config_text(OTHER_CURVATURES))
    assert [effect.id for effect in found.effects] == ["precurvature_gradient"]
    own, gradient = (_value(found, "precurvature_gradient", name) for name in ("of_per_m", "per_m_per_mm"))
    assert gradient / own == pytest.approx(growth / (1e3 * LENGTH), rel=0.1)


def test_a_camera_scale(tmp_path):
    found = _diagnosis(tmp_path, _both("A") + _both("B"), seen=lambda x, y: (1.03 * x, 1.03 * y))
    assert found.verdict == "sensor"
    assert _value(found, "camera_scale", "scale") == pytest.approx(1.03, abs=0.003)


def test_tubes_of_several_depths_tell_the_end_effect_from_the_modulus_and_predict_another(tmp_path):
    from coast_cli.mechanics.end_effect import end_length

    def long(tube: str) -> list[tuple[str, Bench, bool]]:
        delta, _ = end_length(0.2e-3, 0.165e-3, TUBES[tube][0] * 1e-3, 0.3e-3, 0.3e-3)
        return _both(tube, extra_cut=float(delta))

    found = _diagnosis(tmp_path, long("A") + long("B") + long("C"), named=("s4", "s5"))
    assert found.effects[0].id == "notch_end_effect"
    assert _value(found, "notch_end_effect", "table_share") == pytest.approx(1.0, abs=0.1)
    held = found.comparison
    assert held.held_out_runs == ("s4", "s5")
    assert held.with_effects.held_out < 0.5 * held.refitted.held_out


def test_what_the_catalogue_does_not_have_is_not_named(tmp_path):
    def wavy(x, y):
        s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        return x, y + 4e-4 * np.sin(9.0 * np.pi * s / LENGTH) * np.minimum(s / 5e-3, 1.0)

    found = _diagnosis(tmp_path, _both("A") + _both("B"), seen=wavy)
    assert found.verdict == "unexplained"
    assert found.effects == ()


def test_one_way_up_asks_for_the_other(tmp_path):
    found = _diagnosis(tmp_path, [("A", _bench("A", tilt=np.radians(2.0)), True)])
    assert "natural = down" in found.next_recording
    assert any("one way up" in note for note in found.notes)


def test_a_corrected_model_agrees_with_what_corrected_it(tmp_path):
    from coast_cli.diagnosis.compare import compare
    from coast_cli.diagnosis.model_file import model_text

    path = tmp_path / "shapes.csv"
    path.write_text(csv_text(_both("A", tilt=np.radians(1.5)), NOISE), encoding="utf-8")
    config = load_config_text(config_text(TUBES), "tubes.toml")
    recordings = read_recordings([path], config)
    found = diagnose_shapes(config, recordings.shape.runs)
    corrected = load_config_text(model_text(config, found, recordings), "model.toml")
    before, after = (compare(document, recordings).rows()[-1]["rmse_shape_mm"] for document in (config, corrected))
    assert after < 0.25 * before
    again = diagnose_shapes(corrected, recordings.shape.runs)
    assert again.verdict in ("agrees", "parameters")


@pytest.mark.parametrize("kind", ["radial", "flat"])
def test_what_is_found_in_the_tubes_is_saved_as_numbers_of_the_tubes(kind):
    """Extra cut lengths of every tube, seen or not; so a joint of these tubes has them too."""
    from coast_cli.diagnosis.compare import compare
    from coast_cli.diagnosis.model_file import model_text

    config = load_config(SOLID / "tubes.toml")
    recordings = read_recordings([SOLID / f"{kind}.csv", SOLID / f"{kind}_held_out.csv"], config)
    named = [run.name for run in recordings.shape.runs if run.source.endswith("_held_out.csv")]
    found = diagnose_shapes(config, recordings.shape.runs, named_hold_out=named)
    corrected = load_config_text(model_text(config, found, recordings), "model.toml")
    assert "notch_end_effect" not in corrected.corrections
    assert all(sample.end_effect > 0.05 for sample in corrected.middle.samples)
    rows = [row for row in compare(corrected, recordings).rows() if row["run"] in named]
    held = np.sqrt(sum(row["n"] * row["rmse_shape_mm"] ** 2 for row in rows) / sum(row["n"] for row in rows))
    assert held == pytest.approx(found.comparison.with_effects.held_out, rel=0.02)


def test_too_few_points_are_said_to_be(tmp_path):
    path = tmp_path / "shapes.csv"
    path.write_text("run,tube,x_mm,y_mm\n" + "".join(f"s,A,{18 * i},{-i}\n" for i in range(5)), encoding="utf-8")
    config = load_config_text(config_text(TUBES), "tubes.toml")
    found = diagnose_shapes(config, read_recordings([path], config).shape.runs)
    assert found.verdict == "insufficient"
    assert found.next_recording


def test_the_same_input_gives_the_same_answer(tmp_path):
    photographs = _both("A", tilt=np.radians(1.0))
    one, other = (_diagnosis(tmp_path, photographs) for _ in range(2))
    assert replace(one) == replace(other)
