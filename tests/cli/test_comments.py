"""What a command writes as a configuration keeps every comment of the one it read, and counts the same sources."""

from pathlib import Path

import pytest

from coast_cli.output.report_inputs import inputs_of, said_of
from coast_cli.spec.load import load_config
from coast_cli.spec.positions import line_comments

RECORDING = Path(__file__).parents[2] / "examples" / "diagnose" / "recording.csv"
WRITERS = {
    "calibrate": ("{config}", RECORDING, "-o", "{out}"),
    "diagnose": ("{config}", RECORDING, "--save-model", "{out}"),
    "design": ("{config}", "--target", "rigidity_ratio_series=2.5", "--vary", "outer.depth_mm", "--save", "{out}"),
}


@pytest.mark.parametrize("command", WRITERS)
def test_every_comment_is_kept_and_the_same_sources_are_counted(coast, reference, tmp_path, command):
    out = tmp_path / "model.toml"
    words = [str(word).format(config=reference, out=out) for word in WRITERS[command]]
    assert coast(command, *words).code == 0
    before = reference.read_text(encoding="utf-8")
    after = out.read_text(encoding="utf-8")
    said = " ".join(line_comments(after).values())
    assert all(comment in said for comment in line_comments(before).values())
    assert load_config(out).origin.text == after
    assert assumed(out) == assumed(reference)


def assumed(path):
    """What a report says of the inputs that both files have: the designed tubes and corrections are new."""
    config = load_config(path)
    found = [
        one
        for one in inputs_of(config)
        if one.path[0] != "corrections"
        and not ("samples" in one.path and one.path[2] >= (4 if "outer" in one.path else 3))
    ]
    return said_of(found)


def test_a_fitted_number_says_so_beside_what_stood_there(coast, reference, tmp_path):
    out = tmp_path / "model.toml"
    assert coast("calibrate", reference, RECORDING, "--fit", "deadband_mm", "-o", out).code == 0
    (line,) = [line for line in out.read_text(encoding="utf-8").splitlines() if line.startswith("deadband_mm")]
    assert "# fitted by coast calibrate, 90 % " in line
    assert line.endswith("; was 1.2: paper, subtracted from its plots")
