"""Forecasts of jumps against chains of links whose energy is minimised: neither closed form enters them.

The tendon is a string through points in the bore of a chain in the plane, of exact length; the pair in space is two
chains that share their bend and twist by themselves. Loads grow in steps from the state before, so that a jump shows.
"""

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize

from coast_cli.mechanics.snap import RollingPair, TendonInBore, crossing, roll_index, rolled

RIGIDITY = 4e-6


class Strung:
    """A planar chain of arcs and a string that may go anywhere in its bore, fixed to one wall at both ends."""

    def __init__(self, segment, links=80):
        self.segment, self.links, self.step = segment, links, float(segment.length) / links
        self.state = np.concatenate([np.full(links, float(segment.rest)), np.zeros(links - 1)])

    def string(self, state):
        """Length of the string and its gradient."""
        count, step, play = self.links, self.step, float(self.segment.play)
        bend, arm = state[:count], float(self.segment.axis) + np.concatenate([[play], state[count:], [play]])
        angle = np.concatenate([[0.0], np.cumsum(bend) * step])
        half, chord = bend * step / 2.0, angle[:-1] + bend * step / 2.0
        size = np.sinc(half / np.pi) * step
        along = np.stack((size * np.cos(chord), size * np.sin(chord)))
        offset = np.stack((-arm * np.sin(angle), arm * np.cos(angle)))
        leg = along + np.diff(offset, axis=1)
        length = np.hypot(*leg)
        unit = leg / length
        at_point = np.zeros((2, count + 1))
        at_point[:, 1:] += unit
        at_point[:, :-1] -= unit
        by_arm = -at_point[0] * np.sin(angle) + at_point[1] * np.cos(angle)
        by_angle = -arm * (at_point[0] * np.cos(angle) + at_point[1] * np.sin(angle))
        turn = unit[1] * along[0] - unit[0] * along[1]
        by_angle[:-1] += turn
        slope = np.where(np.abs(half) < 1e-4, -half / 3.0, (half * np.cos(half) - np.sin(half)) / half**2)
        own = turn * step / 2.0 + (unit[0] * np.cos(chord) + unit[1] * np.sin(chord)) * slope * step**2 / 2.0
        by_bend = own + step * np.cumsum(by_angle[::-1])[::-1][1:]
        return length.sum(), np.concatenate([by_bend, by_arm[1:-1]])

    def relaxed(self, *, tension=None, stretch=None):
        """Let the chain settle under a tension (N), or with the tendon's end drawn by a stretch (m); its mean bend."""
        count, scale = self.links, np.concatenate([np.ones(self.links), np.full(self.links - 1, 1e-4)])
        bound, stiffness = float(self.segment.play) / 1e-4, float(self.segment.stiffness)

        def energy(scaled):
            state = scaled * scale
            length, gradient = self.string(state)
            off = state[:count] - float(self.segment.rest)
            value = 0.5 * RIGIDITY * self.step * np.sum(off**2)
            if tension is None:
                pulled = max(stretch - (float(self.segment.length) - length), 0.0)
                value, force = value + 0.5 * stiffness * pulled**2, stiffness * pulled
            else:
                value, force = value + tension * length, tension
            gradient = force * gradient
            gradient[:count] += RIGIDITY * self.step * off
            return 1e6 * value, 1e6 * gradient * scale

        limits = [(None, None)] * count + [(-bound, bound)] * (count - 1)
        options = {"maxiter": 20000, "maxfun": 40000, "ftol": 1e-15, "gtol": 1e-9, "maxcor": 40}
        found = minimize(energy, self.state / scale, jac=True, method="L-BFGS-B", bounds=limits, options=options)
        self.state = found.x * scale
        return self.state[:count].mean()


def segment(rest, length, axis, stiffness):
    return TendonInBore(*(np.array(value) for value in (rest, RIGIDITY, length, axis, 0.102e-3, stiffness)))


CASES = [segment(-2.84, 0.04, 0.14e-3, 200.0), segment(-1.84, 0.04, 0.12e-3, 300.0)]
TRAVELLING = segment(-5.0, 0.06, 0.10e-3, 150.0)


