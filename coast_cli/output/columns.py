"""The meaning of every column of every command's rows: what ``coast explain`` says and what tests hold the rows to."""

from __future__ import annotations

COLUMNS: dict[str, dict[str, str]] = {
    "rank-pairs": {
        "rank": "place in the list, best first; a pair with a reason cannot be assembled",
        "sample": "the pair's number, S1 onwards, middle-major: all outer tubes with the first middle tube come first",
        "outer": "outer tube",
        "middle": "middle tube",
        "total_precurvature_rad": "integral of the size of the pair's curvature along the overlap, rad",
        "signed_precurvature_rad": "the same with its sign: positive bends with the outer tube, against gravity, rad",
        "rigidity_ratio_mean": "rigidity of the outer over the middle tube, each averaged along the tube (the paper's)",
        "rigidity_ratio_series": "the same ratio of series rigidities, 1 over the mean compliance: what bends",
        "total_rigidity_mean_n_m2": "flexural rigidity of both tubes, averaged along the overlap, N m^2",
        "total_rigidity_series_n_m2": "flexural rigidity of both tubes in series along the overlap, N m^2",
        "score": "weighted root of the sum of squares of pre-curvature, |ln ratio| and rigidity, each scaled to 0..1",
        "pareto": "no other pair is as good in all three and better in one",
        "leading_tube": "the tube whose bend the pair follows; snapping was seen where the outer one leads",
        "reason": "why a pair cannot be assembled; no value where it can",
    },
    "stroke": {
        "outer": "outer tube; no value for a joint of one tube",
        "middle": "middle tube, which holds the tendon",
        "curvature_per_m": "curvature of the bending segment, 1/m",
        "bending_length_mm": "X2, the bending segment beyond the inner tube's tip, mm",
        "stroke_mm": "X1, tendon stroke at the actuator, deadband included, mm",
        "tension_n": "tendon tension at the actuator, N",
        "tendon_strain": "elongation of the tendon over its length",
        "tip_x_mm": "place of the tip along the straight segment, mm",
        "tip_y_mm": "place of the tip across it, mm",
    },
    "beam": {
        "tube": "the tube",
        "arc_length_mm": "distance from the clamp along the tube, mm",
        "x_mm": "place along the clamped direction, mm",
        "y_mm": "place against gravity, mm",
        "angle_deg": "angle of the tangent from the clamped direction, degrees",
        "curvature_per_m": "curvature just before the point (at the clamp, just after), 1/m; positive against gravity",
    },
    "check": {
        "config": "the configuration",
        "pair": "the pair that is held to the limit",
        "check": "the limit's key under [checks]",
        "bound": "min or max: from which side it limits",
        "value": "what the design has, in the unit of the key",
        "limit": "what it may have",
        "passed": "whether the limit holds",
        "line": "line of the limit in the configuration",
    },
    "explain": {
        "name": "the name; keys of a configuration are dotted",
        "kind": "what sort of name it is",
        "meaning": "what it means",
        "allowed": "the values it may have",
        "source": "where its equation or range comes from",
    },
    "validate": {
        "config": "the configuration",
        "valid": "whether it can be used",
        "line": "line of the first thing wrong with it",
        "message": "the first thing wrong with it",
    },
}
