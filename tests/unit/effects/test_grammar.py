import pytest

from coast_cli.effects.catalogue import CATALOGUE, effects_of
from coast_cli.effects.grammar import cells_of_effect, stands_at
from coast_cli.effects.unnamed import UnnamedLaw


@pytest.mark.parametrize("effect", effects_of("joint").values(), ids=effects_of("joint").keys())
def test_every_effect_stands_somewhere_in_the_grammar_and_not_everywhere(effect):
    assert 1 <= len(cells_of_effect(effect.null())) <= 4


def test_a_law_stands_where_it_says():
    law = UnnamedLaw("structure", "curvature", "friction", 0.0, 0.0, 40.0, (1.0,))
    assert stands_at(CATALOGUE["coulomb_friction"].null(), law)
    assert not stands_at(CATALOGUE["sensor_lag"].null(), law)
    assert stands_at(law, law)
