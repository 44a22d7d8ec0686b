"""How sure fitted numbers are: scaled to the numbers, kept for those the file has, and read back."""

import numpy as np
import pytest

from coast_cli.diagnosis.spread import spread_of
from coast_cli.errors import BadInput
from coast_cli.spec.load import load_config_text

KEYS = ("joint.youngs_modulus_gpa", "joint.deadband_mm", "corrections.gone.width_mm")
COVARIANCE = np.array([[4e-4, 1e-4, 0.0], [1e-4, 1e-2, 0.0], [0.0, 0.0, 1.0]])


def test_a_logarithm_is_scaled_by_its_number():
    spread = spread_of(KEYS, [42.6, 1.0, 1.0], COVARIANCE)
    np.testing.assert_allclose(spread.std, [42.6 * 0.02, 0.1, 1.0])
    assert spread.correlation[0, 1] == pytest.approx(1e-4 / (0.02 * 0.1))


def test_the_table_has_what_the_file_has_and_what_is_known():
    spread = spread_of(KEYS, [42.6, 1.0, 1.0], COVARIANCE)
    table = spread.table(lambda key: "gone" not in key)
    assert table == {"keys": list(KEYS[:2]), "std": [0.852, 0.1], "correlation": [[1.0, 0.05], [0.05, 1.0]]}
    unknown = spread_of(KEYS[:1], [1.0], np.array([[np.inf]]))
    assert unknown.table(lambda _: True) is None


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('keys = ["joint.deadband_mm"]\nstd = [0.1, 0.2]\ncorrelation = [[1.0]]', "fitted.std: not one for each key"),
        (
            'keys = ["joint.deadband_mm"]\nstd = [0.1]\ncorrelation = [[1.0, 0.0]]',
            "fitted.correlation: not one for each",
        ),
        (
            'keys = ["joint.pear"]\nstd = [0.1]\ncorrelation = [[1.0]]',
            "no such number in this file; found 'joint.pear'",
        ),
        ('keys = ["outer.material"]\nstd = [0.1]\ncorrelation = [[1.0]]', "no such number in this file"),
    ],
)
def test_what_does_not_go_with_the_file_is_refused(reference_text, table, words):
    with pytest.raises(BadInput, match=words):
        load_config_text(f"{reference_text}\n[fitted]\n{table}\n")
