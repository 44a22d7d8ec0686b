"""The tubes of the comparison: the three reference tubes, as pieces on their natural arc, for any beam code."""

from dataclasses import dataclass

import numpy as np

from coast_cli.mechanics.tube import NotchedTube

GRAVITY = 9.81
NATURAL_CURVATURES = (5.0, -5.0, -15.0)


@dataclass(frozen=True)
class FrameModel:
    """Nodes on the natural arc (m), one more than elements; rigidity (N m^2) and weight (N/m) of each element."""

    x: np.ndarray
    y: np.ndarray
    rigidity: np.ndarray
    weight: np.ndarray


def reference_tube(natural_curvature: float) -> NotchedTube:
    """Return a reference tube: ro 0.2, ri 0.165, depth 0.35 mm, 188 x (0.3 uncut + 0.3 cut), 45 GPa."""
    one = np.ones(188)
    return NotchedTube(
        "reference", 0.2e-3, 0.165e-3, 0.35e-3 * one, 0.3e-3 * one, 0.3e-3 * one, 45e9, 6450.0, natural_curvature
    )


def frame_model(natural_curvature: float, elements_per_piece: int) -> FrameModel:
    """Cut every constant piece into straight elements whose nodes lie on the natural arc."""
    pieces = reference_tube(natural_curvature).segments
    s = np.append(0.0, np.cumsum(np.repeat(pieces.length / elements_per_piece, elements_per_piece)))
    turn = natural_curvature * s
    return FrameModel(
        x=s * np.sinc(turn / np.pi),
        y=s * np.sinc(turn / (2.0 * np.pi)) * np.sin(turn / 2.0),
        rigidity=np.repeat(pieces.rigidity, elements_per_piece),
        weight=np.repeat(pieces.weight, elements_per_piece) * GRAVITY,
    )
