"""Four steel tubes with one long notch, as the paper's Fig. 6 has them, three ways: 3-D solid, beam, the paper's method.

    python examples/long_notch/compare.py

Solids are frozen in tests/validation/data/solid/long_notch.csv (examples/solid/long_notch.py makes them); what is assumed of
the tubes stands in tubes.toml.
"""

import csv
from pathlib import Path

import numpy as np

from coast_cli.mechanics.beam import solve_beam
from coast_cli.mechanics.beam.projected import solve_beam_projected
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

HERE = Path(__file__).parent
SOLIDS = HERE.parents[1] / "tests" / "validation" / "data" / "solid" / "long_notch.csv"
STEPS = (5, 10, 20, 40)
MM = 1e-3


def solid_tips() -> dict[float, np.ndarray]:
    """Return the tip of each solid by its depth in mm, m, the mean of notch up and notch down."""
    found: dict[float, list[tuple[float, float]]] = {}
    with SOLIDS.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            found.setdefault(float(row["depth_mm"]), []).append((float(row["x_mm"]) * MM, float(row["y_mm"]) * MM))
    return {depth: np.mean(tips, axis=0) for depth, tips in found.items()}


def main() -> None:
    """Print one row a tube."""
    design, solids = build(load_config(HERE / "tubes.toml")), solid_tips()
    print("              sag, mm        off the solid  paper's method off the beam, mm, by its load steps")
    print("tube  depth   solid   beam   beam   20 steps  " + "".join(f"{n:>10}" for n in STEPS) + "  order")
    for tube in design.outer:
        depth = round(float(tube.depth[0]) / MM, 6)
        solid, beam = solids[depth], solve_beam(tube, design.gravity)
        exact = np.array([beam.x[-1], beam.y[-1]])
        tips = [solve_beam_projected(tube, design.gravity, load_steps=steps) for steps in STEPS]
        tips = [np.array([one.x[-1], one.y[-1]]) for one in tips]
        off = [np.hypot(*(one - exact)) / MM for one in tips]
        beam_off, tip_off = (np.hypot(*(one - solid)) / abs(solid[1]) for one in (exact, tips[2]))
        print(
            f"{tube.name:4}  {depth:.3f}  {-solid[1] / MM:6.3f} {-exact[1] / MM:6.3f} {beam_off:6.2%}  {tip_off:9.2%}  "
            + "".join(f"{one:10.6f}" for one in off)
            + f"  {np.log2(off[1] / off[2]):5.3f}"
        )


if __name__ == "__main__":
    main()
