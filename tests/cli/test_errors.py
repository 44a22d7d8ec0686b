"""One place turns errors into text and exit codes; nothing reaches the user as a traceback."""

import os
import subprocess
import sys

import pytest

from coast_cli import errors
from coast_cli.__main__ import main
from coast_cli.cli import app


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("no-such-command",), 2),
        (("rank-pairs",), 2),
        (("rank-pairs", "{config}", "--no-such-option"), 2),
        (("rank-pairs", "{config}", "--rigidity", "both"), 2),
        (("rank-pairs", "{config}", "--weights", "1,1"), 2),
        (("rank-pairs", "{config}", "--weights", "0,0,0"), 2),
        (("rank-pairs", "{config}", "--weights", "1,-1,1"), 2),
        (("rank-pairs", "{config}", "--format", "yaml"), 2),
        (("rank-pairs", "{config}", "--format", "junit"), 2),
        (("rank-pairs", "{config}", "-o", "ranking.xlsx"), 2),
        (("rank-pairs", "{config}", "-o", "ranking"), 2),
        (("rank-pairs", "absent.toml"), 3),
        (("beam", "{config}"), 2),
        (("beam", "{config}", "--tube", "OT1", "--points", "1"), 2),
    ],
)
def test_exit_codes_and_one_sentence(coast, reference, words, code):
    ran = coast(*(word.format(config=reference) for word in words))
    assert (ran.code, ran.out) == (code, "")
    assert ran.err.startswith("coast: ")
    assert ran.err.count("\n") == 1


@pytest.mark.parametrize(
    ("error", "code", "text"),
    [
        (errors.BadInput("wrong"), 3, "coast: wrong.\n"),
        (errors.UsageError("not so"), 2, "coast: not so\n"),
        (errors.NotConverged("too soft"), 4, "coast: too soft\n"),
        (KeyboardInterrupt(), 130, "coast: interrupted.\n"),
        (ZeroDivisionError("by zero"), 4, "please report it: ZeroDivisionError at "),
        (MemoryError(), 4, "there is not enough memory for this"),
    ],
)
def test_every_error_has_its_code(monkeypatch, capsys, error, code, text):
    def fail(_):
        raise error

    monkeypatch.setattr(app, "run", fail)
    assert main(["rank-pairs"]) == code
    assert text in capsys.readouterr().err


def test_a_reader_that_leaves_early_is_no_error(reference):
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "coast_cli", "beam", str(reference), "--tube", "OT4", "--points", "5000"]
    ran = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert (ran.returncode, ran.stderr) == (0, "")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("rank",), "there is no command 'rank'. Did you mean rank-pairs? `coast --help` lists them."),
        (("zzz",), "there is no command 'zzz'. `coast --help` lists them."),
        (("check",), "`coast init` writes one to start from."),
        (("rank-pairs", "{config}", "-o", "pairs.xlsx"), "A spreadsheet opens .csv."),
    ],
)
def test_a_newcomers_slip_is_answered_with_the_next_step(coast, reference, words, said):
    ran = coast(*(word.format(config=reference) for word in words))
    assert (ran.code, ran.out) == (2, "")
    assert said in ran.err


def test_a_pair_with_the_wrong_sign_between_is_told_the_right_one(coast, reference):
    assert (
        "'OUTER/MIDDLE', or one of MT1"
        in coast("stroke", reference, "--kappa", "1", "--x2", "9", "--pair", "OT4,MT1").err
    )


def test_a_bending_length_in_metres_is_doubted(coast, reference):
    assert "below one pitch, 0.6 mm: is it in mm?" in coast("stroke", reference, "--kappa", "20", "--x2", "0.02").err
    assert "is it in mm" not in coast("stroke", reference, "--kappa", "20", "--x2", "1").err


def test_the_list_of_commands_cuts_no_sentence(coast):
    assert "..." not in coast("--help").out.partition("Commands:")[2]
