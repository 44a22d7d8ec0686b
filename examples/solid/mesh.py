"""Structured solid meshes of notched tubes: a half section, swept along the axis.

The tube is symmetric about its bending plane, so only x >= 0 is meshed. The strip that a notch leaves is centred on
+y, the notch opens to -y. The section is mapped in polar form, r and the angle from +y, with the strip's edge on an
element boundary and elements that grow geometrically away from it: the edge where a strip meets the full ring carries
a stress singularity. Sections are quadratic (8-node quadrilaterals, 6-node triangles), swept into 20-node bricks and
15-node wedges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Section:
    """Half of a tube's section: nodes (n, 2); quads (m, 8), triangles (k, 6), and which of them the strip keeps."""

    nodes: Floats
    quads: Integers
    quad_in_strip: NDArray[np.bool_]
    triangles: Integers
    triangle_in_strip: NDArray[np.bool_]


@dataclass(frozen=True)
class Solid:
    """Nodes (n, 3), and by CalculiX's name of the element type the node numbers, from 0, of every element."""

    nodes: Floats
    elements: dict[str, Integers]


@dataclass(frozen=True)
class Fineness:
    """Element sizes: `first` at the singular edge, in walls, growing by `growth` up to `largest`, in outer radii."""

    through_wall: int = 2
    first: float = 0.25
    growth: float = 1.7
    largest: float = 0.4

    def refined(self, factor: float) -> Fineness:
        """Return the same grading with every element divided by `factor`."""
        through_wall = max(1, round(self.through_wall * factor))
        return Fineness(through_wall, self.first / factor, self.growth ** (1 / factor), self.largest / factor)


def graded(length: float, first: float, growth: float, largest: float) -> Floats:
    """Return positions from 0 to `length`, elements growing from `first` by `growth` up to `largest`."""
    sizes = [first]
    while sum(sizes) < length:
        sizes.append(min(sizes[-1] * growth, largest))
    # drop the last element when the sum without it is the nearer one
    if len(sizes) > 1 and sum(sizes) - length > length - sum(sizes[:-1]):
        sizes.pop()
    positions = np.concatenate(([0.0], np.cumsum(sizes)))
    return np.asarray(positions * (length / positions[-1]))


def _with_middles(breakpoints: Floats) -> Floats:
    middles = 0.5 * (breakpoints[1:] + breakpoints[:-1])
    out = np.empty(2 * breakpoints.size - 1)
    out[0::2], out[1::2] = breakpoints, middles
    return out


def _block(x: Floats, y: Floats) -> tuple[Floats, Integers]:
    """Quadratic quadrilaterals on a grid of (2 nu + 1, 2 nv + 1) points; centre points are left out by the merge."""
    nu, nv = (x.shape[0] - 1) // 2, (x.shape[1] - 1) // 2
    number = np.arange(x.size).reshape(x.shape)
    i, j = (2 * g.ravel() for g in np.meshgrid(np.arange(nu), np.arange(nv), indexing="ij"))
    corners = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    quads = np.stack([number[i + a, j + b] for a, b in corners], axis=1)
    return np.stack([x.ravel(), y.ravel()], axis=1), quads


