"""Extra cut length of one notch, from 3-D solid finite elements of a periodic cell in pure bending.

A tube of equal notches under a constant moment is symmetric about the middle of every uncut ring and of every cut, so
half a pitch between two planes that stay plane, and half of that by the bending plane, is exact. The moment turns the
far plane; its stretch is free, so there is no axial force. With the turn b of half a pitch, EI_eff = M (pitch / 2) /
b, and the extra cut length delta is

    pitch / EI_eff = uncut / EI_1 + (cut + delta) / EI_2

with EI_1 of the full ring and EI_2 of what the cut leaves. Everything is in outer radii; Young's modulus drops out.

    python examples/solid/cells.py --out FILE.json                the table (about 10 minutes of one core)
    python examples/solid/cells.py --held-out 60 --out FILE.csv   cells off the table's grid, to test its interpolation
    python examples/solid/cells.py --check                        mesh, cut length, Poisson's ratio, tetrahedra
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import calculix
import numpy as np
from mesh import Fineness, Floats, Solid, graded, half_section, second_moment, sweep

POISSON = 0.33
CUT = 2.0  # outer radii: long enough that delta no longer depends on it
FINENESS = Fineness(through_wall=2, first=0.05, growth=1.7, largest=0.4)
FINEST = Fineness(through_wall=4, first=0.01, growth=1.5, largest=0.25)
INNER = (0.60, 0.70, 0.78, 0.84, 0.89, 0.91, 0.93)
UNCUT = (0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.5, 7.0, 10.0)
# sector: depth / (2 ro). chord: height (depth - ro) / ri up to the bore's edge, then 1 + (height - ri) / wall
DEPTH = {
    "sector": (0.50, 0.55, 0.60, 0.65, 0.70, 0.75, 0.80, 0.85, 0.90, 0.94, 0.97),
    "chord": (0.0, 0.2, 0.4, 0.55, 0.7, 0.8, 0.9, 0.96, 0.985, 1.005, 1.05, 1.1, 1.2, 1.3, 1.6),
}


@dataclass(frozen=True)
class Cell:
    """An answer, in outer radii: delta, height of the axis that keeps its length, centroid of the cut section."""

    extra_cut: float
    neutral_axis: float
    centroid: float
    nodes: int


def depth_ratio(kind: str, inner: float, coordinate: float) -> float:
    """Return depth / ro from the table's depth coordinate."""
    if kind == "sector":
        return 2.0 * coordinate
    return 1.0 + (inner * coordinate if coordinate <= 1.0 else inner + (coordinate - 1.0) * (1.0 - inner))


def solve_cell(
    inner: float,
    depth: float,
    cut: float,
    uncut: float,
    kind: str,
    *,
    fineness: Fineness = FINENESS,
    poisson: float = POISSON,
    brick: str = "C3D20R",
) -> Cell:
    """Solve one cell in pure bending; lengths in outer radii, `kind` "sector" or "chord"."""
    section = half_section(1.0, inner, depth, kind, fineness)
    wall = 1.0 - inner

    def along(length: float) -> Floats:
        return graded(length, fineness.first * wall, fineness.growth, fineness.largest)

    ring, gap = uncut / 2 - along(uncut / 2)[::-1], uncut / 2 + along(cut / 2)
    solid, _, _ = sweep(section, [(ring, True), (gap, False)], brick)
    moments = second_moment(section, strip=False)[2], second_moment(section, strip=True)[2]
    axis, compliance = bend(solid, cut_moment=moments[1], poisson=poisson)
    return Cell(
        extra_cut=float((compliance - uncut / moments[0]) * moments[1] - cut),
        neutral_axis=axis,
        centroid=second_moment(section, strip=True)[1],
        nodes=len(solid.nodes),
    )


def bend(solid: Solid, *, cut_moment: float, poisson: float) -> tuple[float, float]:
    """Bend a quarter cell: height of the axis that keeps its length, and turn per pitch and moment at E = 1."""
    n = len(solid.nodes)
    z = solid.nodes[:, 2]
    base, far = np.flatnonzero(z == z.min()), np.flatnonzero(z == z.max())
    middle = np.flatnonzero(np.abs(solid.nodes[:, 0]) < 1e-9)
    # two nodes off the mesh carry the stretch and the turn of the far plane: u_z = stretch + y turn
    cards = calculix.mesh_cards(solid, np.zeros((2, 3)))
    cards += calculix.set_card("BASE", base) + calculix.set_card("MIDDLE", middle)
    cards += ["*BOUNDARY", "BASE,3,3", "MIDDLE,1,1", f"{np.intersect1d(base, middle)[0] + 1},2,2"]
    for node in far.tolist():
        height = calculix.number(-solid.nodes[node, 1])
        cards += ["*EQUATION", "3", f"{node + 1},3,1.,{n + 1},3,-1.,{n + 2},3,{height}"]
    cards += ["*MATERIAL,NAME=WALL", "*ELASTIC", f"1.,{poisson}", "*SOLID SECTION,ELSET=TUBE,MATERIAL=WALL"]
    # half the moment, on half the section
    cards += ["*STEP", "*STATIC", "*CLOAD", f"{n + 2},3,{calculix.number(cut_moment / 2)}"]
    cards += ["*NSET,NSET=PLANE", f"{n + 1},{n + 2}", "*NODE PRINT,NSET=PLANE", "U", "*END STEP"]
    answer = calculix.run(cards)[-1]
    stretch, turn = float(answer[n][2]), float(answer[n + 1][2])
    return -stretch / turn, 2 * turn / cut_moment


