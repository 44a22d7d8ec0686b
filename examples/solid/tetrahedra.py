"""The same periodic cell in 10-node tetrahedra of gmsh: Open Cascade solids, free meshing.

A second route, to check the swept bricks.
"""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import cells
import numpy as np
from mesh import Fineness, Solid, half_section, second_moment

GEOMETRY = """
SetFactory("OpenCASCADE");
Cylinder(1) = {{0, 0, 0, 0, 0, {half_uncut}, 1, Pi}};
Rotate {{{{0, 0, 1}}, {{0, 0, 0}}, -Pi/2}} {{ Volume{{1}}; }}
{strip}
Cylinder(9) = {{0, 0, -1, 0, 0, {length} + 2, {inner}, 2*Pi}};
BooleanDifference{{ Volume{{1, 2}}; Delete; }}{{ Volume{{9}}; Delete; }}
BooleanFragments{{ Volume{{:}}; Delete; }}{{ }}
Physical Volume("TUBE") = {{Volume{{:}}}};
Field[1] = MathEval;
Field[1].F = "{size}";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeMax = {largest};
Mesh.ElementOrder = 2;
"""
STRIP = {
    "sector": "Cylinder(2) = {{0, 0, {half_uncut}, 0, 0, {half_cut}, 1, {angle}}};\n"
    "Rotate {{{{0, 0, 1}}, {{0, 0, 0}}, Pi/2 - {angle}}} {{ Volume{{2}}; }}",
    "chord": "Cylinder(2) = {{0, 0, {half_uncut}, 0, 0, {half_cut}, 1, Pi}};\n"
    "Box(3) = {{0, {height}, 0, 2, 2, {length}}};\n"
    "BooleanIntersection{{ Volume{{2}}; Delete; }}{{ Volume{{3}}; Delete; }}",
}


def program() -> str:
    """Find `gmsh`."""
    found = shutil.which("gmsh")
    if found is None:
        raise SystemExit("gmsh is not installed: apt install gmsh")
    return found


def version() -> str:
    """Return the name and version that `gmsh --version` says."""
    return "gmsh " + subprocess.run([program(), "--version"], capture_output=True, text=True, check=True).stderr.strip()


def mesh_cell(
    inner: float, depth: float, cut: float, uncut: float, kind: str, *, smallest: float, growth: float, largest: float
) -> Solid:
    """Mesh a quarter of the cell in 10-node tetrahedra, sizes growing with the distance from the notch's edge."""
    height = depth - 1.0
    angle = math.acos(height)
    values = {"half_uncut": uncut / 2, "half_cut": cut / 2, "length": (uncut + cut) / 2}
    values |= {"inner": inner, "angle": angle, "height": height}
    across = f"x*{math.cos(angle)} - y*{math.sin(angle)}" if kind == "sector" else f"y - {height}"
    size = f"{smallest} + {growth}*sqrt(({across})^2 + (z - {uncut / 2})^2)"
    geometry = GEOMETRY.format(**values, strip=STRIP[kind].format(**values), size=size, largest=largest)
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "cell.geo").write_text(geometry)
        command = [program(), "-3", "-format", "inp", "-o", "cell.inp", "-nt", "1", "cell.geo"]
        subprocess.run(command, cwd=scratch, capture_output=True, check=True)
        return read_mesh((Path(scratch) / "cell.inp").read_text())


def read_mesh(text: str) -> Solid:
    """Nodes and 10-node tetrahedra of a mesh written by gmsh as .inp."""
    sections = re.split(r"^\*", text, flags=re.MULTILINE)
    numbers: dict[str, list[list[str]]] = {"NODE": [], "C3D10": []}
    for section in sections:
        head, _, body = section.partition("\n")
        key = "NODE" if head.strip() == "NODE" else "C3D10" if "C3D10" in head else None
        if key:
            flat = re.sub(r",\s*\n", ",", body)
            numbers[key] += [line.split(",") for line in flat.splitlines() if line.strip()]
    labels = np.array([int(row[0]) for row in numbers["NODE"]])
    points = np.array([[float(v) for v in row[1:4]] for row in numbers["NODE"]])
    tetrahedra = np.array([[int(v) for v in row[1:11]] for row in numbers["C3D10"]])
    used, renumbered = np.unique(tetrahedra, return_inverse=True)
    place = np.empty(labels.max() + 1, dtype=np.int64)
    place[labels] = np.arange(labels.size)
    return Solid(points[place[used]], {"C3D10": renumbered.reshape(-1, 10)})


def solve_cell(
    inner: float, depth: float, cut: float, uncut: float, kind: str, *, scale: float = 1.0
) -> tuple[float, int]:
    """Return delta / ro of one cell and the number of nodes; `scale` multiplies every element size."""
    wall = scale * (1.0 - inner)
    solid = mesh_cell(inner, depth, cut, uncut, kind, smallest=0.04 * wall, growth=0.3 * scale, largest=1.2 * wall)
    # lengths snap to the cell's planes: gmsh leaves 1e-17 of noise
    nodes = np.round(solid.nodes, 10)
    fine = half_section(1.0, inner, depth, kind, Fineness(4, 0.05, 1.5, 0.1))
    moments = second_moment(fine, strip=False)[2], second_moment(fine, strip=True)[2]
    _, compliance = cells.bend(Solid(nodes, solid.elements), cut_moment=moments[1], poisson=cells.POISSON)
    return float((compliance - uncut / moments[0]) * moments[1] - cut), len(nodes)
