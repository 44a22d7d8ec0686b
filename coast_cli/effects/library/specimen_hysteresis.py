"""The superelastic loop of a whole specimen: its force follows an upper plateau, and on release a lower one.

The same law as that of the tubes, with forces for stresses, as nothing is known of a specimen's section: a part of the
stretch transforms at the upper plateau and comes back at the lower one, and waits between them. Places that yield earlier
and later round the corners of both.
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.memory import follow
from coast_cli.effects.stages import OnDevice
from coast_cli.mechanics.section import FloatArray

_PLACES = 6
_QUANTILES = np.array([NormalDist().inv_cdf((place + 0.5) / _PLACES) for place in range(_PLACES)])
_NARROWEST = 0.98  # lower plateau over upper


@dataclass(frozen=True)
class SpecimenHysteresis(OnDevice):
    """Plateaus of a specimen, N, and the share of its stiffness that is lost along them."""

    upper_plateau_n: float = 30.0
    lower_plateau_n: float = 12.0
    stiffness_lost: float = 0.0
    spread: float = 0.0

    id = "tube_hysteresis"
    title = "superelastic loop of the specimen"
    component = "specimen"
    stage = "structure"
    equation = (
        "F = ratio (x - zero) - q, q grows where F would pass upper_plateau and comes back below lower_plateau, "
        "dF/dx = (1 - stiffness_lost) ratio on both; spread: of ln of the plateaus from place to place"
    )
    source = "flag-shaped law: Auricchio and Taylor, Comput. Methods Appl. Mech. Eng. 143 (1997) 175"
    parameters = (
        Parameter("upper_plateau_n", 30.0, 1e-6, 1e6, (0.4, 0.65), "where the curve bends", "response", role="shape"),
        Parameter("lower_plateau_n", 12.0, 1e-6, 1e6, (0.25,), "0.2 to 0.6 of the upper", "response", role="shape"),
        Parameter("stiffness_lost", 0.0, 0.0, 0.995, (0.8, 0.5), "plateau slope 3 to 20 % of the first slope"),
        Parameter("spread", 0.0, 0.0, 1.0, (0.1,), "0.05 to 0.4 where sections differ", role="shape"),
    )
    needs = ("release", "force")
    grammar_cells = (
        ("sensor", "friction"),
        ("sensor", "none"),
        ("drive", "friction"),
        ("drive", "none"),
        ("sensor", "maximum"),
        ("drive", "maximum"),
    )
    decided_by = "release from below the knee and from two places on the plateau: only the larger ones open a loop"

    def carry(self, response: FloatArray, history: History) -> FloatArray:
        """Take off what has transformed."""
        if response.size == 0 or self.stiffness_lost == 0.0:
            return response
        side = 1.0 if float(np.max(response)) >= -float(np.min(response)) else -1.0
        elastic = side * response
        lower = min(self.lower_plateau_n, _NARROWEST * self.upper_plateau_n)
        begun = 0.0 if history.first_response is None else max(float(elastic[0]) - side * history.first_response, 0.0)
        factors = np.exp(self.spread * _QUANTILES) if self.spread > 0.0 else np.ones(1)
        parts = []
        for factor in factors.tolist():
            low = np.maximum(self.stiffness_lost * (elastic - factor * self.upper_plateau_n), 0.0)
            high = np.maximum(self.stiffness_lost * (elastic - factor * lower), low)
            parts.append(follow(low, high, begun))
        return np.asarray(side * (elastic - np.mean(parts, axis=0)))
