"""One diagnosis for whatever a call was given: joint recordings, shapes, or both, which then share their tubes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from coast_cli.diagnosis.asked import Asked
from coast_cli.errors import BadInput, nearest

if TYPE_CHECKING:
    from coast_cli.diagnosis.answer import Diagnosis
    from coast_cli.diagnosis.recorded_answer import RecordedDiagnosis
    from coast_cli.recordings.model import JointRun, Recordings
    from coast_cli.spec.config import Config


def diagnose(
    config: Config,
    recordings: Recordings,
    *,
    hold_out: Sequence[str] = (),
    max_effects: int = 5,
    without: Sequence[str] = (),
    noise: float | None = None,
) -> RecordedDiagnosis:
    """Return what the model left out, when recordings disagree with it: the diagnosis of a call's recordings.

    Args:
        config: of the tubes that were recorded. recordings: from ``read_recordings``.
        hold_out: names of runs that no fit may see. max_effects: largest set that is tried.
        without: ids of effects that are neither named nor rivals.
        noise: of the response where it is known, in 1/m, deg, or mm for shapes alone.

    Raises:
        BadInput: joint runs of several kinds in one call, a run to hold out or an effect that does not exist.
        UsageError: a noise that is none.

    Example:
        >>> config = coast.load_config(coast.REFERENCE)
        >>> table = {"stroke_mm": [1.5, 2.5, 3.5], "curvature_per_m": [1.0, 10.0, 20.0], "bending_length_mm": 30.0}
        >>> coast.diagnose(config, coast.read_recordings(table, config)).verdict
        'insufficient'
    """
    from coast_cli.diagnosis.recorded_answer import RecordedDiagnosis
    from coast_cli.recordings.given import require_read

    require_read(config, recordings)
    _check_runs(recordings, hold_out)
    _check_effects(without)
    asked = Asked(tuple(hold_out), max_effects, tuple(without), _noise(recordings, noise))
    return RecordedDiagnosis.of(_diagnosed(config, recordings, asked), config, recordings)


def _diagnosed(config: Config, recordings: Recordings, asked: Asked) -> Diagnosis:
    if recordings.joint is not None:
        from coast_cli.diagnosis.joint import diagnose_joint

        _check_one_kind(recordings.joint.runs)
        _check_units(config, recordings.joint.runs)
        if recordings.shape is not None:
            from coast_cli.diagnosis.together import diagnose_together

            return diagnose_together(config, recordings, asked)
        return diagnose_joint(config, recordings.joint.runs, **asked.options)
    if recordings.shape is not None:
        from coast_cli.diagnosis.shapes import diagnose_shapes

        return diagnose_shapes(config, recordings.shape.runs, **asked.options)
    raise BadInput("no recording given", allowed="one or more CSV files")


def _noise(recordings: Recordings, noise: float | None) -> float | None:
    """Return a known noise in SI; of shapes alone it is given in mm."""
    from coast_cli.recordings.summary import known_noise
    from coast_cli.units import MILLIMETRE

    if noise is not None and recordings.joint is None and 0.0 < noise < float("inf"):
        return noise * MILLIMETRE
    return known_noise(recordings, noise)


def _check_effects(ids: Sequence[str]) -> None:
    from coast_cli.effects.catalogue import CATALOGUE
    from coast_cli.effects.own import add_installed

    add_installed()
    known = sorted(CATALOGUE)
    for identifier in ids:
        if identifier not in known:
            hint = nearest(identifier, known) or None
            raise BadInput("there is no such effect to leave out", found=identifier, hint=hint)


def _check_runs(recordings: Recordings, named: Sequence[str]) -> None:
    for name in named:
        if name not in recordings.run_names:
            raise BadInput(
                "there is no such run to hold out",
                found=name,
                allowed=", ".join(recordings.run_names),
                hint=nearest(name, recordings.run_names) or None,
            )


def _check_one_kind(runs: Sequence[JointRun]) -> None:
    """Refuse runs whose errors cannot be pooled: one response, of as many notches, and one drive."""
    first = runs[0]
    for run in runs[1:]:
        if (run.kind, run.response.shape[1], run.stroke is None) != (
            first.kind,
            first.response.shape[1],
            first.stroke is None,
        ):
            raise BadInput(
                f"run {run.name!r} records another response or drive than {first.name!r}",
                file=run.source,
                line=int(run.line[0]),
                found=_words(run),
                allowed=_words(first),
                hint="Diagnose them in calls of their own.",
            )


def _check_units(config: Config, runs: Sequence[JointRun]) -> None:
    """Refuse a response in another unit than it says: no segment is usually bent tighter than its tube is thick."""
    import numpy as np

    from coast_cli.spec.build import build
    from coast_cli.spec.transmission import is_transmission

    if is_transmission(config):
        return
    design = build(config)
    for run in runs:
        length = run.bending_length[:, np.newaxis] / run.response.shape[1]
        curvature = np.abs(run.response if run.kind == "curvature" else run.response / length)
        usual = float(np.nanmedian(curvature))
        limit = 1.0 / design.tube(run.middle).outer_radius
        if usual > limit:
            raise BadInput(
                f"run {run.name!r} is bent tighter than its tube is thick",
                file=run.source,
                line=int(run.line[0]),
                found=f"{usual:.3g} 1/m",
                allowed=f"up to {limit:.3g} 1/m",
                hint="Is the unit in the column's name right?",
            )


def _words(run: JointRun) -> str:
    notches = f" of {run.response.shape[1]} notches" if run.kind == "notch" else ""
    return f"{run.kind}{notches} over {'tension' if run.stroke is None else 'stroke'}"
