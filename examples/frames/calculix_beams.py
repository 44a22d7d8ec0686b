"""Solve the reference tubes with CalculiX (quadratic beam elements expanded to solids) and write tips as CSV to stdout.

Needs `ccx` (Debian: calculix-ccx): python examples/frames/calculix_beams.py > calculix_beams.csv
Each piece is a square bar of side 0.1 mm whose modulus gives the piece's flexural rigidity and whose density its weight;
so thin a bar hardly stretches or shears. ccx cuts numbers at 20 characters.
"""

import subprocess
import tempfile
import time
from pathlib import Path

from reference_tubes import GRAVITY, NATURAL_CURVATURES, FrameModel, frame_model

SIDE = 0.1e-3  # m
UNIT = 1e3  # lengths in mm, forces in N, mass in t: ccx works best near one


def deck(model: FrameModel) -> str:
    """Return the input file: nodes on the natural arc with midside nodes between, one B32 element a pair of pieces."""
    lines = ["*NODE, NSET=NALL"]
    lines += [
        f"{i + 1}, {x * UNIT:.12g}, {y * UNIT:.12g}, 0" for i, (x, y) in enumerate(zip(model.x, model.y, strict=True))
    ]
    count = (model.x.size - 1) // 2
    lines.append("*ELEMENT, TYPE=B32, ELSET=ALL")
    lines += [f"{e + 1}, {2 * e + 1}, {2 * e + 2}, {2 * e + 3}" for e in range(count)]
    side = SIDE * UNIT
    for name, first in (("RING", 0), ("NOTCH", 2)):
        rigidity, weight = model.rigidity[first] * UNIT**2, model.weight[first] / GRAVITY
        lines.append(f"*ELSET, ELSET={name}")
        lines += [f"{e + 1}," for e in range(first // 2, count, 2)]
        lines += [f"*MATERIAL, NAME={name}", "*ELASTIC", f"{rigidity * 12 / side**4:.12g}, 0.0"]
        lines += ["*DENSITY", f"{weight * 1e-6 / side**2:.12g}"]
        lines += [f"*BEAM SECTION, ELSET={name}, MATERIAL={name}, SECTION=RECT", f"{side}, {side}", "0, 0, 1"]
    lines += ["*BOUNDARY", "1, 1, 6", "*STEP, NLGEOM, INC=1000", "*STATIC", "0.05, 1., 1e-6, 0.1"]
    lines += ["*DLOAD", f"ALL, GRAV, {GRAVITY * UNIT}, 0, -1, 0"]
    lines += ["*NSET, NSET=TIP", f"{model.x.size}", "*NODE PRINT, NSET=TIP, FREQUENCY=1000", "U", "*END STEP"]
    return "\n".join(lines) + "\n"


def solve(model: FrameModel) -> tuple[float, float]:
    """Return tip x, y (m)."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "beam.inp").write_text(deck(model))
        subprocess.run(["ccx", "beam"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        last = [line.split() for line in Path(folder, "beam.dat").read_text().splitlines() if line.strip()][-1]
    return float(model.x[-1]) + float(last[1]) / UNIT, float(model.y[-1]) + float(last[2]) / UNIT


def main() -> None:
    """Solve every tube; each takes a minute or more."""
    print("natural_curvature_per_m,tip_x_m,tip_y_m,seconds")
    for curvature in NATURAL_CURVATURES:
        start = time.perf_counter()
        tip_x, tip_y = solve(frame_model(curvature, 2))
        print(f"{curvature},{tip_x:.9g},{tip_y:.9g},{time.perf_counter() - start:.1f}", flush=True)


if __name__ == "__main__":
    main()
