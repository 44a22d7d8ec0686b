"""One order-6 step across a constant segment of a planar inextensible beam, and the march from tip to clamp.

In arc length the beam obeys theta' = k0 + m/B and m' = v cos(theta) + f sin(theta), where m is the internal moment
(m = -M of P), v the downward force that the rest of the beam hangs on a section (v' = -w) and f the constant force along
x. Across a segment B, k0 and w are constant, so the turn delta(sigma), with sigma running from 0 at the segment's tip
side to 1 at its clamp side, obeys

    delta'' = q [(a + a1 sigma) cos(delta) + (b + b1 sigma) sin(delta)],  delta(0) = 0,  delta'(0) = -h (k0 + m/B)

with q = h^2/B. Its Taylor coefficients follow by recurrence, without a sine: the direction is carried along as
(cosine, sine) and turned by the polynomial sine and cosine of the small delta(1).

Everything here is plain arithmetic, so the same source serves Python floats, complex steps, numpy arrays over many
beams, and the compiled kernel.
"""

from __future__ import annotations

from typing import Any

Number = Any  # float, complex or an array over beams: the arithmetic is the same


def segment_step(
    length: Number,
    flexibility: Number,
    bend: Number,
    load: Number,
    thrust: Number,
    cosine: Number,
    sine: Number,
    moment: Number,
    shear: Number,
) -> tuple[Number, Number, Number, Number, Number, Number, Number, Number]:
    """Cross one segment from its tip side to its clamp side.

    Args:
        length: h of the segment, m. flexibility: h/B, 1/(N m). bend: natural turn h k0, rad. load: weight h w, N.
        thrust: constant force f along x, N.
        cosine, sine: of the tangent angle at the tip side. moment: m there, N m. shear: v there, N.

    Returns:
        The turn delta(1) (rad), cosine, sine and moment at the clamp side, the displacement (along x, along y, m) from
        the tip side to the clamp side taken as positive towards the tip, and the two slopes of q^-1 delta'' in the
        angle that the tangent needs. The error is of order h^7 a step, h^6 along the beam.
    """
    across = shear * cosine + thrust * sine
    along = thrust * cosine - shear * sine
    across_slope = load * cosine
    along_slope = -load * sine
    q = length * flexibility
    d1 = -(bend + flexibility * moment)
    d1_squared = d1 * d1
    # c_k and s_k: k-th derivatives of cos(delta) and sin(delta) at 0; g_k: those of delta over q.
    c2 = -d1_squared
    d2 = q * across
    g3 = across_slope + along * d1
    d3 = q * g3
    c3 = -3.0 * d1 * d2
    s3 = d3 - d1 * d1_squared
    g4 = across * c2 + along * d2 + 2.0 * along_slope * d1
    d4 = q * g4
    c4 = d1_squared * d1_squared - 4.0 * d1 * d3 - 3.0 * d2 * d2
    s4 = d4 - 6.0 * d1_squared * d2
    g5 = across * c3 + along * s3 + 3.0 * (across_slope * c2 + along_slope * d2)
    d5 = q * g5
    c5 = 5.0 * (2.0 * d1 * d1_squared * d2 - d1 * d4 - 2.0 * d2 * d3)
    s5 = d5 - 10.0 * d1_squared * d3 - 15.0 * d1 * d2 * d2 + d1 * d1_squared * d1_squared
    g6 = across * c4 + along * s4 + 4.0 * (across_slope * c3 + along_slope * s3)
    g7 = across * c5 + along * s5 + 5.0 * (across_slope * c4 + along_slope * s4)
    turn = d1 + q * (across / 2.0 + g3 / 6.0 + g4 / 24.0 + g5 / 120.0 + g6 / 720.0)
    moment = moment - length * (across + g3 / 2.0 + g4 / 6.0 + g5 / 24.0 + g6 / 120.0 + g7 / 720.0)
    straight = length * (1.0 + c2 / 6.0 + c3 / 24.0 + c4 / 120.0 + c5 / 720.0)
    sideways = length * (d1 / 2.0 + d2 / 6.0 + s3 / 24.0 + s4 / 120.0 + s5 / 720.0)
    along_x = cosine * straight - sine * sideways
    along_y = sine * straight + cosine * sideways
    squared = turn * turn
    turn_cosine = 1.0 - squared / 2.0 * (1.0 - squared / 12.0 * (1.0 - squared / 30.0 * (1.0 - squared / 56.0)))
    turn_sine = turn * (1.0 - squared / 6.0 * (1.0 - squared / 20.0 * (1.0 - squared / 42.0)))
    return (
        turn,
        cosine * turn_cosine - sine * turn_sine,
        sine * turn_cosine + cosine * turn_sine,
        moment,
        along_x,
        along_y,
        along,
        along_slope - across * d1,
    )


def tangent_step(
    length: Number,
    flexibility: Number,
    stiffness: Number,
    stiffness_slope: Number,
    slope: Number,
    moment_slope: Number,
) -> tuple[Number, Number]:
    """Carry the derivatives of angle and moment by the tip's angle across one segment, to order 3.

    Args:
        length, flexibility: as in ``segment_step``. stiffness, stiffness_slope: its last two results.
        slope, moment_slope: derivatives of angle (1) and moment (N m) at the tip side.

    Returns:
        The two derivatives at the clamp side.
    """
    lever = flexibility * moment_slope
    spin = stiffness_slope * slope - stiffness * lever
    return (
        slope - lever + length * flexibility * (stiffness * slope / 2.0 + spin / 6.0),
        moment_slope - length * (stiffness * slope + spin / 2.0),
    )
