"""The corrected model as a configuration that runs: refitted numbers in place, and a [corrections] table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from coast_cli.diagnosis.joint.problem import CONFIG_KEYS
from coast_cli.spec.edit import path_of, written
from coast_cli.version import __version__

if TYPE_CHECKING:
    from coast_cli.diagnosis.answer import Diagnosis
    from coast_cli.diagnosis.joint.calibration import Calibration
    from coast_cli.diagnosis.spread import Spread
    from coast_cli.effects.effect import Effect, RecordingKind
    from coast_cli.recordings.model import Recordings
    from coast_cli.spec.config import Config


def model_text(config: Config, diagnosis: Diagnosis, recordings: Recordings, name: str = "<model>") -> str:
    """Return the TOML of the corrected model; it has been read back once, so it loads.

    Args:
        config: the model that was diagnosed; its own corrections stay.
        diagnosis: whose refitted parameters and effects go into it.
        recordings: named with their SHA-256 in the comment at the top.
        name: the file the text is for, in errors.

    Raises:
        BadInput: a fitted number lies outside what a configuration may hold.

    Example:
        >>> config = coast.load_config(coast.REFERENCE)
        >>> table = {"stroke_mm": [1.5, 2.5, 3.5], "curvature_per_m": [1.0, 10.0, 20.0], "bending_length_mm": 30.0}
        >>> recordings = coast.read_recordings(table, config)
        >>> text = coast.model_text(config, coast.diagnose(config, recordings), recordings)
        >>> "Written by coast diagnose" in text
        True
    """
    from coast_cli.spec.load import load_config_text

    document = config.model_dump(exclude_unset=True)
    fitted: dict[str, Any] = {
        CONFIG_KEYS.get(parameter, parameter): value  # of shapes they are keys already
        for parameter, value in diagnosis.model_parameters.items()
    }
    for key, value in (*fitted.items(), *diagnosis.model_tubes.items()):
        put_number(document, key, value)
    found: dict[str, Any] = {}
    for effect in diagnosis.model_effects:
        key = _free_key(effect.id, {**config.corrections, **found})
        found[key] = _correction(effect, diagnosis.recording)
    # An effect of joint and shapes alike has one table, in which each finds its own parameters.
    corrections = {
        **config.corrections,
        **{name: {**config.corrections.get(name, {}), **new} for name, new in found.items()},
    }
    if corrections:
        document["corrections"] = corrections
    put_spread(document, diagnosis.model_spread)
    notes = dict.fromkeys((*fitted, *diagnosis.model_tubes), "fitted by coast diagnose")
    text = _annotated(_origin(config, diagnosis, recordings), document, config, notes)
    load_config_text(text, name)
    return text


def calibrated_text(config: Config, calibration: Calibration, recordings: Recordings, name: str = "<model>") -> str:
    """Return the TOML of a configuration with its calibrated numbers; it has been read back once, so it loads."""
    from coast_cli.spec.digest import config_digest
    from coast_cli.spec.load import load_config_text

    document = config.model_dump(exclude_unset=True)
    for parameter, value in calibration.whole.values.items():
        put_number(document, CONFIG_KEYS[parameter], value)
    put_spread(document, calibration.spread)
    lines = [
        f"Written by coast calibrate, version {__version__}.",
        f"Configuration {config.source or '<text>'}, sha256 {config_digest(config)}",
        *(f"Recording {path}, sha256 {digest}" for path, digest in recordings.sources),
        *(
            f"Fitted {one.parameter.key} = {one.value:.6g}, 90 % interval {one.low:.6g} to {one.high:.6g}"
            for one in calibration.whole.estimates
        ),
        *(note for note in calibration.notes if "wants" not in note),
    ]
    notes = {
        one.parameter.key: f"fitted by coast calibrate, 90 % {one.low:.6g} to {one.high:.6g}"
        for one in calibration.whole.estimates
    }
    notes |= {CONFIG_KEYS[name]: "fixed in coast calibrate" for name in calibration.whole.posed.fixed}
    text = _annotated(lines, document, config, notes)
    load_config_text(text, name)
    return text


def _free_key(identifier: str, taken: Mapping[str, Any]) -> str:
    """Return the key of a correction: a law without a name does not take the place of one that is there."""
    if not identifier.startswith("unnamed_") or identifier not in taken:
        return identifier
    return next(key for key in (f"unnamed_{number}" for number in range(1, 100)) if key not in taken)


def _correction(effect: Effect, recording: RecordingKind) -> dict[str, Any]:
    """Return the table of a correction; what is not the tubes' own says on which kind of recording it was found."""
    from coast_cli.effects.unnamed import UnnamedLaw
    from coast_cli.effects.unnamed_shape import ShapeLaw

    if isinstance(effect, UnnamedLaw | ShapeLaw):
        return effect.table()
    numbers = effect.numbers()
    values: dict[str, Any] = {p.name: float(numbers[p.name]) for p in effect.parameters_on(recording)}
    if effect.scope != "tube":
        values["recording"] = recording
    return values


