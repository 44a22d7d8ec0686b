"""``coast diagnose``: what physics a model left out, when recordings disagree with it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument
from coast_cli.cli.paths import WRITES
from coast_cli.cli.recording_options import (
    BendingLengthOption,
    ColumnsOption,
    FromOption,
    HoldOutOption,
    RecordedPairOption,
    RecordingsArgument,
    ToOption,
)


def diagnose(
    config: ConfigArgument,
    recordings: RecordingsArgument,
    *,
    hold_out: HoldOutOption = None,
    columns: ColumnsOption = None,
    pair: RecordedPairOption = None,
    x2: BendingLengthOption = None,
    begin: FromOption = None,
    end: ToOption = None,
    max_effects: Annotated[int, typer.Option(min=0, max=12, help="largest set of effects that is tried")] = 5,
    without: Annotated[
        str | None, typer.Option(metavar="ID,...", help="effects left out of the catalogue: neither named nor rivals")
    ] = None,
    noise: Annotated[
        float | None, typer.Option(help="of the recording where it is known, in the unit of the response")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="of random numbers; it stands in the provenance")] = 0,
    format: Annotated[
        str | None, typer.Option("--format", "-f", metavar="FORMAT", help="table or json, to stdout")
    ] = None,
    output: Annotated[
        list[Path] | None,
        typer.Option("--output", "-o", metavar="FILE", help="write a .txt or .json file; repeatable"),
        WRITES,
    ] = None,
    save_model: Annotated[
        Path | None,
        typer.Option(metavar="FILE.toml", help="write the corrected model, for stroke, check and compare"),
        WRITES,
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="draw recording, models and residuals"), WRITES
    ] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="FILE.html", help="write one self-contained page"), WRITES
    ] = None,
    fail_on_mismatch: Annotated[
        bool, typer.Option("--fail-on-mismatch", help="exit 1 unless the model agrees within the noise")
    ] = False,
) -> int:
    """Say whether recordings disagree with the model, where, what was left out, the model with it, and if it fits.

    Without --hold-out the runs kept back are chosen by a rule, which the answer states.
    """
    from coast_cli.diagnosis.recorded import diagnose as diagnosis_of
    from coast_cli.diagnosis.thresholds import thresholds_digest
    from coast_cli.diagnosis.unnamed.seen import notes_on_range
    from coast_cli.output.diagnosis import DiagnosisAnswer, Outputs, write_diagnosis
    from coast_cli.output.progress import waiting
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import say
    from coast_cli.recordings.mapping import mapping_of
    from coast_cli.recordings.read import read_recordings
    from coast_cli.recordings.window import between
    from coast_cli.spec.load import load_config

    outputs = Outputs(format, tuple(output or ()), save_model, plot, report)
    outputs.check()
    concealed = [name for part in (without or "").split(",") if (name := part.strip())]
    document = load_config(config)
    read = read_recordings(recordings, document, columns=mapping_of(columns), pair=pair, bending_length_mm=x2)
    read = between(read, begin, end)
    with waiting(f"diagnosing {', '.join(read.run_names[:3])}{' ...' if len(read.run_names) > 3 else ''}"):
        found = diagnosis_of(
            document,
            read,
            hold_out=hold_out or (),
            max_effects=max_effects,
            without=concealed,
            noise=noise,
        )
    options = {"max_effects": max_effects, "hold_out": list(hold_out or ()), "without": concealed, "noise": noise}
    options |= {"from": begin, "to": end}
    options = {name: value for name, value in options.items() if value not in ([], None) or name == "hold_out"}
    origin = {
        **provenance(document, recordings=read.sources, options=options, seed=seed),
        "thresholds_sha256": thresholds_digest(),
    }
    notes = (*read.notes, *notes_on_range(document, read))
    for note in notes:
        say(f"note: {note}")
    write_diagnosis(DiagnosisAnswer(found, found.config_used(document), read, origin, notes), outputs)
    agrees = found.verdict == "agrees" and (found.carried is None or found.carried.shapes.verdict == "agrees")
    return 1 if fail_on_mismatch and not agrees else 0
