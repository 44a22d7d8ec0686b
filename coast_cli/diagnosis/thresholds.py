"""Every number that can change a verdict, in one place: value, unit, what it means and how it was set.

A threshold is a float that knows the rest. Numbers that only make a search faster stand where they are used. None is set to
the misfit of one rig. ``thresholds_digest`` stands in the provenance of every diagnosis, so that answers can be told apart.
"""

from __future__ import annotations

from hashlib import sha256

from coast_cli.recordings.thresholds import REASON as _REASON
from coast_cli.recordings.thresholds import RECORDED, Threshold

# How numbers were set. "pilot": README of examples/concealed, `python -m examples.concealed all --seeds FIRST:LAST`.
_ODDS = "odds of examples.concealed, seeds 0 to 96"
_PILOT = "pilot of concealed cases, examples/concealed"
_CLEAN = "largest on clean simulated recordings, level L0 of examples/concealed"


# The contest.
EFFECT_NATS = Threshold(7.0, "nats", "by which an effect must beat the set without it", _PILOT)
SMALLEST = Threshold(
    0.35, "noise levels", "RMS change below which an effect is not named: every record has that", _PILOT
)
SMALLEST_PART = Threshold(0.1, "of the base model's error", "change of a shape below which nothing is named", _PILOT)
ALIKE_NATS = Threshold(4.0, "nats", "behind the leading set within which another one tells the same", _PILOT)
TIE = Threshold(0.05, "nats", "within which scores are equal, and fewer parameters go first", _REASON)
WORTH_GROWING = Threshold(4.0, "nats", "of plain error that one more effect must take for another to be tried", _PILOT)
GROWS_BY = Threshold(0.1, "of the error", "that a third and any further effect must take for more to be tried", _REASON)
QUIET = Threshold(1.9, "noise levels", "up to which a smooth gain may be the colour of the noise", _CLEAN)
AT_FLOOR = Threshold(1.12, "noise levels", "of error under which nothing is left to be explained", _CLEAN)
ONE_SAMPLE_SHARE = Threshold(0.85, "", "share of a gain that one sample may make: above, it is an outlier", _REASON)
CLOSE_ENDS = Threshold(
    12.0, "nats", "behind the leading set within which sets are decided again on every point", _PILOT
)
MOST_CLOSE_ENDS = Threshold(6, "sets", "that are decided again", _PILOT)
ENOUGH_EXPLAINED = Threshold(0.07, "of the base model's error", "below which sets of a shape do not grow", _PILOT)

# What is left over.
ABOVE_NOISE = Threshold(1.9, "noise levels", "above which an error is not explained by noise", _CLEAN)
FAR_ABOVE_NOISE = Threshold(
    2.5, "noise levels", "the same where nothing was named: a camera's drift reaches 2.2", _CLEAN
)
POINTS_ABOVE_NOISE = Threshold(1.5, "noise levels", "the same of a shape, whose noise is that of its points", _CLEAN)
MAX_UNEXPLAINED_NOISE = Threshold(0.6, "noise levels", "of structure that may be left", _PILOT)
MAX_UNEXPLAINED_SHARE = Threshold(0.35, "of what was explained", "structure that may be left", _PILOT)
MAX_UNEXPLAINED_SHARE_OF_SETS = Threshold(
    0.22, "of what was explained", "the same of a set: two effects that bend against each other draw anything", _PILOT
)
UNEXPLAINED_SOFTNESS = Threshold(0.08, "of what was explained", "over which confidence falls at that share", _PILOT)
REPEATS = Threshold(
    0.45, "of the error's power", "that other runs must predict to count; slow noise reaches 0.4", _CLEAN
)
POINTS_REPEAT = Threshold(0.35, "of the error's power", "the same of photographs of one tube", _CLEAN)
SMOOTHER_NATS = Threshold(6.0, "nats", "by which a residual must be likelier smooth than noise to count", _CLEAN)
SMOOTH_MISFIT = Threshold(
    0.155, "noise levels", "of a smooth misfit that every record has and no parameter takes", _PILOT
)
SMOOTH_MISFIT_SHAPES = Threshold(6.0, "shapes", "that it has", _PILOT)

