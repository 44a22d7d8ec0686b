"""The words of the command ask for the cases they say."""

from examples.concealed.__main__ import asked, parser
from examples.concealed.laws import JOINT_EFFECTS


def cases(words):
    return asked(parser().parse_args(["make", "--out", "x", *words.split()]))


def test_levels_and_effects_take_turns():
    assert cases("--seeds 3:6") == [("joint", seed, None, None) for seed in (3, 4, 5)]
    assert [level for _, _, level, _ in cases("--seeds 0:4 --level L0 --level L6")] == ["L0", "L6", "L0", "L6"]
    assert [name for *_, name in cases("--seeds 0:3 --effect backlash --effect gravity")] == [
        "backlash",
        "gravity",
        "backlash",
    ]
    assert cases("--seeds 0:1 --shapes --level L0") == [("shape", 0, "L0", None)]


def test_the_whole_catalogue_is_concealed_in_turn():
    chosen = cases("--seeds 0:420 --level L8 --effect catalogue")
    names = [name for *_, name in chosen]
    assert set(names) == JOINT_EFFECTS.keys() - {"camera_scale"}
    assert min(names.count(name) for name in set(names)) == 20