def half_section(outer_radius: float, inner_radius: float, depth: float, kind: str, fineness: Fineness) -> Section:
    """Mesh the half section of a tube notched to `depth`, with `kind` "sector" (radial walls) or "chord" (flat cut)."""
    height = depth - outer_radius
    wall = outer_radius - inner_radius
    half_angle = float(np.arccos(height / outer_radius))
    f = fineness

    def along(angle: float) -> Floats:
        """Shares from 0 at the strip's edge to 1."""
        length = angle * outer_radius
        return _with_middles(graded(length, f.first * wall, f.growth, f.largest * outer_radius) / length)

    blocks: list[tuple[Floats, Integers, bool]] = []

    def add(x: Floats, y: Floats, *, in_strip: bool) -> None:
        blocks.append((*_block(x, y), in_strip))

    if kind == "sector" or height < inner_radius:
        radius = np.linspace(inner_radius, outer_radius, 2 * f.through_wall + 1)[None, :]
        edge = np.full_like(radius, half_angle) if kind == "sector" else np.arccos(height / radius)
        strip = edge * (1.0 - along(half_angle))[::-1, None]
        ring = edge + (np.pi - edge) * along(np.pi - half_angle)[:, None]
        for angle, in_strip in ((strip, True), (ring, False)):
            add(radius * np.sin(angle), radius * np.cos(angle), in_strip=in_strip)
    else:  # the flat cut misses the bore: what is left is a solid segment
        chord = np.sqrt(outer_radius**2 - height**2)
        angle = np.arctan2(chord * (1.0 - along(half_angle))[::-1], height)[:, None]
        boundary = height / np.cos(angle)
        for inner, outer, in_strip in ((boundary, outer_radius, True), (inner_radius, boundary, False)):
            share = np.linspace(0.0, 1.0, 2 * f.through_wall + 1)[None, :]
            r = inner + (outer - inner) * share
            add(r * np.sin(angle), r * np.cos(angle), in_strip=in_strip)
        angle = (half_angle + (np.pi - half_angle) * along(np.pi - half_angle))[:, None]
        r = np.linspace(inner_radius, outer_radius, 2 * f.through_wall + 1)[None, :]
        add(r * np.sin(angle), r * np.cos(angle), in_strip=False)
    return _merge(blocks, outer_radius)


def _merge(blocks: list[tuple[Floats, Integers, bool]], outer_radius: float) -> Section:
    """Join blocks whose nodes coincide, drop unused nodes, turn collapsed quadrilaterals into triangles."""
    offsets = np.cumsum([0] + [len(points) for points, _, _ in blocks])
    points = np.concatenate([p for p, _, _ in blocks])
    quads = np.concatenate([q + o for (_, q, _), o in zip(blocks, offsets, strict=False)])
    in_strip = np.concatenate([np.full(len(q), s) for _, q, s in blocks])
    key = np.round(points / outer_radius, 9) + 0.0
    _, first, same = np.unique(key, axis=0, return_index=True, return_inverse=True)
    quads = same.reshape(-1)[quads]
    collapsed = quads[:, 1] == quads[:, 2]  # the side at the far end of the first coordinate has no length
    triangles = quads[collapsed][:, [0, 1, 3, 4, 6, 7]]
    kept = np.concatenate([quads[~collapsed].ravel(), triangles.ravel()])
    used, renumbered = np.unique(kept, return_inverse=True)
    n = 8 * int((~collapsed).sum())
    return Section(
        nodes=points[first][used],
        quads=renumbered[:n].reshape(-1, 8),
        quad_in_strip=in_strip[~collapsed],
        triangles=renumbered[n:].reshape(-1, 6),
        triangle_in_strip=in_strip[collapsed],
    )


def nodal_areas(section: Section, *, strip: bool) -> Floats:
    """Integrate every node's shape function over the half ring, or the half strip: weights of section means, (n,)."""
    return _integrate(section, strip=strip)[0]


def second_moment(section: Section, *, strip: bool) -> tuple[float, float, float]:
    """Integrate area, centroid height and second moment about the centroid of both halves over the mesh."""
    _, area, first, second = _integrate(section, strip=strip)
    return 2 * area, first / area, 2 * (second - first**2 / area)


def _integrate(section: Section, *, strip: bool) -> tuple[Floats, float, float, float]:
    weights = np.zeros(len(section.nodes))
    area = first = second = 0.0
    for elements, kept, rule in (
        (section.quads, section.quad_in_strip, _quad_rule()),
        (section.triangles, section.triangle_in_strip, _triangle_rule()),
    ):
        chosen = elements[kept] if strip else elements
        shape, derivative, gauss = rule  # (g, a), (g, a, 2), (g,)
        nodes = section.nodes[chosen]  # (m, a, 2)
        jacobian = np.einsum("gak,mac->mgkc", derivative, nodes)
        size = np.abs(np.linalg.det(jacobian)) * gauss
        y = np.einsum("ga,ma->mg", shape, nodes[..., 1])
        np.add.at(weights, chosen, np.einsum("mg,ga->ma", size, shape))
        area += float(size.sum())
        first += float((size * y).sum())
        second += float((size * y * y).sum())
    return weights, area, first, second


