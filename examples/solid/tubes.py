"""Whole notched tubes as 3-D solids under gravity and a tip force: shape recordings that nobody fitted.

Each tube is clamped at z = 0 (no displacement on the whole face), starts with a full ring and ends with a cut, as in
the configuration that is written beside the shapes. Deformation is finite (NLGEOM), the material linear. A point of a
shape is the displaced middle of a ring, the mean over its area; gravity, scaled up because the tubes are short, acts
along -y.

    python examples/solid/tubes.py --out FOLDER   tubes.toml and the shapes (about 25 minutes of one core)
    python examples/solid/tubes.py --mesh         what a finer mesh changes in one tube
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import calculix
import numpy as np
from mesh import Fineness, Floats, graded, half_section, nodal_areas, sweep

GRAVITY = 1.5e4  # m/s^2
YOUNGS_MODULUS = 45e3  # MPa
DENSITY = 6450e-12  # t/mm^3
POISSON = 0.33
FINENESS = Fineness(through_wall=1, first=0.25, growth=2.5, largest=0.6)


@dataclass(frozen=True)
class Tube:
    """A notched tube, mm; `section` as in the configuration: sector (radial walls) or chord (flat cut)."""

    name: str
    section: str
    depth: float
    cut: float = 0.3
    uncut: float = 0.3
    count: int = 16
    outer_radius: float = 0.2
    inner_radius: float = 0.165


@dataclass(frozen=True)
class Load:
    """`notch`: the side to which the notches open, "up" or "down". Gravity, m/s^2, and tip force, N, along -y."""

    notch: str
    gravity: float = GRAVITY
    tip_force: float = 0.0


# a file of shapes each; the tubes of the held-out files have depths that the others have not
TUBES = {
    "radial": (
        Tube("R314", "sector", 0.314, count=16),
        Tube("R350", "sector", 0.350, count=12),
        Tube("R314_long_cut", "sector", 0.314, cut=0.6, count=12),
        Tube("R314_short_uncut", "sector", 0.314, uncut=0.1, count=20),
    ),
    "radial_held_out": (Tube("R335", "sector", 0.335, count=14), Tube("R364", "sector", 0.364, count=11)),
    "flat": (
        Tube("F270", "chord", 0.270, count=18),
        Tube("F314", "chord", 0.314, count=13),
        Tube("F270_long_cut", "chord", 0.270, cut=0.6, count=12),
        Tube("F270_short_uncut", "chord", 0.270, uncut=0.1, count=22),
    ),
    "flat_held_out": (Tube("F292", "chord", 0.292, count=15), Tube("F328", "chord", 0.328, count=12)),
    "tip_force": (Tube("R314", "sector", 0.314, count=16), Tube("F270", "chord", 0.270, count=18)),
}
TIP_FORCE = 0.003  # N, in the file tip_force


@dataclass(frozen=True)
class Shape:
    """Centreline points, mm, from the clamp; and the turn of the last ring, rad."""

    x: Floats
    y: Floats
    angle: float
    nodes: int


def solve(tube: Tube, load: Load, fineness: Fineness = FINENESS, increments: int = 1) -> Shape:
    """Solve the deformed centreline of one tube under one load."""
    wall = tube.outer_radius - tube.inner_radius
    section = half_section(tube.outer_radius, tube.inner_radius, tube.depth, tube.section, fineness)

    def between(start: float, length: float, *, start_graded: bool) -> Floats:
        """Boundaries graded towards both ends, or towards the far end only."""

        def half(part: float) -> Floats:
            return graded(part, fineness.first * wall, fineness.growth, fineness.largest * tube.outer_radius)

        if not start_graded:
            return start + length - half(length)[::-1]
        near = half(length / 2)
        return start + np.concatenate([near, (length - near[::-1])[1:]])

    segments, middles, at = [], [], 0.0
    for notch in range(tube.count):
        ring = between(at, tube.uncut, start_graded=notch > 0)
        if notch == 0:  # the middle must be an element boundary there too
            ring = np.unique(np.round(np.append(ring, tube.uncut / 2), 12))
        at += tube.uncut
        cut = between(at, tube.cut, start_graded=True)
        at += tube.cut
        segments += [(ring, True), (cut, False)]
        middles.append(ring[0] + tube.uncut / 2)
    solid, section_node, level = sweep(section, segments)
    boundaries = np.concatenate([segments[0][0][:1]] + [z[1:] for z, _ in segments])
    levels = [2 * int(np.argmin(np.abs(boundaries - z))) for z in middles]

    weights = {True: nodal_areas(section, strip=True), False: nodal_areas(section, strip=False)}
    sign = -1.0 if load.notch == "down" else 1.0  # the strip is on the mesh's +y: with notches down it is on top
    tip = np.flatnonzero(level == level.max())
    shares = weights[True][section_node[tip]] / weights[True].sum()
    rings = np.flatnonzero(np.isin(level, levels))
    cards = calculix.mesh_cards(solid)
    cards += calculix.set_card("CLAMP", np.flatnonzero(level == 0))
    cards += calculix.set_card("MIDDLE", np.flatnonzero(np.abs(solid.nodes[:, 0]) < 1e-9))
    cards += calculix.set_card("RINGS", rings)
    cards += ["*BOUNDARY", "CLAMP,1,3", "MIDDLE,1,1"]
    cards += ["*MATERIAL,NAME=NITINOL", "*ELASTIC", f"{calculix.number(YOUNGS_MODULUS)},{POISSON}"]
    cards += ["*DENSITY", calculix.number(DENSITY), "*SOLID SECTION,ELSET=TUBE,MATERIAL=NITINOL"]
    # the default tolerances, 0.5 % of force and 1 % of displacement, leave 20 micrometres at the tip
    cards += ["*STEP,NLGEOM,INC=200", "*CONTROLS,PARAMETERS=FIELD", "1e-6,1e-4", "*STATIC", f"{1 / increments},1."]
    cards += ["*DLOAD", f"TUBE,GRAV,{calculix.number(1e3 * load.gravity)},0.,{sign},0."]
    if load.tip_force:
        cards.append("*CLOAD")
        cards += [
            f"{n + 1},2,{calculix.number(sign * share * load.tip_force / 2)}"
            for n, share in zip(tip.tolist(), shares, strict=True)
        ]
    cards += ["*NODE PRINT,NSET=RINGS,FREQUENCY=1000", "U", "*END STEP"]
    moved = calculix.run(cards)[-1]

    x, y, angle = [0.0], [0.0], 0.0
    for z, ring_level in zip(middles, levels, strict=True):
        nodes = np.flatnonzero(level == ring_level)
        w = weights[False][section_node[nodes]] / weights[False].sum()
        u = np.array([moved[int(n)] for n in nodes])
        x.append(float(z + w @ u[:, 2]))
        y.append(float(-sign * (w @ u[:, 1])))
        height = solid.nodes[nodes, 1]
        slope = float(w @ (u[:, 2] * height)) / float(w @ (height * height))
        angle = float(np.arcsin(sign * slope))
    return Shape(np.array(x), np.array(y), angle, len(solid.nodes))


def straight(tube: Tube) -> Floats:
    """Return where the points of a shape lie before the load, mm."""
    return np.append(0.0, tube.uncut / 2 + np.arange(tube.count) * (tube.uncut + tube.cut))


def write_shapes(path: Path, name: str) -> None:
    """Solve the tubes of one file with their notches up and down, and write their shapes; a line on stderr for each."""
    lines = ["run,tube,x_mm,y_mm,natural"]
    for tube in TUBES[name]:
        for notch in ("up", "down"):
            shape = solve(tube, Load(notch, tip_force=TIP_FORCE if name == "tip_force" else 0.0))
            points = zip(shape.x.tolist(), shape.y.tolist(), strict=True)
            lines += [f"{tube.name}_{notch},{tube.name},{x:.6f},{y:.6f},{notch}" for x, y in points]
            length = float(np.hypot(np.diff(shape.x), np.diff(shape.y)).sum()) - straight(tube)[-1]
            tip = f"tip {shape.x[-1]:.4f} {shape.y[-1]:.4f} mm, turned {shape.angle:.4f} rad, longer by {length:.4f} mm"
            print(f"{name}: {tube.name} notches {notch}: {shape.nodes} nodes, {tip}", file=sys.stderr, flush=True)
    path.write_text("\n".join(lines) + "\n")


def configuration() -> str:
    """Return the tubes as a configuration that knows the paper's section only; comments say what is concealed."""
    lines = [
        "# The tubes of the solids beside this file, as examples/solid/tubes.py built them. The section is the paper's",
        "# (sector) for all: those whose name starts with F have flat cuts, and every notch has its end effect.",
        "version = 1",
        "",
        "[materials.nitinol]",
        f"youngs_modulus_gpa = {YOUNGS_MODULUS / 1e3}",
        f"density_kg_per_m3 = {DENSITY * 1e12:.1f}",
        "",
        "[environment]",
        f"gravity_m_per_s2 = {GRAVITY:.1f}  # scaled up: the tubes are short",
        "",
        "[middle]",
        'material = "nitinol"',
        "outer_diameter_mm = 0.4",
        "inner_diameter_mm = 0.33",
        "natural_curvature_per_m = 0.0",
    ]
    for tube in dict.fromkeys(tube for tubes in TUBES.values() for tube in tubes):
        notch = f"{{ cut_mm = {tube.cut}, uncut_mm = {tube.uncut}, count = {tube.count} }}"
        lines += ["", "[[middle.samples]]", f'name = "{tube.name}"', f"depth_mm = {tube.depth}", f"notch = {notch}"]
    return "\n".join(lines) + "\n"


def check_mesh() -> None:
    """Print the last point of one tube of each kind on the mesh used and on finer ones."""
    for tube in (TUBES["radial_held_out"][1], TUBES["flat_held_out"][1]):
        for fineness in (FINENESS, Fineness(1, 0.15, 2.0, 0.5), Fineness(2, 0.1, 2.0, 0.4)):
            shape = solve(tube, Load("up"), fineness)
            print(f"{tube.name}: {shape.nodes} nodes, tip {shape.x[-1]:.5f} {shape.y[-1]:.5f} mm", flush=True)


def main() -> None:
    """Parse the command line, run, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="folder to write to")
    parser.add_argument("--only", choices=list(TUBES), help="one file of shapes instead of all")
    parser.add_argument("--mesh", action="store_true", help="print what finer meshes change in one tube")
    options = parser.parse_args()
    if options.mesh:
        check_mesh()
        return
    if options.out is None:
        parser.error("--out FOLDER is needed")
    (options.out / "tubes.toml").write_text(configuration())
    for name in [options.only] if options.only else TUBES:
        write_shapes(options.out / f"{name}.csv", name)


if __name__ == "__main__":
    main()
