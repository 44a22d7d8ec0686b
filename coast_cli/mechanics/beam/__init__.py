"""Planar beams under gravity and tip loads: tubes that bend by their own weight, solved in arc length."""

from coast_cli.mechanics.beam.equilibrium import (
    NO_EQUILIBRIUM,
    BeamCurvatures,
    BeamSolution,
    BeamSolutions,
    BeamTips,
    solve_alike_curvatures,
    solve_beam,
    solve_beams,
    solve_curvatures,
    solve_segments,
    solve_tips,
)

__all__ = [
    "NO_EQUILIBRIUM",
    "BeamCurvatures",
    "BeamSolution",
    "BeamSolutions",
    "BeamTips",
    "solve_alike_curvatures",
    "solve_beam",
    "solve_beams",
    "solve_curvatures",
    "solve_segments",
    "solve_tips",
]
