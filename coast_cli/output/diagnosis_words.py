"""The words and figures that the terminal page and the report share: verdicts, places, units, uncertainties."""

from __future__ import annotations

from math import floor, isfinite, log10
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from coast_cli.diagnosis.answer import Carried, Diagnosis, Level, Named, SideBySide, Value
    from coast_cli.diagnosis.locate import Region
    from coast_cli.diagnosis.unnamed.forms import Curve

HEADLINES = {
    "agrees": "The model agrees with the recording.",
    "parameters": "The model agrees once its own parameters are refitted.",
    "physics": "The model leaves out physics.",
    "sensor": "The sensor, not the robot, disagrees with the model.",
    "ambiguous": "Something is left out; the recording cannot tell which.",
    "unnamed": "Something is left out that has no name here; a law without a name describes it.",
    "unexplained": "Something is left out that no effect of the catalogue explains.",
    "insufficient": "The recording cannot decide.",
}
_NOTHING = 1e-9
_EXACT = 1e-6  # relative; a spread below it says nothing
UNITS = {
    "curvature_per_m": "1/m",
    "bend_deg": "deg",
    "notch_deg": "deg",
    "shape_mm": "mm",
    "position_mm": "mm",
    "force_n": "N",
}
# Names and units of the axes of a region; DRIVE stands for the unit of the drive.
AXES = {
    "direction": ("on", ""),
    "stroke": ("stroke", "mm"),
    "tension": ("tension", "N"),
    "curvature": ("curvature", "1/m"),
    "bending_length": ("bending length", "mm"),
    "load": ("load", "N (N m)"),
    "time": ("time", "s"),
    "rate": ("rate", "DRIVE/s"),
    "cycle": ("cycle", ""),
    "run": ("run", ""),
    "pair": ("pair", ""),
    "notch": ("notch", ""),
    "arc_length": ("arc length", "mm"),
}


def unit_words(diagnosis: Diagnosis) -> str:
    """Return the unit of the response as people write it."""
    return UNITS.get(diagnosis.noise_unit, diagnosis.noise_unit)


def axis_unit(region: Region, drive_unit: str) -> str:
    """Return the unit of a region's edges, or an empty text."""
    return AXES.get(region.axis, ("", ""))[1].replace("DRIVE", drive_unit)


def place(region: Region, drive_unit: str) -> str:
    """Return a region in words, e.g. ``stroke 1.2 to 3 mm``."""
    name, unit = AXES.get(region.axis, (region.axis, ""))[0], axis_unit(region, drive_unit)
    if region.value is not None:
        return f"{name} {region.value}"
    low, high = _edge(region.low), _edge(region.high)
    return f"{name} {low if low == high else f'{low} to {high}'} {unit}".rstrip()


def _edge(value: float | None) -> str:
    return "..." if value is None else f"{value if abs(value) > _NOTHING else 0.0:.3g}"


def measured(value: Value) -> str:
    """Return a number with its standard deviation, both to the digits that count, and whether it is on a bound."""
    if value.at_bound:
        return f"{value.value:.4g}, on its bound"
    if not (isfinite(value.std) and value.std > 0.0):
        return f"{value.value:.4g}, not determined"
    if value.std < _EXACT * abs(value.value):
        return f"{value.value:.6g}"
    if value.std > 10.0 * abs(value.value) and value.std > 1e-9:
        return f"{value.value:.2g} +- {value.std:.2g}"
    digits = min(max(1 - floor(log10(value.std)), 0), 9)
    return f"{value.value:.{digits}f} +- {value.std:.{digits}f}"


def rounded(value: float | None) -> str:
    """Return an error with three digits, or a dash."""
    return "-" if value is None or not isfinite(value) else f"{value:.3g}"


def mismatch(found: Diagnosis) -> str:
    """Return the first answer: the base model's error beside the noise."""
    unit, fit = unit_words(found), found.comparison
    if fit is None:
        return f"Not decided; the noise of the recording is {rounded(found.noise)} {unit}."
    agrees = found.verdict in {"agrees", "parameters"}
    level, words = (fit.configured, "as configured") if found.verdict == "agrees" else (fit.refitted, "refitted")
    return (
        f"{'No' if agrees else 'Yes'}: the base model {words} is off by {rounded(judged(level))} {unit} RMS, "
        f"the noise is {rounded(found.noise)} {unit}."
    )


def levels(found: Diagnosis) -> list[tuple[str, str, str, str]]:
    """Return rows of the table of errors: model, train, held out, and the judged one in noise levels."""
    fit = found.comparison
    if fit is None:
        return []
    models = [("as configured", fit.configured), ("base refitted", fit.refitted)]
    if found.effects or found.attempts or found.verdict == "unnamed":
        words = "with effects" if found.effects else "with the law" if found.verdict == "unnamed" else "closest effects"
        models.append((words, fit.with_effects))
    rows = [
        (words, rounded(level.train), rounded(level.held_out), _in_noise(judged(level), found.noise))
        for words, level in models
    ]
    return [*rows, ("noise", rounded(found.noise), "", "")]


