"""Tension as a witness: what a load cell that reads wrongly looks like, and how far a fit strains what data sheets say.

Stroke and curvature fix only the ratio of the tendon's modulus to the tubes', so a load cell in another scale moves both by one
factor and leaves nothing over. That two calibrations are off by the same factor is the unlikelier of the two accounts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.joint.build import FROM_DATA_SHEETS
from coast_cli.diagnosis.thresholds import AGREE_SIGMA, MODULUS_CALIBRATED, TENDON_MODULUS_PRIOR
from coast_cli.effects.library.load_cell_scale import LoadCellScale

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem

_BOTH = ("youngs_modulus_gpa", "tendon_youngs_modulus_gpa")
_SAME = 2.0  # standard deviations of what both are known to, within which two factors are one
_OFF = 1.5  # of them, from which on a modulus is off at all
_STRAINED = 0.5  # of the prior's standard deviation, from which on it is said


def _shifts(problem: JointProblem, fitted: Fit) -> dict[str, tuple[float, float]]:
    """Return by how much the logarithm of each modulus left its configured value, and its standard deviation."""
    return {
        p.name: (float(coordinate - p.inner), float(np.sqrt(fitted.covariance[place, place])))
        for place, (p, coordinate) in enumerate(zip(problem.base, fitted.coordinates, strict=True))
        if p.logarithmic
    }


def load_cell_in_another_scale(problem: JointProblem, base: Fit) -> Fit | None:
    """Return the fit with a load cell in another scale where that brings both moduli back to their configured values."""
    shifts = _shifts(problem, base)
    taken = problem.concealed | {effect.id for effect in problem.fixed_effects}
    if problem.tension_noise is None or not all(name in shifts for name in _BOTH) or LoadCellScale.id in taken:
        return None
    (tubes, tubes_std), (tendon, tendon_std) = (shifts[name] for name in _BOTH)
    unsure = float(np.sqrt(2.0 * MODULUS_CALIBRATED**2 + tubes_std**2 + tendon_std**2))
    is_one = tubes * tendon > 0.0 and abs(tubes - tendon) < _SAME * unsure
    if not is_one or min(abs(tubes), abs(tendon)) < _OFF * MODULUS_CALIBRATED:
        return None
    # The data only know the products: the moduli begin where they are configured, and the scale takes the factor.
    start = np.array([p.inner if p.name in _BOTH else c for p, c in zip(problem.base, base.coordinates, strict=True)])
    return fit(problem, (LoadCellScale(scale=float(np.exp(tendon))),), start)


def same_factor_words(problem: JointProblem, base: Fit) -> str:
    """Return what the configured moduli would have to be off by without a fault of the load cell."""
    tubes, tendon = (100.0 * np.expm1(_shifts(problem, base)[name][0]) for name in _BOTH)
    return f"without it the modulus of the tubes would be {tubes:+.0f} % and that of the tendon {tendon:+.0f} % off"


def off_data_sheet(problem: JointProblem, fitted: Fit) -> str:
    """Return which number of a data sheet a fit needs to be off by more than chance, and by how much; empty where none."""
    said = []
    for parameter, coordinate in zip(problem.base, fitted.coordinates, strict=True):
        pull = abs(coordinate - parameter.inner) / parameter.prior
        if parameter.name in FROM_DATA_SHEETS and pull > AGREE_SIGMA:
            value = f"{parameter.outer(coordinate):.3g} instead of {parameter.value:.3g}"
            said.append(f"{parameter.name} would be {value}, {pull:.1f} standard deviations from its data sheet")
    return "; ".join(said)


def strained(problem: JointProblem, fitted: Fit) -> list[str]:
    """Return a sentence where tension fits only with a tendon that its data sheet does not know."""
    found = _shifts(problem, fitted).get("tendon_youngs_modulus_gpa")
    if problem.tension_noise is None or found is None:
        return []
    shift, std = found
    if abs(shift) < _STRAINED * TENDON_MODULUS_PRIOR or abs(shift) < 3.0 * std:
        return []
    value = problem.values(fitted.coordinates)["tendon_youngs_modulus_gpa"]
    configured = next(p.value for p in problem.base if p.name == "tendon_youngs_modulus_gpa")
    from_sheet = f"{abs(shift) / std:.0f} sigma from the {configured:.1f} GPa configured"
    return [f"tension fits only with a tendon of {value:.1f} GPa, {from_sheet}: hang a known weight on the load cell"]