def _quad_rule() -> tuple[Floats, Floats, Floats]:
    """Return shape functions of the 8-node quadrilateral, their derivatives and weights at 4 x 4 Gauss points."""
    x, w = np.polynomial.legendre.leggauss(4)
    s, t = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    weight = np.outer(w, w).ravel()
    corner = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    shape, ds, dt = [], [], []
    for a, b in corner:
        shape.append((1 + a * s) * (1 + b * t) * (a * s + b * t - 1) / 4)
        ds.append(a * (1 + b * t) * (2 * a * s + b * t) / 4)
        dt.append(b * (1 + a * s) * (a * s + 2 * b * t) / 4)
    for a, b in ((0, -1), (1, 0), (0, 1), (-1, 0)):
        if a == 0:
            shape.append((1 - s * s) * (1 + b * t) / 2)
            ds.append(-s * (1 + b * t))
            dt.append(b * (1 - s * s) / 2)
        else:
            shape.append((1 + a * s) * (1 - t * t) / 2)
            ds.append(a * (1 - t * t) / 2)
            dt.append(-t * (1 + a * s))
    return np.stack(shape, 1), np.stack([np.stack(ds, 1), np.stack(dt, 1)], 2), weight


def _triangle_rule() -> tuple[Floats, Floats, Floats]:
    """Return the same of the 6-node triangle at collapsed 4 x 4 Gauss points."""
    x, w = np.polynomial.legendre.leggauss(4)
    p, q = (0.5 * (1 + g.ravel()) for g in np.meshgrid(x, x, indexing="ij"))
    s, t = p, q * (1 - p)
    weight = np.outer(w, w).ravel() / 4 * (1 - p)
    r = 1 - s - t
    one, zero = np.ones_like(s), np.zeros_like(s)
    shape = [r * (2 * r - 1), s * (2 * s - 1), t * (2 * t - 1), 4 * r * s, 4 * s * t, 4 * t * r]
    ds = [1 - 4 * r, 4 * s - 1, zero, 4 * (r - s), 4 * t, -4 * t]
    dt = [1 - 4 * r, zero, 4 * t - one, -4 * s, 4 * s, 4 * (r - t)]
    return np.stack(shape, 1), np.stack([np.stack(ds, 1), np.stack(dt, 1)], 2), weight


def sweep(
    section: Section, segments: list[tuple[Floats, bool]], brick: str = "C3D20R"
) -> tuple[Solid, Integers, Integers]:
    """Sweep a section along z: the solid, and for each of its nodes the section node and the level, two an element.

    `segments` are (positions of the element boundaries, whether the full ring is there), end to end.
    """
    boundaries = np.concatenate([segments[0][0][:1]] + [z[1:] for z, _ in segments])
    full = np.concatenate([np.full(z.size - 1, ring) for z, ring in segments])
    n = len(section.nodes)

    def swept(elements: Integers, kept: NDArray[np.bool_], corners: int) -> Integers:
        out = []
        for k, ring in enumerate(full):
            chosen = elements if ring else elements[kept]
            low, middle, high = chosen + 2 * k * n, chosen + (2 * k + 1) * n, chosen + (2 * k + 2) * n
            parts = [low[:, :corners], high[:, :corners], low[:, corners:], high[:, corners:], middle[:, :corners]]
            out.append(np.hstack(parts))
        return np.concatenate(out)

    bricks = swept(section.quads, section.quad_in_strip, 4)
    wedges = swept(section.triangles, section.triangle_in_strip, 3)
    used, renumbered = np.unique(np.concatenate([bricks.ravel(), wedges.ravel()]), return_inverse=True)
    level, section_node = np.divmod(used, n)
    elements = {brick: renumbered[: bricks.size].reshape(-1, 20), "C3D15": renumbered[bricks.size :].reshape(-1, 15)}
    solid = Solid(np.column_stack([section.nodes[section_node], _with_middles(boundaries)[level]]), elements)
    return solid, section_node, level