@pytest.mark.parametrize("case", [*CASES, TRAVELLING])
def test_the_tension_at_which_the_tendon_crosses(case):
    jump, chain = crossing(case), Strung(case)
    for share in (0.4, 0.7, 0.9, 0.97):
        chain.relaxed(tension=share * float(jump.tension))
    before = chain.relaxed(tension=0.99 * float(jump.tension))
    after = chain.relaxed(tension=1.01 * float(jump.tension))
    straight = float(case.rest + jump.tension * (case.axis + case.play) / RIGIDITY)
    print(f"\nat 0.99 and 1.01 of the forecast tension {float(jump.tension):.4f} N: {before:.3f} and {after:.3f} 1/m")
    assert before < 0.0
    assert after == pytest.approx(1.01 * (straight - float(case.rest)) + float(case.rest), rel=0.01)


@pytest.mark.parametrize("case", [*CASES, TRAVELLING])
def test_the_stroke_at_which_it_jumps_and_how_far(case):
    jump, chain = crossing(case), Strung(case)
    chain.relaxed(tension=1e-4)
    slack = float(case.length) - chain.string(chain.state)[0]

    def drawn(share):
        return chain.relaxed(stretch=slack + share * float(jump.stroke))

    for share in np.linspace(0.3, 0.985, 12):
        drawn(share)
    before, after = drawn(0.99), drawn(1.01)
    print(
        f"\nat 0.99 and 1.01 of the forecast stroke: {before:.3f} and {after:.3f} 1/m; forecast to {float(jump.after):.3f}"
    )
    slope = (float(jump.after) - float(case.rest)) / float(jump.stroke)
    assert before < float(jump.before) + 0.05 * (jump.after - jump.before)
    assert after - 0.01 * slope * float(jump.stroke) == pytest.approx(float(jump.after), rel=0.01)


def test_a_segment_shorter_than_the_shortest_goes_through_straight_without_a_jump():
    short = segment(-2.84, 0.9 * np.pi / np.sqrt(2.84 / 0.242e-3), 0.14e-3, 200.0)
    assert float(crossing(short).index) == pytest.approx(0.9)
    assert np.isnan(crossing(short).stroke)
    chain, start = Strung(short), RIGIDITY * 2.84 / 0.242e-3
    bends = [chain.relaxed(tension=share * start) for share in np.linspace(0.5, 1.1, 41)]
    assert bends[0] < -0.5 < 0.1 < bends[-1]
    assert np.max(np.diff(bends)) < 5.0 * np.mean(np.diff(bends))


def test_clearance_between_the_tubes_adds_no_jump():
    """Two beams one in the other: the energy is convex, so that the bend follows the moment step by step."""
    outer, middle, clearance, length, links = (2e-6, 5.5), (1e-6, -2.0), 0.02e-3, 0.04, 40
    step = length / links
    bend = np.zeros((links + 1, links))  # of the clearance taken up at the nodes, clamped: d'' at each link
    for place in range(links):
        for node, part in ((abs(place - 1), 1.0), (place, -2.0), (place + 1, 1.0)):
            bend[node, place] += part / step**2

    def settled(moment):
        """Mean bend of the outer chain: a linear least squares of bends and clearance taken up, which is bounded."""
        stiff = np.sqrt(step * np.array([outer[0], middle[0]]))
        taken = bend.T[:, 1:] * clearance
        rows = np.block(
            [[stiff[0] * np.eye(links), np.zeros((links, links))], [stiff[1] * np.eye(links), stiff[1] * taken]]
        )
        wish = np.concatenate([np.full(links, outer[1]), np.full(links, middle[1] + moment / middle[0])])
        limits = np.concatenate([np.full(links, np.inf), np.ones(links)])
        found = lsq_linear(rows, np.repeat(stiff, links) * wish, (-limits, limits), method="bvls", tol=1e-14)
        assert found.success
        return found.x[:links].mean()

    bends = np.array([settled(moment) for moment in -np.linspace(0.0, 2.4e-5, 13)])
    assert bends[0] > 0.0 > bends[-1]  # it has crossed straight
    steps = -np.diff(bends)
    assert np.all(steps > 0.0)
    assert np.max(steps) < 2e-6 / middle[0]  # what the middle tube alone would bend by