def _in_noise(error: float, noise: float) -> str:
    return f"{error / noise:.2g} x" if noise > 0.0 else "-"


def judged(level: Level) -> float:
    """Return the error that counts: on rows held out, or on those fitted where nothing was held out."""
    return level.train if level.held_out is None else level.held_out


def gained(fit: SideBySide) -> str:
    """Return what the effects gain over the refitted base, as a sentence that can also say no."""
    before, after = judged(fit.refitted), judged(fit.with_effects)
    where = "fitted rows only, no proof" if fit.with_effects.held_out is None else "held out"
    if after >= before or before <= 0.0:
        return f"No: {rounded(after)} against {rounded(before)} of the refitted base ({where})."
    return f"Yes: {100.0 * (1.0 - after / before):.0f} % less error than the refitted base ({where})."


def percent(share: float) -> str:
    """Return a probability or share; one near certainty is not rounded up to it."""
    return f"{100.0 * share:.0f} %" if share < 0.995 else "over 99 %"


def chance(probability: float) -> str:
    """Return a p-value."""
    return "< 1e-99" if probability < 1e-99 else f"{probability:.0e}"


def told(found: Diagnosis) -> tuple[str, str] | None:
    """Return what is said of a law without a name, and its equation; None where there is none."""
    law = found.unnamed
    if law is None:
        return None
    beside = "What the names leave: " if found.effects else "A part of it. " if found.verdict == "unexplained" else ""
    return f"{beside}{law.words}", law.equation


def curve_words(curve: Curve) -> str:
    """Return what a law's curve is, for its table or picture."""
    band = ", with its 90 % band" if curve.low else "; its band is not known"
    return f"The law over the range seen{band}"


def others(found: Diagnosis) -> str:
    """Return the alternatives as a list."""
    return "; ".join(" + ".join(ids) for ids in found.alternatives)


def named(effect: Named) -> str:
    """Return an effect with its place and how sure its name is."""
    sure = percent(effect.confidence)
    return f"{effect.id}: {effect.title} ({effect.component}; {effect.kind}), confidence {sure}"


def tip_words(found: Diagnosis) -> str:
    """Return the errors at the tip, as a sentence."""
    fit = found.comparison
    if fit is None or not isfinite(fit.tip_mm_refitted):  # a device without tubes has no tip
        return ""
    with_effects = f", {rounded(fit.tip_mm_with_effects)} mm with effects" if found.effects else ""
    return f"Tip: {rounded(fit.tip_mm_refitted)} mm refitted{with_effects}."


def nowhere(found: Diagnosis) -> str:
    """Return what is said where no region is found."""
    if found.comparison is None:
        return "Not decided."
    return "Nowhere: no part of the recording holds more error than the rest."


def held_out(fit: SideBySide) -> str:
    """Return what was held out, as a sentence."""
    runs = ", ".join(fit.held_out_runs)
    return f"Held out: {runs} ({fit.rule})." if runs else f"Held out: {fit.rule}."


def sentence(text: str) -> str:
    """Return the text as a sentence; a parameter's name that begins it keeps its letters."""
    begins_with_name = "_" in text.partition(" ")[0]
    begun = text if begins_with_name else text[:1].upper() + text[1:]
    return begun if begun.endswith((".", "?", "!")) else f"{begun}."


def carried_over(carried: Carried, unit: str) -> str:
    """Return what the joint took over from the shapes and what that changes in it, as sentences."""
    if carried.without is None or carried.with_it is None:
        return f"The shapes find nothing in the tubes that a joint would share (verdict: {carried.shapes.verdict})."
    said = (
        "What they find in the tubes is part of the model above."
        if carried.config is not None
        else ("The strokes contradict what they find in the tubes, so it is not part of the model above.")
    )
    before, after = ([_on_rows(level) for level in pair] for pair in (carried.without, carried.with_it))
    held = "train / held out" if carried.with_it[0].held_out is not None else "train"
    return (
        f"{said} Error of the joint in {unit} ({held}), without and with it: as configured {before[0]} and {after[0]}, "
        f"base refitted {before[1]} and {after[1]}."
    )


def _on_rows(level: Level) -> str:
    return rounded(level.train) if level.held_out is None else f"{rounded(level.train)} / {rounded(level.held_out)}"


def shared_rows(carried: Carried) -> list[tuple[str, str, str, str, str]]:
    """Return the numbers that both measure: name, by shapes, by strokes, by both, whether they agree."""
    return [
        (
            one.name,
            measured(one.shapes),
            "cannot tell" if one.joint is None else measured(one.joint),
            "" if one.together is None else measured(one.together),
            "" if one.agree is None else "yes" if one.agree else "no",
        )
        for one in carried.shared
    ]


SHARED_COLUMNS = ("shared with the shapes", "by shapes", "by strokes", "by both", "agree")
