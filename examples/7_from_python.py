"""The same answers from Python: rank, strokes, a shape, a diagnosis. Run it from the top of the checkout."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import coast_cli as coast

HERE = Path(__file__).parent


def main() -> None:
    """Print each answer."""
    config = coast.load_config(HERE.parent / "configs" / "tubes.toml")
    design = coast.build(config)

    ranking = coast.rank(config, coast.RankOptions(rigidity="series"))
    print(f"first pair: {ranking.columns['outer'][0]}/{ranking.columns['middle'][0]}")

    # Arrays in, arrays out, in SI units: 1/m, m and N.
    joint = design.joint()
    solution = coast.stroke(joint, np.array([10.0, 20.0, 40.0]), 30e-3)
    for curvature, stroke, tension in zip(solution.curvature, solution.stroke, solution.tension, strict=True):
        print(f"{curvature:4.0f} 1/m takes {stroke * 1e3:.3f} mm and {tension:.3f} N")
    back = coast.curvature_from_stroke(joint, solution.stroke, 30e-3).curvature
    print(f"there and back: {np.allclose(back, solution.curvature, rtol=1e-12)}")

    shape = coast.solve_beam(design.tube("MT3"), design.gravity)
    print(f"tip of MT3: {shape.x[-1] * 1e3:.2f}, {shape.y[-1] * 1e3:.2f} mm; {shape.verdict.message}")

    recordings = coast.read_recordings([HERE / "diagnose" / "recording.csv"], config)
    found = coast.diagnose(config, recordings)
    for effect in found.effects:
        print(f"{found.verdict}: {effect.id}, confidence {effect.confidence:.0%}")
        for name, value in effect.parameters.items():
            print(f"  {name} = {value.value:.4f} +- {value.std:.4f}")


if __name__ == "__main__":
    main()
