"""One order-6 step across a constant segment of a planar inextensible beam.

In arc length the beam obeys theta' = k0 + m/B and m' = v cos(theta) + f sin(theta), where m is the internal moment
(m = -M of P), v the downward force that the rest of the beam hangs on a section (v' = -w) and f the constant force
along x. Across a segment B, k0 and w are constant, so the turn delta(sigma), with sigma running from 0 at the segment's
tip side to 1 at its clamp side, obeys

    delta'' = q [(a + a1 sigma) cos(delta) + (b + b1 sigma) sin(delta)],  delta(0) = 0,  delta'(0) = -h (k0 + m/B)

with q = h^2/B. The Taylor coefficients of delta, cos(delta) and sin(delta) follow from each other without a sine: the
direction is carried along as (cosine, sine) and turned by the polynomial sine and cosine of the small delta(1).

Everything here is plain arithmetic, so the same source serves Python floats, complex steps, numpy arrays over many
beams, and the compiled kernel. Constants are multiplied, not divided by: a division costs four products.
"""

from __future__ import annotations

from typing import Any

Number = Any  # float, complex or an array over beams: the arithmetic is the same
Forces = tuple[Number, Number, Number, Number]
Series = tuple[Number, Number, Number, Number, Number, Number, Number, Number, Number]


def segment_turn(
    length: Number,
    flexibility: Number,
    bend: Number,
    load: Number,
    thrust: Number,
    cosine: Number,
    sine: Number,
    moment: Number,
    shear: Number,
) -> tuple[Number, Number, Number, Number, Forces, Series]:
    """Cross one segment from its tip side to its clamp side.

    Args:
        length: h of the segment, m. flexibility: h/B, 1/(N m). bend: natural turn h k0, rad. load: weight h w, N.
        thrust: constant force f along x, N.
        cosine, sine: of the tangent angle at the tip side. moment: m there, N m. shear: v there, N.

    Returns:
        The turn delta(1) (rad); cosine, sine and moment at the clamp side; the forces (a, b, a1, b1) and the series
        that displacement and tangent follow from. The error is of order h^7 a step, h^6 along the beam.
    """
    a = shear * cosine + thrust * sine
    b = thrust * cosine - shear * sine
    a1 = load * cosine
    b1 = load * -sine
    q = length * flexibility
    # d, c, s: Taylor coefficients of delta, its cosine and sine; f: those of delta''/q.
    d1 = -bend - flexibility * moment
    d2 = q * a * 0.5
    c2 = d1 * d1 * -0.5
    f1 = a1 + b * d1
    d3 = q * f1 * (1.0 / 6.0)
    c3 = -d1 * d2
    s3 = d3 + d1 * c2 * (1.0 / 3.0)
    f2 = a * c2 + b * d2 + b1 * d1
    d4 = q * f2 * (1.0 / 12.0)
    c4 = c2 * c2 * (1.0 / 6.0) - d1 * d3 - d2 * d2 * 0.5
    s4 = d4 + c2 * d2
    f3 = a * c3 + a1 * c2 + b * s3 + b1 * d2
    d5 = q * f3 * (1.0 / 20.0)
    c5 = c2 * c3 * (1.0 / 3.0) - d1 * d4 - d2 * d3
    s5 = d5 + c2 * d3 + c3 * d2 * 0.5 + c2 * c2 * d1 * (1.0 / 30.0)
    f4 = a * c4 + a1 * c3 + b * s4 + b1 * s3
    f5 = a * c5 + a1 * c4 + b * s5 + b1 * s4
    turn = d1 + d2 + d3 + d4 + d5 + q * f4 * (1.0 / 30.0)
    pull = a + f1 * 0.5 + f2 * (1.0 / 3.0) + f3 * 0.25 + f4 * 0.2 + f5 * (1.0 / 6.0)
    square = turn * turn
    turned_cosine = 1.0 + square * (-0.5 + square * (1.0 / 24.0 - square * (1.0 / 720.0)))
    turned_sine = turn * (1.0 + square * (-1.0 / 6.0 + square * (1.0 / 120.0 - square * (1.0 / 5040.0))))
    return (
        turn,
        cosine * turned_cosine - sine * turned_sine,
        sine * turned_cosine + cosine * turned_sine,
        moment - length * pull,
        (a, b, a1, b1),
        (d1, d2, c2, c3, s3, c4, s4, c5, s5),
    )


