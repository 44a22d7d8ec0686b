"""Coupled pairs against two chains of rigid links with springs at the joints, hinged to each other at every joint.

A finite-element model of its own: each tube keeps its own springs, natural bends and weights, nothing is summed or
combined beforehand, and the shape of least energy is found by Newton's method on all joints. It converges with the square
of the link to the composite beam.
"""

import numpy as np
import pytest

from coast_cli.mechanics.pairs import pair_table
from coast_cli.mechanics.tube import NotchedTube

GRAVITY = 9.81


def tube(radii, depth, count, natural_curvature):
    one = np.ones(count)
    return NotchedTube("tube", *radii, depth * one, 1.5e-3 * one, 1.0e-3 * one, 45e9, 6450.0, natural_curvature)


OUTER = tube((0.25e-3, 0.2e-3), 0.4e-3, 40, 6.0)
MIDDLE = tube((0.18e-3, 0.14e-3), 0.26e-3, 28, -9.0)


def chain_angle(outer: NotchedTube, middle: NotchedTube, joints_per_piece: int) -> float:
    """Angle of the shape of least energy at the end of the shorter tube; a joint lies in the middle of each element."""
    longer = max(outer, middle, key=lambda tube: tube.length).segments
    length = np.repeat(longer.length / joints_per_piece, joints_per_piece)
    weight, springs = np.zeros(length.size), []
    for one in (outer, middle):
        pieces = one.segments
        bending, mass = (np.repeat(column, joints_per_piece) for column in (pieces.rigidity, pieces.weight))
        own = length[: mass.size]
        weight[: mass.size] += GRAVITY * mass * own
        springs.append((bending / own, one.natural_curvature * own))
    between = 0.5 * (length[1:] + length[:-1])
    leverage = between * np.cumsum(weight[:0:-1])[::-1]

    def energy(turns):
        angle = np.cumsum(turns)[:-1]
        total = np.sum(leverage * np.sin(angle))
        slope = np.append(np.cumsum((leverage * np.cos(angle))[::-1])[::-1], 0.0)
        for stiffness, natural in springs:
            off = turns[: stiffness.size] - natural
            total += np.sum(stiffness * off**2) / 2.0
            slope[: stiffness.size] += stiffness * off
        return total, slope

    def curvature(turns):
        pull = -leverage * np.sin(np.cumsum(turns)[:-1])
        tail = np.append(np.cumsum(pull[::-1])[::-1], 0.0)
        index = np.arange(turns.size)
        matrix = tail[np.maximum.outer(index, index)]
        for stiffness, _ in springs:
            matrix[index[: stiffness.size], index[: stiffness.size]] += stiffness
        return matrix

    turns = np.zeros(length.size)
    for _ in range(50):
        change = np.linalg.solve(curvature(turns), energy(turns)[1])
        turns = turns - change
        if np.max(np.abs(change)) < 1e-13:
            break
    # The shape must be a minimum, not just at rest.
    assert np.linalg.eigvalsh(curvature(turns))[0] > 0.0
    shorter = min(outer.segments.length.size, middle.segments.length.size) * joints_per_piece
    return float(np.sum(turns[:shorter]))


@pytest.mark.parametrize(("outer", "middle"), [(OUTER, MIDDLE), (MIDDLE, OUTER)], ids=["outer longer", "middle longer"])
def test_the_composite_beam_is_what_two_hinged_chains_become(outer, middle):
    table = pair_table([outer], [middle], GRAVITY, "coupled")
    assert table.converged.all()
    errors = np.array([chain_angle(outer, middle, joints) for joints in (1, 2, 4)]) - table.signed_precurvature[0, 0]
    assert np.all(np.abs(np.log2(errors[:-1] / errors[1:]) - 2.0) < 0.1)
    assert abs(errors[-1]) < 1e-4
    assert abs(errors[-1] + (errors[-1] - errors[-2]) / 3.0) < 1e-6
