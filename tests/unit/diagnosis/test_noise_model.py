"""The likelihood of coloured noise: against scipy's normal density, on simulated noise, over gaps and chunks."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from coast_cli.diagnosis.noise_model import NOISE_COLOURS, SMOOTH_COLOURS, NoiseBank
from tests.modelled_joint import coloured


def covariance(rows, colour):
    memory, white = NOISE_COLOURS[colour]
    lag = np.abs(rows[:, None] - rows)
    return (1.0 - white) * memory ** lag.astype(float) + white * np.eye(rows.size)


@pytest.mark.parametrize("memory", [0.0, 0.6, 0.95])
@pytest.mark.parametrize(
    "rows", [np.arange(50), np.delete(np.arange(60), [3, 4, 20, 41])], ids=["whole", "with dropped frames"]
)
def test_log_likelihood_is_the_normal_log_density_at_the_best_level(rows, memory):
    residual = coloured(np.random.default_rng(2), rows.size, 0.3, memory)
    found = NoiseBank([rows]).evidence(residual)
    exact = multivariate_normal(np.zeros(rows.size), found.level**2 * covariance(rows, found.colour)).logpdf(residual)
    assert found.log_likelihood == pytest.approx(exact, rel=1e-9)


def test_no_other_colour_and_no_other_level_is_likelier():
    rows = np.arange(40)
    residual = coloured(np.random.default_rng(3), 40, 1.0, 0.7)
    found = NoiseBank([rows]).evidence(residual)
    for colour in range(len(NOISE_COLOURS)):
        for level in found.level * np.array([0.6, 0.9, 1.0, 1.1, 1.6]):
            density = multivariate_normal(np.zeros(40), level**2 * covariance(rows, colour)).logpdf(residual)
            assert density <= found.log_likelihood + 1e-9


def test_independent_sequences_add_up():
    rng = np.random.default_rng(4)
    rows = [np.arange(30), np.arange(30) * 2, np.arange(55)]
    residual = rng.standard_normal(115)
    found = NoiseBank(rows).evidence(residual)
    parts = np.split(residual, [30, 60])
    exact = sum(
        multivariate_normal(np.zeros(row.size), found.level**2 * covariance(row, found.colour)).logpdf(part)
        for row, part in zip(rows, parts, strict=True)
    )
    assert found.log_likelihood == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("memory", [0.0, 0.3, 0.7, 0.9])
@pytest.mark.parametrize("level", [0.02, 5.0])
def test_memory_and_level_of_simulated_noise_come_back(memory, level):
    residual = coloured(np.random.default_rng(5), 3000, level, memory)
    found = NoiseBank([np.arange(3000)]).evidence(residual)
    assert found.memory == pytest.approx(memory, abs=0.12)
    assert found.level == pytest.approx(level, rel=0.22)  # colours form a grid: 0.9 lies between two of them


def test_the_white_share_of_a_mixture_comes_back():
    rng = np.random.default_rng(6)
    residual = np.sqrt(0.4) * coloured(rng, 4000, 1.0, 0.93) + np.sqrt(0.6) * rng.standard_normal(4000)
    bank = NoiseBank([np.arange(4000)])
    found = bank.evidence(residual)
    assert bank.white_share(found.colour) == pytest.approx(0.6, abs=0.3)
    assert 0.2 < found.memory < 0.6


def test_evidence_scales_as_a_density_does():
    residual = coloured(np.random.default_rng(7), 200, 1.0, 0.5)
    bank = NoiseBank([np.arange(200)])
    one, ten = bank.evidence(residual), bank.evidence(10.0 * residual)
    assert ten.colour == one.colour
    assert ten.level == pytest.approx(10.0 * one.level)
    assert ten.log_likelihood == pytest.approx(one.log_likelihood - 200 * np.log(10.0))


def test_long_sequences_are_cut_without_losing_a_sample():
    residual = np.random.default_rng(8).standard_normal(1000)
    found = NoiseBank([np.arange(1000)]).evidence(residual)
    assert found.colour == 0
    assert found.level == pytest.approx(np.sqrt(np.mean(residual**2)))


@pytest.mark.parametrize("memory", [0.5, 0.93])
def test_whitened_noise_is_white_and_of_unit_level(memory):
    rows = np.delete(np.arange(2100), np.arange(0, 2100, 21))
    residual = coloured(np.random.default_rng(9), 2100, 0.4, memory)[rows]
    bank = NoiseBank([rows])
    found = bank.evidence(residual)
    white = bank.whiten(residual / found.level, found.colour)
    assert np.sqrt(np.mean(white**2)) == pytest.approx(1.0, abs=1e-9)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.08


def test_columns_are_whitened_as_they_would_be_alone():
    values = np.random.default_rng(10).standard_normal((130, 3))
    bank = NoiseBank([np.arange(70), np.arange(60)])
    for colour in (0, 7, len(NOISE_COLOURS) - 1):
        together = bank.whiten(values, colour)
        for column in range(3):
            assert together[:, column] == pytest.approx(bank.whiten(values[:, column], colour), abs=1e-12)


def test_a_smooth_curve_is_told_from_noise_with_memory_and_back():
    rows = np.arange(300)
    rng = np.random.default_rng(11)
    curve = np.sin(rows / 25.0) + 0.05 * rng.standard_normal(300)
    rough = coloured(rng, 300, 1.0, 0.9)
    for residual, smooth in ((curve, True), (rough, False)):
        nats = NoiseBank([rows], kernel="smooth").evidence(residual).log_likelihood
        nats -= NoiseBank([rows]).evidence(residual).log_likelihood
        assert (nats > 0.0) is smooth
    assert len(SMOOTH_COLOURS) > 1


def test_nothing_recorded_has_no_evidence_and_zeros_no_trouble():
    assert NoiseBank([]).evidence(np.zeros(0)).log_likelihood == 0.0
    silent = NoiseBank([np.arange(20)]).evidence(np.zeros(20))
    assert np.isfinite(silent.log_likelihood)
    assert silent.level < 1e-100