def segment_turn_short(
    length: Number,
    flexibility: Number,
    bend: Number,
    load: Number,
    thrust: Number,
    cosine: Number,
    sine: Number,
    moment: Number,
    shear: Number,
) -> tuple[Number, Number, Number, Number, Forces, Series]:
    """Cross one segment as ``segment_turn`` does, to order 4 along the beam, at half the cost.

    Where segments turn by at most 0.01 rad the turn is right to 1e-12; of the series, what the tangent takes is given.
    """
    a = shear * cosine + thrust * sine
    b = thrust * cosine - shear * sine
    a1 = load * cosine
    b1 = load * -sine
    q = length * flexibility
    d1 = -bend - flexibility * moment
    d2 = q * a * 0.5
    c2 = d1 * d1 * -0.5
    f1 = a1 + b * d1
    d3 = q * f1 * (1.0 / 6.0)
    f2 = a * c2 + b * d2 + b1 * d1
    f3 = a1 * c2 - a * d1 * d2 + b * (d3 + d1 * c2 * (1.0 / 3.0)) + b1 * d2
    turn = d1 + d2 + d3 + q * f2 * (1.0 / 12.0)
    square = turn * turn
    turned_cosine = 1.0 + square * (-0.5 + square * (1.0 / 24.0))
    turned_sine = turn * (1.0 + square * (-1.0 / 6.0 + square * (1.0 / 120.0)))
    return (
        turn,
        cosine * turned_cosine - sine * turned_sine,
        sine * turned_cosine + cosine * turned_sine,
        moment - length * (a + f1 * 0.5 + f2 * (1.0 / 3.0) + f3 * 0.25),
        (a, b, a1, b1),
        (d1, d2, c2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    )


def segment_displacement(length: Number, cosine: Number, sine: Number, series: Series) -> tuple[Number, Number]:
    """Return the vector from a segment's clamp side to its tip side (along x, along y), m, to the order of the step.

    Args:
        length: m. cosine, sine: of the tangent at the tip side. series: from ``segment_turn``.
    """
    d1, d2, c2, c3, s3, c4, s4, c5, s5 = series
    straight = length * (1.0 + c2 * (1.0 / 3.0) + c3 * 0.25 + c4 * 0.2 + c5 * (1.0 / 6.0))
    sideways = length * (d1 * 0.5 + d2 * (1.0 / 3.0) + s3 * 0.25 + s4 * 0.2 + s5 * (1.0 / 6.0))
    return cosine * straight - sine * sideways, sine * straight + cosine * sideways


def segment_tangent(
    length: Number, flexibility: Number, forces: Forces, series: Series, slope: Number, moment_slope: Number
) -> tuple[Number, Number]:
    """Carry the derivatives of angle and moment by the tip's angle across one segment, to order 3 along the beam.

    Args:
        length, flexibility: as in ``segment_turn``. forces, series: from it.
        slope, moment_slope: derivatives of angle (1) and moment (N m) at the tip side.

    Returns:
        The two derivatives at the clamp side.
    """
    a, b, a1, b1 = forces
    d1, d2, c2 = series[0], series[1], series[2]
    q = length * flexibility
    # The derivative x of delta obeys x'' = q k x, k the derivative of delta''/q by the angle.
    lever = flexibility * moment_slope
    k1 = b1 - a * d1
    pull0 = b * slope
    pull1 = k1 * slope - b * lever
    pull2 = (b * c2 - a1 * d1 - a * d2) * slope - k1 * lever + b * q * pull0 * 0.5
    return (
        slope - lever + q * (pull0 * 0.5 + pull1 * (1.0 / 6.0) + pull2 * (1.0 / 12.0)),
        moment_slope - length * (pull0 + pull1 * 0.5 + pull2 * (1.0 / 3.0)),
    )