def _annotated(lines: list[str], document: dict[str, Any], config: Config, notes: Mapping[str, str]) -> str:
    """Return the text of a document below ``lines`` of comment; the comments of the configuration's own text stay."""
    paths = {path_of(document, key): note for key, note in notes.items()}
    paths |= {(*path, "value"): note for path, note in paths.items()}
    body = written(document, config.origin.text, paths)
    return _comments(lines) + ("#\n" if body.startswith("#") else "\n") + body


def put_number(document: dict[str, Any], key: str, value: float | list[float]) -> None:
    """Replace a number by its dotted key; of ``{ value, min, max }`` the value moves and the bounds stay."""
    *tables, last = key.split(".")
    table: Any = document
    for part in tables:
        table = _step(table, part)
    before = table.get(last)
    if isinstance(before, Mapping) and not isinstance(value, list):
        table[last] = {**before, "value": min(max(value, before["min"]), before["max"])}
    else:
        table[last] = value


def put_spread(document: dict[str, Any], spread: Spread | None) -> None:
    """Replace the table of how sure the fitted numbers are; an earlier fit's goes, as its numbers have moved."""
    table = None if spread is None else spread.table(lambda key: _has(document, key))
    document.pop("fitted", None)
    if table is not None:
        document["fitted"] = table


def _has(document: Mapping[str, Any], key: str) -> bool:
    """Return whether a dotted key is in the document; a table of tables only, not of lists."""
    place: Any = document
    for part in key.split("."):
        if not isinstance(place, Mapping) or part not in place:
            return False
        place = place[part]
    return isinstance(place, float | int | Mapping)


def _step(table: Any, part: str) -> Any:  # noqa: ANN401
    """Go one table down; a sample of a stock is found by its name."""
    if isinstance(table, dict):
        return table.setdefault(part, {})
    return next(item for item in table if item["name"] == part)


def _origin(config: Config, diagnosis: Diagnosis, recordings: Recordings) -> list[str]:
    from coast_cli.spec.digest import config_digest

    ids = (
        ", ".join(dict.fromkeys([*(e.id for e in diagnosis.effects), *(e.id for e in diagnosis.model_effects)]))
        or "none"
    )
    lines = [
        f"Written by coast diagnose, version {__version__}. Verdict: {diagnosis.verdict}; effects added: {ids}.",
        f"Configuration {config.source or '<text>'}, sha256 {config_digest(config)}",
        *(f"Recording {path}, sha256 {digest}" for path, digest in recordings.sources),
    ]
    fit = diagnosis.comparison
    if fit is not None:
        lines.append(f"Held out: {', '.join(fit.held_out_runs) or 'no whole run'} ({fit.rule}).")
        for label, level in (("refitted", fit.refitted), ("with effects", fit.with_effects)):
            held = "none" if level.held_out is None else f"{level.held_out:.6g}"
            lines.append(f"RMS error {label}, {fit.unit}: train {level.train:.6g}, held out {held}.")
    return lines


def _comments(lines: list[str]) -> str:
    return "".join("# " + "".join(c if c.isprintable() else "?" for c in line) + "\n" for line in lines)