# Base parameters.
PARAMETERS_NATS = Threshold(6.0, "nats", "that a refit must gain for base parameters to have moved", _PILOT)
PARAMETERS_SIZE = Threshold(0.35, "noise levels", "by which it must change the fit", _PILOT)
MODULUS_MOVED = Threshold(0.03, "of its logarithm", "by which a modulus has moved", _REASON)

# Weak priors on base parameters, where a configuration gives no {min, max} of its own.
MODULUS_PRIOR = Threshold(0.5, "of its logarithm", "standard deviation of a modulus", _REASON)
NOTCH_FRICTION_PRIOR = Threshold(0.01, "", "standard deviation of the factor a notch", _REASON)
DEADBAND_PRIOR = Threshold(1.0, "mm", "standard deviation of the deadband", _REASON)
TENDON_MODULUS_PRIOR = Threshold(0.1, "of its logarithm", "standard deviation of the tendon's modulus", _REASON)
CURVATURE_PRIOR = Threshold(0.5, "of its configured value", "standard deviation of a natural curvature", _REASON)
CURVATURE_TURN_PRIOR = Threshold(0.3, "rad over the whole tube", "the same, at least", _REASON)
# From tube to tube about the table of sharp-cornered periodic cells: tubes solved whole as 3-D solids need 1.00 to 1.10 of
# their cells', and the corners of a laser's cut are round.
END_EFFECT_SPREAD = Threshold(0.06, "of the table", "standard deviation of a tube's end effect", "examples/solid")

# Unseen rows.
MAX_HELD_OUT_SHARE = Threshold(0.55, "of the base model's error", "on unseen rows that a named set may leave", _PILOT)
HARM = Threshold(
    1.1, "of the base model's error", "on unseen rows within the noise that still counts as no harm", _PILOT
)
NEEDED = Threshold(1.01, "", "factor by which unseen rows must be missed more without an effect of a set", _PILOT)
AS_EXPECTED = Threshold(1.5, "", "times the expected error by which unseen points may be missed", _PILOT)
UNFELT = Threshold(0.1, "noise levels", "of change under which an effect has gone", _REASON)
CARRIES_TO_JOINT = Threshold(1.1, "", "factor by which shapes may worsen the joint's unseen error", _PILOT)
AGREE_SIGMA = Threshold(2.6, "standard deviations", "within which two measurements agree, 1 % by chance", _REASON)

# Confidence.
SUREST = Threshold(0.95, "", "probability that no name exceeds: the concealed cases bear out no more", _PILOT)
REFUSED_NAMES = Threshold(
    0.1, "", "probability that one of the names that came nearest is right where none is given", _PILOT
)
NAMED_FROM = Threshold(
    0.65,
    "",
    "probability from which on a name is given: a wrong one costs two, no name where none is right gains one",
    _ODDS,
)
LEAST_SURE = Threshold(0.01, "", "probability that no name falls below", _REASON)
TEMPER = Threshold(2.0, "", "by which nats between rivals are divided, as noise models are never right", _PILOT)

