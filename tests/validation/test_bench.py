"""No agreement is said of more than 1.5 noise widths, whatever a bench did wrong: some of what `tests.validation.bench` draws."""

import pytest

from tests.validation.bench import answered, draw, is_blind


@pytest.mark.parametrize("seed", range(8))
def test_agreement_is_said_of_noise_alone(seed):
    bench = draw(seed)
    assert not is_blind(bench, answered(bench))
