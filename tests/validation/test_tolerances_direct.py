"""A tolerance run of 10,000 samples against direct samples by a second route, which shares no line with the package.

Sections, joint and checks are the formulas of the contract; beams are sums over pieces, repeated until they stand,
instead of marches. ``python tests/validation/test_tolerances_direct.py 1000000`` bends as many and prints it all.
"""

import sys
from pathlib import Path

import numpy as np
import pytest

from coast_cli.design.tolerance import tolerance_rows
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

REFERENCE = Path(__file__).parents[2] / "configs" / "tubes.toml"
SAMPLES, DIRECT, BENT = 10_000, 1_000_000, 20_000  # beams are dear: CI bends fewer
QUANTILES = {"low_90": 0.05, "median": 0.5, "high_90": 0.95}
PITCH, CUT, MODULUS, WEIGHT = 0.6e-3, 0.3e-3, 45e9, 6450.0 * 9.81
CURVATURE, LENGTH = 40.0, 40e-3
INNER = 0.25e-3
LIMITS = {
    ("max_total_precurvature_rad", "max"): lambda f: f["total_precurvature_rad"] <= 0.30,
    ("rigidity_ratio", "min"): lambda f: f["rigidity_ratio_mean"] >= 0.8,
    ("rigidity_ratio", "max"): lambda f: f["rigidity_ratio_mean"] <= 4.0,
    ("max_stroke_mm", "max"): lambda f: f["stroke_mm"] <= 6.0,
    ("max_tendon_strain", "max"): lambda f: f["tendon_strain"] <= 0.012,
}


class Tube:
    """One tube of one sector notch pattern, made many times; lengths in m."""

    def __init__(self, rng, count, diameters, depth, notches, curvature):
        self.ro = ro = (diameters[0] + 0.0035 * rng.standard_normal(count)) * 0.5e-3
        self.ri = ri = (diameters[1] + 0.0075 * rng.standard_normal(count)) * 0.5e-3
        d = (depth + 0.005 * rng.standard_normal(count)) * 1e-3
        phi = 2.0 * np.arccos((d - ro) / ro)
        two, three, four = (ro**k - ri**k for k in (2, 3, 4))
        self.axis = 4.0 * np.sin(phi / 2.0) * three / (3.0 * phi * two)
        self.ring = np.pi / 4.0 * four
        self.cut = four * (phi + np.sin(phi)) / 8.0 - 8.0 * np.sin(phi / 2.0) ** 2 * three**2 / (9.0 * phi * two)
        self.weights = WEIGHT * np.pi * two, WEIGHT * phi / 2.0 * two  # of ring and cut, N/m
        self.notches, self.curvature = notches, curvature
        # The cuts take all of the bend; the web ends in its skin and in the inner corners of the sector.
        reach = np.maximum(ro - self.axis, self.axis - (d - ro) * ri / ro)
        self.strain = CURVATURE * PITCH / CUT * reach
        self.closing = CUT / (ro + self.axis) / PITCH

    @property
    def mean(self):
        return (self.ring + self.cut) / 2.0

    @property
    def series(self):
        return 2.0 / (1.0 / self.ring + 1.0 / self.cut)

    def bends(self):
        """Rigidity times curvature in the middle of every ring and cut under gravity, N m, shape (2 notches, count).

        Sums over the pieces, each seen from its middle, are repeated until they stand.
        """

        def pieces(ring, cut):
            return np.tile(np.stack((ring, cut)), (self.notches, 1))

        rigidity, weight = MODULUS * pieces(self.ring, self.cut), CUT * pieces(*self.weights)
        shear = _beyond(weight)
        moment = np.zeros_like(rigidity)
        for _ in range(40):
            turn = (self.curvature - moment / rigidity) * CUT
            new = _beyond(shear * np.cos(np.cumsum(turn, axis=0) - turn / 2.0) * CUT)
            if np.max(np.abs(new - moment)) < 1e-7 * np.max(new):
                return rigidity * self.curvature - new
            moment = new
        raise AssertionError("the sums do not settle")


def _beyond(pieces):
    """Sum from the middle of each piece to the tip."""
    return np.cumsum(pieces[::-1], axis=0)[::-1] - pieces / 2.0


def pair(rng, count):
    """Outer tube OT4 and middle tube MT1; the natural curvature of the middle goes with gravity."""
    return Tube(rng, count, (0.50, 0.40), 0.400, 188, 1.1), Tube(rng, count, (0.36, 0.28), 0.243, 125, -2.0)


def closed_forms(outer, middle):
    """Figures that need no beam."""
    force = np.exp(0.2965 * np.pi) * 1.0063 ** (LENGTH / PITCH) * 42.6e9 * (outer.series + middle.series) * CURVATURE
    arm = middle.axis + middle.ri - 0.038e-3
    strain = force / arm / (53.965e9 * np.pi * 0.038e-3**2)
    bend = CURVATURE * PITCH / CUT
    shortening = LENGTH / PITCH * (CUT - 2.0 * (1.0 / bend - arm) * np.sin(bend * CUT / 2.0))
    both = [outer.ring + middle.ring, outer.cut + middle.cut]
    return {
        "rigidity_ratio_mean": outer.mean / middle.mean,
        "rigidity_ratio_series": outer.series / middle.series,
        "total_rigidity_mean_n_m2": MODULUS * (both[0] + both[1]) / 2.0,
        "total_rigidity_series_n_m2": MODULUS * 2.0 / (1.0 / both[0] + 1.0 / both[1]),
        "stroke_mm": 1e3 * (1.2e-3 + shortening + strain * 388.68e-3),
        "tendon_strain": strain,
        "web_strain": np.maximum(outer.strain, middle.strain),
        "closure_curvature_per_m": np.minimum(outer.closing, middle.closing),
        "possible": (middle.ro < outer.ri) & (2.0 * middle.ri > INNER),
    }


