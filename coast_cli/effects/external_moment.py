"""Moments of loads on a bending segment taken as a circular arc from the clamp: at a place, or their mean along it.

A joint of one station feels the mean moment; where notches are told apart, each feels that of its own place.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from coast_cli.effects.effect import Segment
from coast_cli.mechanics.section import FloatArray

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_STRAIGHT = 1e-4


def tip_force_arm(curvature: FloatArray, segment: Segment) -> FloatArray:
    """Return the lever arm x_tip - x(s) (m) of a transverse tip force, x(s) = sin(kappa s)/kappa, shape of curvature."""

    def arm(place: FloatArray, kappa: FloatArray) -> FloatArray:
        return np.asarray((np.sin(kappa * segment.bending_length) - np.sin(kappa * place)) / kappa)

    return _at_places(arm, curvature, segment)


def weight_arm(curvature: FloatArray, segment: Segment) -> FloatArray:
    """Return the moment (m^2) of a unit transverse line load: the integral of x(t) - x(s) over t > s.

    Closed for an arc: (cos(kappa s) - cos(kappa L))/kappa^2 - (L - s) sin(kappa s)/kappa.
    """
    length = segment.bending_length

    def arm(place: FloatArray, kappa: FloatArray) -> FloatArray:
        bent = (np.cos(kappa * place) - np.cos(kappa * length)) / kappa**2
        return np.asarray(bent - (length - place) * np.sin(kappa * place) / kappa)

    return _at_places(arm, curvature, segment)


def _at_places(
    arm: Callable[[FloatArray, FloatArray], FloatArray], curvature: FloatArray, segment: Segment
) -> FloatArray:
    length = segment.bending_length
    kappa = np.where(np.abs(curvature * length) < _STRAIGHT, _STRAIGHT / length, curvature)
    if segment.position is not None:
        return np.asarray(arm(segment.position, kappa))
    places = 0.5 * length * (_NODES + 1.0)
    return np.asarray(arm(places, kappa[..., np.newaxis]) @ (0.5 * _WEIGHTS))