def twisted(pair, curvature, links=100):
    """Roll of the tips of two chains that twist by themselves and share their bend in space, from a small roll on."""
    step, moment = pair.length / links, sum(pair.rigidity) * (curvature - pair.rest)
    scale = np.concatenate([np.ones(2 * links), np.full(2 * links, 10.0)])

    def energy(scaled):
        state, value = (scaled * scale).reshape(4, links), 0.0
        gradient = np.zeros((4, links))
        for tube, pull in ((0, 0.0), (1, moment)):
            sine, cosine = np.sin(state[tube]), np.cos(state[tube])
            plain, side = cosine * state[2] + sine * state[3], cosine * state[3] - sine * state[2]
            off = plain - pair.natural[tube]
            value += step * np.sum(
                0.5 * pair.rigidity[tube] * off**2 + 0.5 * pair.across[tube] * side**2 - pull * plain
            )
            by_plain, by_side = step * (pair.rigidity[tube] * off - pull), step * pair.across[tube] * side
            gradient[tube] += by_plain * side - by_side * plain
            gradient[2] += by_plain * cosine - by_side * sine
            gradient[3] += by_plain * sine + by_side * cosine
            apart = np.concatenate([[step / 2.0], np.full(links - 1, step)])
            turn = np.diff(state[tube], prepend=0.0)
            value += 0.5 * pair.torsion[tube] * np.sum(turn**2 / apart)
            torque = pair.torsion[tube] * turn / apart
            gradient[tube] += torque
            gradient[tube, :-1] -= torque[1:]
        return 1e6 * value, 1e6 * gradient.ravel() * scale

    start = np.concatenate([np.full(links, 1e-3), np.full(links, -1e-3), np.full(links, curvature), np.zeros(links)])
    options = {"maxiter": 50000, "maxfun": 100000, "ftol": 1e-16, "gtol": 1e-8, "maxcor": 50}
    found = minimize(energy, start / scale, jac=True, method="L-BFGS-B", options=options).x
    return found[links - 1] - found[2 * links - 1]


ALIKE = RollingPair((-5.5, 2.0), (1.2e-6, 6e-7), (1.2e-6, 6e-7), (4e-8, 3e-8), 0.06)
NOTCHED = RollingPair((-5.5, 8.0), (1.2e-6, 6e-7), (4e-6, 2e-6), (2e-8, 1.5e-8), 0.06)


@pytest.mark.parametrize("pair", [ALIKE, NOTCHED])
def test_the_bend_at_which_a_pair_rolls_and_how_far(pair):
    bends = np.linspace(pair.rest, pair.rest + 6.0, 1201)
    index = roll_index(pair, bends)
    first = bends[np.argmax(index > 1.0)]
    span = sum(pair.rigidity) * (first - pair.rest)
    for share, rolls in ((0.99, False), (1.01, True)):
        assert (abs(twisted(pair, pair.rest + share * span / sum(pair.rigidity))) > 0.05) == rolls
    top = bends[np.argmax(index)]
    print(
        f"\nrolls from {first:.3f} 1/m on; at {top:.2f} 1/m by {rolled(pair, top):.4f} rad, chain {twisted(pair, top):.4f}"
    )
    assert rolled(pair, top) == pytest.approx(twisted(pair, top), rel=0.01)


def test_without_notches_and_tendon_it_is_the_condition_of_concentric_tubes():
    """L sqrt(c) < pi/2 with c = EI_1 EI_2 k_1 k_2 (1/GJ_1 + 1/GJ_2)/(EI_1 + EI_2): Dupont et al. 2010, sec. V."""
    (one, two), (first, second) = ALIKE.rigidity, ALIKE.torsion
    c = one * two * 5.5 * 2.0 * (1.0 / first + 1.0 / second) / (one + two)
    assert float(roll_index(ALIKE, np.asarray(ALIKE.rest))) == pytest.approx(0.06 * np.sqrt(c) / (np.pi / 2.0))
