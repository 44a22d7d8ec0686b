"""How far names are to be believed: a logistic regression on what speaks against them, set on tuning seeds of the rig.

Each figure is zero where nothing speaks against the names, and grows with what does; no weight is negative. Where noise alone
is left, the odds are those of the constant; the costs of a wrong name decide from which odds on a name is given.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from coast_cli.diagnosis.thresholds import (
    ODDS_ASKED,
    ODDS_BESIDE,
    ODDS_CONSTANT,
    ODDS_DOUBT,
    ODDS_GAIN,
    ODDS_LEFT,
    ODDS_NAMES,
    ODDS_SHARE,
    ODDS_UNSEEN,
)


@dataclass(frozen=True, slots=True)
class Against:
    """What speaks against the leading names.

    Attributes:
        left: noise widths that they leave on rows that choose, as log(1 + left). share: of what the base model left.
        unseen: error on rows that certify over what is allowed there, beyond one half. Where not even laws without a name
            reach the noise, both are counted by what those leave.
        asked: by how much louder than noise alone the rows ask for a law, -log10 of the chance.
        gain: nats by which a law alone is ahead of them, as log(1 + gain). beside: 1 where a law stands beside them.
        names: 1 where they are more than one. doubt: of the noise level, standard deviation of its logarithm, at most 0.7.
    """

    left: float
    share: float
    unseen: float
    asked: float
    gain: float
    beside: float
    names: float
    doubt: float

    def table(self) -> dict[str, float]:
        """Return the figures by name."""
        return {name: round(float(value), 6) for name, value in asdict(self).items()}

    @property
    def certainty(self) -> float:
        """Probability that the names, or one of their rivals, are right."""
        odds = (
            ODDS_CONSTANT
            - ODDS_LEFT * self.left
            - ODDS_SHARE * self.share
            - ODDS_UNSEEN * self.unseen
            - ODDS_ASKED * self.asked
            - ODDS_GAIN * self.gain
            - ODDS_BESIDE * self.beside
            - ODDS_NAMES * self.names
            - ODDS_DOUBT * self.doubt
        )
        return float(1.0 / (1.0 + np.exp(-odds)))