# Laws without a name.
LACK_OF_FIT = Threshold(
    0.006, "", "share of draws of noise alone that ask as loudly for a law, under which more is wanted", _REASON
)
LEFT_TO_SAY = Threshold(0.5, "noise widths", "beyond the noise that are said to be left", _REASON)
LAW_NATS = Threshold(8.0, "nats", "by which a law must be ahead of no law", _PILOT)
LAW_UNSEEN = Threshold(3.0, "nats", "by which the rows that choose must be foretold better with a law", _PILOT)
LAW_CERTIFIED = Threshold(
    0.8, "of the error without it", "on rows that neither fitted nor chose, that a law may leave", _REASON
)
LEAST_MISFIT = Threshold(
    1.6, "noise widths", "on unseen rows, slow noise granted, under which no law is wanted", _CLEAN
)
LEAST_OF_ONE_RUN = Threshold(3.0, "noise widths", "in that run, slow noise granted, for one run to be blamed", _CLEAN)
LAW_TIE = Threshold(4.0, "nats", "behind the leading law within which another one tells the same", _PILOT)
REFUSING_NATS = Threshold(12.0, "nats", "by which a law elsewhere must be ahead of a name to refuse it", _PILOT)

# What a recording can decide at all.
FEWEST_SAMPLES = Threshold(12, "samples", "of a joint below which nothing is decided", _REASON)
FEWEST_POINTS = Threshold(10, "points", "of shapes below which nothing is decided", _REASON)
SAMPLES_A_PARAMETER = Threshold(3, "samples", "that each base parameter needs", _REASON)
STILL_NOISE = Threshold(1.3, "noise levels", "of movement of a response that may be noise alone", _CLEAN)
MAX_UNEXPLAINED_FRACTION = Threshold(
    0.5, "of its movement", "that a model may leave of a response that does move", _PILOT
)

# Noise and outliers.
SLOW_NOISE = Threshold(1.6, "", "times the floor that slow noise may add: clean base fits end within 2.1 of it", _CLEAN)
DIFFERENCES_MARGIN = Threshold(1.6, "", "times the noise of second differences that the floor may be", _CLEAN)
FLOOR_DOUBT = Threshold(0.7, "of a logarithm", "of doubt in a joint's noise that is granted at most", _REASON)
POINTS_DOUBT = Threshold(0.5, "of a logarithm", "of doubt in the noise of points that is granted at most", _REASON)
FEWEST_TO_SCREEN = Threshold(7, "samples", "of a column in which outliers are sought", _REASON)
OUTLIER_NOISE = Threshold(7.0, "noise levels", "off its neighbours beyond which a sample is an outlier", _CLEAN)
OUTLIER_SPREAD = Threshold(0.5, "of the usual step", "that is added to it", _CLEAN)
OUTLIER_MOVED = Threshold(2.0, "of what the drive explains", "that is added to it", _CLEAN)

# Where.
SIGNIFICANT = Threshold(0.01, "", "p-value above which no region is said", _REASON)
FEWEST_IN_REGION = Threshold(8, "samples", "inside and outside a region", _REASON)
EVEN_AXIS = Threshold(0.02, "of its largest value", "spread below which an axis is one value with jitter", _REASON)
PAIR_SHARE = Threshold(0.5, "of the excess error", "that one tube must hold to be named as its place", _REASON)

# Rows kept back.
BLOCKS = Threshold(8, "blocks", "that a run is cut into where no whole run can be spared", _REASON)
SHORTEST_FOR_BLOCKS = Threshold(48, "samples", "of a run that is cut into blocks", _REASON)
SHORTEST_SHAPE_FOR_BLOCKS = Threshold(32, "points", "of a shape that is cut into blocks", _REASON)
FEWEST_IN_BRANCH = Threshold(8, "samples", "of a branch that counts as a part of a cycle", _REASON)
LEAST_KEPT_BACK = Threshold(0.15, "of a run", "that is kept back after its first cycle, at least", _REASON)
MOST_KEPT_BACK = Threshold(0.6, "of a run", "that is kept back after its first cycle, at most", _REASON)

