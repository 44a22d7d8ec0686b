"""What would need too much memory is refused before it starts, with how much is allowed."""

import pytest


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("stroke {config} --kappa 0:40:0.0001 --x2 10:20:0.0001", "4e+10 strokes would need about"),
        (
            "beam {config} --tube OT1 --tube OT2 --tube OT3 --tube OT4 --tube MT1 --tube MT2 --points 1000000",
            "points would",
        ),
    ],
)
def test_too_much_is_refused_before_the_run(coast, reference, words, said):
    ran = coast(*words.format(config=reference).split())
    assert (ran.code, ran.out) == (2, "")
    assert said in ran.err
    assert "more than the 4 GB that a command may take; allowed at once: " in ran.err
    assert ran.err.count("\n") == 1
