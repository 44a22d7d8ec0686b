"""Steel tubes with one long notch under their own weight as 3-D solids: the kind of case that the paper's Fig. 6 shows.

The paper's dimensions are not to be had: 0.5 x 0.4 mm, a ring of 2 mm at the clamp and one notch of 110 mm, of the depths of
the paper's four outer tubes, AISI 304 (200 GPa, 8000 kg/m^3), gravity 9.81 m/s^2 along -y, notch up and down.

    python examples/solid/long_notch.py --out FILE   places of the tip, frozen as data (about 5 minutes of one core)
    python examples/solid/long_notch.py --mesh       what a finer mesh changes
"""

from __future__ import annotations

import argparse
from pathlib import Path

import calculix
import numpy as np
from mesh import Fineness, Floats, graded, half_section, nodal_areas, sweep

OUTER, INNER = 0.25, 0.2  # mm
UNCUT, CUT = 2.0, 110.0
DEPTHS = (0.314, 0.350, 0.376, 0.400)
YOUNGS_MODULUS, POISSON, DENSITY, GRAVITY = 200e3, 0.29, 8000e-12, 9.81  # MPa, t/mm^3, m/s^2
FINENESS = Fineness(through_wall=1, first=0.5, growth=2.0, largest=4.0)


def tip(depth: float, notch: str, fineness: Fineness = FINENESS) -> tuple[float, float, int]:
    """Return x and y of the strip's end, mm, and how many nodes were used."""
    wall = OUTER - INNER
    section = half_section(OUTER, INNER, depth, "sector", Fineness(fineness.through_wall, 0.25, 2.5, 0.6))
    near = graded(UNCUT, fineness.first * wall, fineness.growth, fineness.largest * OUTER)
    ring = UNCUT - near[::-1]  # fine towards the notch
    cut = UNCUT + graded(CUT, fineness.first * wall, fineness.growth, fineness.largest * OUTER)
    solid, section_node, level = sweep(section, [(ring, True), (cut, False)])
    sign = -1.0 if notch == "down" else 1.0  # the strip is on the mesh's +y: with the notch down it is on top
    end = np.flatnonzero(level == level.max())
    cards = calculix.mesh_cards(solid)
    cards += calculix.set_card("CLAMP", np.flatnonzero(level == 0))
    cards += calculix.set_card("MIDDLE", np.flatnonzero(np.abs(solid.nodes[:, 0]) < 1e-9))
    cards += calculix.set_card("END", end)
    cards += ["*BOUNDARY", "CLAMP,1,3", "MIDDLE,1,1"]
    cards += ["*MATERIAL,NAME=STEEL", "*ELASTIC", f"{calculix.number(YOUNGS_MODULUS)},{POISSON}"]
    cards += ["*DENSITY", calculix.number(DENSITY), "*SOLID SECTION,ELSET=TUBE,MATERIAL=STEEL"]
    cards += ["*STEP,NLGEOM,INC=200", "*CONTROLS,PARAMETERS=FIELD", "1e-6,1e-4", "*STATIC", "1.,1."]
    cards += ["*DLOAD", f"TUBE,GRAV,{calculix.number(1e3 * GRAVITY)},0.,{sign},0."]
    cards += ["*NODE PRINT,NSET=END,FREQUENCY=1000", "U", "*END STEP"]
    moved = calculix.run(cards)[-1]
    areas: Floats = nodal_areas(section, strip=True)[section_node[end]]
    u = areas @ np.array([moved[int(node)] for node in end]) / areas.sum()
    return UNCUT + CUT + float(u[2]), -sign * float(u[1]), len(solid.nodes)


def main() -> None:
    """Parse the command line, run, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="file to write to")
    parser.add_argument("--mesh", action="store_true", help="print what a finer mesh changes")
    options = parser.parse_args()
    if options.mesh:
        for fineness in (FINENESS, FINENESS.refined(1.5), FINENESS.refined(2.0)):
            x, y, nodes = tip(DEPTHS[-1], "up", fineness)
            print(f"depth {DEPTHS[-1]:g}: {nodes} nodes, tip {x:.5f} {y:.5f} mm", flush=True)
    if options.out is not None:
        lines = ["depth_mm,notch,x_mm,y_mm"]
        for depth in DEPTHS:
            for notch in ("up", "down"):
                x, y, _ = tip(depth, notch)
                lines.append(f"{depth:g},{notch},{x:.6f},{y:.6f}")
        options.out.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
