"""Tendon permanent set: slack that the largest tension so far has left behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnSlack
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE


@dataclass(frozen=True)
class TendonPermanentSet(OnSlack):
    """Slack in proportion to the largest tension seen past a threshold."""

    slack_mm_per_n: float = 0.0
    threshold_n: float = 0.0
    carried: float = 1.0

    id = "tendon_permanent_set"
    title = "tendon keeps a set"
    component = "tendon"
    equation = "slack = slack_mm_per_n max(max F so far - threshold, 0)"
    source = "residual strain of cycled nitinol wire: Miyazaki et al., Metall. Trans. A 17 (1986) 115"
    parameters = (
        Parameter("slack_mm_per_n", 0.0, 0.0, 3.0, (0.1,), "up to a per cent of a 0.4 m wire"),
        Parameter(
            "threshold_n", 0.0, 0.0, 20.0, (0.0, 0.4, 0.7), "below the plateau nothing is left", "tension", role="shape"
        ),
        Parameter(
            "carried",
            1.0,
            0.0,
            1.0,
            (1.0, 0.0),
            "share that is still there in later runs; 0 where re-zeroed",
            role="shape",
        ),
    )
    needs = ("stroke",)
    decided_by = "two cycles to the same stroke and one larger, each returning to zero, with tension recorded"

    def slack(self, tension: FloatArray, history: History, joint: Joint) -> FloatArray:
        """Return the slack left by the largest tension so far."""
        if self.slack_mm_per_n == 0.0 or tension.size == 0:
            return 0.0 * tension
        largest = np.maximum(np.maximum.accumulate(tension), self.carried * history.earlier_tension)
        return self.slack_mm_per_n * MILLIMETRE * np.maximum(largest - self.threshold_n, 0.0)