def precurvatures(outer, middle):
    """Total and signed: equation (8) over every ring and cut of the overlap, where the patterns lie side by side."""
    together = np.tile(MODULUS * np.stack((outer.ring + middle.ring, outer.cut + middle.cut)), (middle.notches, 1))
    turn = (outer.bends()[: 2 * middle.notches] + middle.bends()) / together * CUT
    return {"total_precurvature_rad": np.abs(turn).sum(axis=0), "signed_precurvature_rad": turn.sum(axis=0)}


def direct_samples(rng, count, bent):
    """Figures of ``count`` direct samples; those of beams of the first ``bent`` only."""
    parts, bends, block = [], [], 1000
    for first in range(0, count, block):
        tubes = pair(rng, min(block, count - first))
        parts.append(closed_forms(*tubes))
        if first < bent:
            bends.append(precurvatures(*tubes))
    return {name: np.concatenate([part[name] for part in group]) for group in (bends, parts) for name in group[0]}


def compared(rows, direct):
    """Yield (name, as estimated, as direct, standard error of their difference, inside the stated interval or None)."""
    bent = direct["total_precurvature_rad"].size
    first = {name: column[:bent] for name, column in direct.items()}
    for row in rows:
        name = row["name"]
        if row["kind"] == "figure":
            values = direct[name][direct["possible"][: direct[name].size]]
            for quantile, share in QUANTILES.items():
                yield f"{name} {quantile}", share, np.mean(values <= row[quantile]), _error(share, values.size), None
            size = np.sqrt(1.0 / SAMPLES + 1.0 / values.size)
            yield f"{name} mean", row["mean"], values.mean(), row["std"] * size, None
        elif row["kind"] == "check":
            if name == "impossible":
                held = ~direct["possible"]
            elif name == "all":
                held = first["possible"] & np.all([limit(first) for limit in LIMITS.values()], axis=0)
            else:
                held = LIMITS[name, row["input"]](direct)
                held &= direct["possible"][: held.size]
            share = float(np.mean(held))
            inside = row["probability_low"] <= share <= row["probability_high"]
            yield f"{name} {row['input'] or ''}", row["probability"], share, _error(share, held.size), inside


def _error(share, count):
    return np.sqrt(share * (1.0 - share) * (1.0 / SAMPLES + 1.0 / count))


def estimated(seed, samples=SAMPLES):
    design = build(load_config(REFERENCE))
    return tolerance_rows(design, ("OT4", "MT1"), samples=samples, seed=seed, ranked=False, index_samples=8)[0]


@pytest.fixture(scope="module")
def direct():
    return direct_samples(np.random.default_rng(2026), DIRECT, BENT)


class Drawn:
    """Stands for random numbers: no error anywhere."""

    def standard_normal(self, count):
        return np.zeros(count)


def test_the_second_route_is_right_as_drawn(direct):
    drawn = direct_samples(Drawn(), 1, 1)
    nominal = {row["name"]: row["nominal"] for row in estimated(0, samples=2) if row["kind"] == "figure"}
    assert {*nominal, "possible"} == drawn.keys() == direct.keys()
    for name, value in nominal.items():
        assert drawn[name][0] == pytest.approx(value, rel=2e-5 if "precurvature" in name else 1e-9)


def test_every_figure_and_every_chance_agrees_with_direct_samples(direct):
    """Three seeds: nothing is further off than 4 standard errors; each chance lies in the stated interval of two of them."""
    seeds = [list(compared(estimated(seed), direct)) for seed in (1, 2, 3)]
    for rows in seeds:
        assert len(rows) == 10 * 4 + 7
        for name, one, other, error, _ in rows:
            assert abs(one - other) <= 4.0 * error, name
    for one, two, three in zip(*seeds, strict=True):
        held = [row[4] for row in (one, two, three) if row[4] is not None]
        assert len(held) in {0, 3}
        assert sum(held) >= 2 or not held, one[0]
    near = [abs(one - other) <= 1.96 * error for rows in seeds for _, one, other, error, _ in rows]
    assert np.mean(near) >= 0.9


def main(count):
    """Print, for three seeds, how far every figure and chance is off ``count`` direct samples."""
    table = direct_samples(np.random.default_rng(2026), count, count)
    for seed in (1, 2, 3):
        for name, one, other, error, inside in compared(estimated(seed), table):
            stated = "" if inside is None else f", in its interval: {inside}"
            off = (one - other) / error if error else 0.0
            sys.stdout.write(f"seed {seed}  {name:<34} {one:12.6g} {other:12.6g}  off by {off:5.2f} errors{stated}\n")


if __name__ == "__main__":
    main(int(sys.argv[1]))