FEWEST_RUNS_TO_DIFFER = Threshold(3, "runs", "that are fitted, from which on one can be told from the rest", _REASON)
FROZEN_SHARE = Threshold(0.05, "of all rows", "that repeat the frame before them, from which on it is said", _REASON)
FEWEST_RUNS_TO_SPARE = Threshold(4, "runs", "left, from which on one of them chooses among hypotheses", _REASON)
MOST_UNSEEN_NOISE = Threshold(
    1.5, "noise widths", "beyond the noise and the fit's doubt that unseen rows may lie", _REASON
)
BY_CHANCE = Threshold(0.01, "", "chance that noise alone makes rows or runs look missed, over all runs asked", _REASON)
LONE_SHARE = Threshold(0.03, "of rows", "that may stand far off for them to be outliers and no misfit", _REASON)
UNSEEN_DOUBT = Threshold(1.9, "standard deviations", "of the fit's own doubt that unseen rows are granted", _REASON)
MAX_UNEXPLAINED_SHARE_OF_DEVICES = Threshold(
    0.5,
    "of what was explained",
    "the same of a transmission, whose base is a line: its gears and levers are none",
    _REASON,
)
MOST_BEHIND_OF_DEVICES = Threshold(
    1.5, "times the error of another set, no larger", "above which a set of a transmission does not lead", _REASON
)
SLOWEST_NOISE_OF_DEVICES = Threshold(
    0.5,
    "from row to row",
    "memory of the noise of a transmission at most: what is slower is what its line leaves",
    _REASON,
)
LEAST_TAKEN_OF_DEVICES = Threshold(
    0.25, "of the error without it", "that each effect of a transmission's set must take", _REASON
)

# Shapes as photographs are.
ENDS_EARLY = Threshold(0.003, "of the tube", "by which a trace must be short for its end not to be the tip", _REASON)
BEGINS_LATE = Threshold(0.03, "of the tube", "after the clamp at which a trace must begin for it to be said", _REASON)
ENDS_EARLY_NATS = Threshold(3.0, "nats", "that a trace pays which ends before the tip", _REASON)
MOMENT_NATS = Threshold(
    10.0, "nats", "that one more moment of lost steps must explain: one row in some hundreds", _REASON
)
OWN_FORM_NATS = Threshold(24.0, "nats", "by which a law must be ahead of a name that stands at its stage", _REASON)

# The odds that a joint's names are right: log odds, less a weight times each figure that speaks against them.
ODDS_CONSTANT = Threshold(2.29, "log odds", "of names against which nothing speaks", _ODDS)
ODDS_LEFT = Threshold(0.72, "log odds", "a unit of log(1 + noise widths left)", _ODDS)
ODDS_SHARE = Threshold(1.91, "log odds", "for all of what the base model left, left", _ODDS)
ODDS_UNSEEN = Threshold(1.72, "log odds", "a unit of certifying error over what is allowed, beyond one half", _ODDS)
ODDS_ASKED = Threshold(0, "log odds", "a factor of ten in the chance that noise alone asks for a law", _ODDS)
ODDS_GAIN = Threshold(0, "log odds", "a unit of log(1 + nats of a law ahead of the names)", _ODDS)
ODDS_BESIDE = Threshold(0, "log odds", "where a law stands beside the names", _ODDS)
ODDS_NAMES = Threshold(1.66, "log odds", "of a set of names", _ODDS)
ODDS_DOUBT = Threshold(1.59, "log odds", "a unit of the noise level's standard deviation of logarithm", _ODDS)
MODULUS_CALIBRATED = Threshold(
    0.05, "of its logarithm", "to which a configured modulus is known, as calibrations repeat", _REASON
)
DOUBTED_NAMES = Threshold(
    0.5,
    "",
    "probability that no name of a shape exceeds where a law was ahead of it that unseen points do not show",
    _REASON,
)

_OWN = {name: value for name, value in list(globals().items()) if isinstance(value, Threshold)}
ALL: dict[str, Threshold] = {**RECORDED, **_OWN}


def thresholds_digest() -> str:
    """Return the SHA-256 of every threshold's name and value."""
    return sha256("\n".join(f"{name} = {float(value)!r}" for name, value in sorted(ALL.items())).encode()).hexdigest()
