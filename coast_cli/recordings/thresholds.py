"""What a threshold is, and those of what a recording can decide at all; ``diagnosis.thresholds`` has the rest and the digest."""

from __future__ import annotations

from typing import Self

REASON = "by reason, not tuned"


class Threshold(float):
    """A number that decides, with its unit, its meaning and how it was set."""

    unit: str
    meaning: str
    set_by: str

    def __new__(cls, value: float, unit: str, meaning: str, set_by: str) -> Self:
        """Return the number with what it means."""
        made = super().__new__(cls, value)
        made.unit, made.meaning, made.set_by = unit, meaning, set_by
        return made


FEWEST_RELEASED = Threshold(3, "samples", "of a run that a release reached: friction bends even the first few", REASON)
FEWEST_HELD = Threshold(5, "samples", "of a run in which the drive stays", REASON)
SAME_LENGTH = Threshold(
    0.05, "of the longest", "within which bending lengths are one: notch friction moves the modulus no further", REASON
)
RATES_DIFFER = Threshold(1.5, "", "fastest over slowest: less, and a lag of the camera looks like play", REASON)
RATE_TRAVEL = Threshold(0.2, "of a run's range", "for a branch to have a rate of its own", REASON)
RATE_SAMPLES = Threshold(5, "samples", "in a branch that has a rate", REASON)
STILL = Threshold(0.01, "of the widest range of a run", "below which a drive stays", REASON)
SAME_DRIVE = Threshold(0.05, "of the largest drive", "within which runs repeat one another", REASON)

RECORDED: dict[str, Threshold] = {
    name: value for name, value in list(globals().items()) if isinstance(value, Threshold)
}