def table() -> dict[str, object]:
    """Solve delta / ro over inner radius, depth and uncut length; with where it comes from."""
    out: dict[str, object] = {
        "provenance": {
            "what": "extra cut length delta / ro of one notch of a periodic tube in pure bending, 3-D solids",
            "script": "examples/solid/cells.py",
            "program": calculix.version(),
            "element": "C3D20R, 20-node bricks swept along the tube (15-node wedges where a flat cut misses the bore)",
            "mesh": f"{FINENESS.through_wall} elements through the wall, {FINENESS.first} walls at the notch edge, "
            f"growing by {FINENESS.growth} up to {FINENESS.largest} outer radii",
            "poisson_ratio": POISSON,
            "cut_ratio": CUT,
            "axes": "inner_ratio = ri / ro; depth: sector = depth / (2 ro), chord = (depth - ro) / ri up to the bore, "
            "then 1 + (depth - ro - ri) / (ro - ri); uncut_ratio = uncut / ro",
        }
    }
    for kind, depths in DEPTH.items():
        rows = []
        for inner in INNER:
            rows.append([])
            for coordinate in depths:
                depth = depth_ratio(kind, inner, coordinate)
                cells = [solve_cell(inner, depth, CUT, uncut, kind) for uncut in UNCUT]
                rows[-1].append([round(c.extra_cut, 5) for c in cells])
            print(f"{kind} ri/ro {inner}", file=sys.stderr, flush=True)
        out[kind] = {"inner_ratio": INNER, "depth": depths, "uncut_ratio": UNCUT, "extra_cut_ratio": rows}
    return out


def held_out(count: int) -> str:
    """Solve `count` cells of each kind at random places inside the table, cuts of 0.5 to 4 outer radii; as CSV.

    Their mesh is finer than the table's, so that they show its error too.
    """
    random = np.random.default_rng(20)
    lines = ["kind,inner_ratio,depth_ratio,cut_ratio,uncut_ratio,extra_cut_ratio,neutral_axis_ratio,centroid_ratio"]
    for kind, depths in DEPTH.items():
        for _ in range(count):
            inner = round(random.uniform(INNER[0], INNER[-1]), 3)
            depth = round(depth_ratio(kind, inner, random.uniform(depths[0], depths[-1])), 4)
            spans = ((0.5, 4.0), (UNCUT[0], UNCUT[-1]))
            cut, uncut = (round(float(np.exp(random.uniform(*np.log(span)))), 3) for span in spans)
            c = solve_cell(inner, depth, cut, uncut, kind, fineness=FINENESS.refined(1.5))
            answers = f"{c.extra_cut:.5f},{c.neutral_axis:.5f},{c.centroid:.5f}"
            lines.append(f"{kind},{inner},{depth},{cut},{uncut},{answers}")
    return "\n".join(lines) + "\n"


def check() -> None:
    """Print how delta of four cells moves with mesh, element, cut length, Poisson's ratio, and what tetrahedra give."""
    import tetrahedra

    cases = (
        ("sector", 0.825, 1.57, 1.5),
        ("chord", 0.825, 1.75, 1.5),
        ("sector", 0.92, 1.25, 0.5),
        ("sector", 0.7, 1.1, 3.0),
    )
    print("delta / ro, cut 2 ro and Poisson's ratio 0.33 unless said")
    for kind, inner, depth, uncut in cases:
        place = (inner, depth, CUT, uncut, kind)
        print(f"{kind}, ri/ro {inner}, depth/ro {depth}, uncut/ro {uncut}")
        values = []
        for factor in (1.0, 1.5, 2.0):
            cell = solve_cell(*place, fineness=FINENESS.refined(factor))
            values.append(cell.extra_cut)
            print(f"  {cell.extra_cut:.5f}  elements / {factor} ({cell.nodes} nodes)")
        # order 2 is what is seen: the smallest elements sit at a singular edge
        print(f"  {values[2] + (values[2] - values[0]) / 3:.5f}  extrapolated (Richardson, order 2)")
        finest = solve_cell(*place, fineness=FINEST)
        print(f"  {finest.extra_cut:.5f}  graded further ({finest.nodes} nodes)")
        print(f"  {solve_cell(*place, brick='C3D20').extra_cut:.5f}  fully integrated bricks")
        for scale in (1.5, 1.0):
            extra, nodes = tetrahedra.solve_cell(*place, scale=scale)
            print(f"  {extra:.5f}  free tetrahedra of gmsh ({nodes} nodes)")
        for cut in (0.1, 0.3, 0.5, 1.0, 5.0):
            print(f"  {solve_cell(inner, depth, cut, uncut, kind).extra_cut:.5f}  cut/ro {cut}")
        for poisson in (0.28, 0.38):
            print(f"  {solve_cell(*place, poisson=poisson).extra_cut:.5f}  Poisson's ratio {poisson}")


def main() -> None:
    """Parse the command line, run, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="file to write")
    parser.add_argument("--held-out", type=int, metavar="N", help="N random cells of each kind instead of the table")
    parser.add_argument("--check", action="store_true", help="print convergence and cross-checks")
    options = parser.parse_args()
    if options.check:
        check()
    elif options.out is None:
        parser.error("--out FILE is needed")
    elif options.held_out:
        options.out.write_text(held_out(options.held_out))
    else:
        text = json.dumps(table(), indent=1)
        # one row of numbers a line
        options.out.write_text(_rows_on_one_line(text) + "\n")


def _rows_on_one_line(text: str) -> str:
    return re.sub(
        r"\[[^\[\]]*\]", lambda m: re.sub(r"\s+", " ", m.group(0)).replace("[ ", "[").replace(" ]", "]"), text
    )


if __name__ == "__main__":
    main()
