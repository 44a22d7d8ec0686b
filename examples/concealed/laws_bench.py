"""Bench faults: what goes wrong with one run, the drive, the camera or the load cell while the robot is as it should be.

Which run (`run`, from zero), when and where is drawn with the fault and is part of the truth.
"""

from __future__ import annotations

import numpy as np

from examples.concealed.protocol import Protocol
from examples.concealed.recipes import BEND, Context, Nature, Parameters, Recipe, returns, sign

CONSTANT: tuple[tuple[str, ...], ...] = ()


def _sensor(*variables: tuple[str, ...]) -> Nature:
    return Nature(("sensor",), variables, memory=False, rate=False, dissipative=None)


def _others_agree(p: Protocol) -> bool:
    """Return whether one odd run stands against at least two others."""
    return len(p.runs) >= 3


def _run(g: np.random.Generator, c: Context) -> int:
    return int(g.integers(c.runs))


def _moments(g: np.random.Generator, c: Context) -> Parameters:
    count = int(g.integers(1, 4))
    return {
        "run": _run(g, c),
        "at_shares": tuple(sorted(g.uniform(0.1, 0.8, count))),
        "parts": tuple(g.dirichlet(np.full(count, 3.0))),
        "lost_mm": c.span_mm * g.uniform(0.03, 0.15),
    }


BENCH: dict[str, Recipe] = {
    "run_differs_gain": Recipe(
        "record (one run)",
        "sensor",
        _others_agree,
        lambda g, c: {"run": _run(g, c), "gain": 1 + sign(g) * g.uniform(0.05, 0.25)},
        "gain",
        (0.5, 1.7),
        _sensor(("run",)),
        ("run",),
        floor=1.5,
    ),
    "run_differs_offset": Recipe(
        "record (one run)",
        "sensor",
        _others_agree,
        lambda g, c: {"run": _run(g, c), "offset": sign(g) * g.uniform(1.0, 4.0)},
        "offset",
        (0.05, 20.0),
        _sensor(("run",)),
        ("run",),
        floor=1.5,
    ),
    "run_differs_zero": Recipe(
        "record (one run)",
        "sensor",
        _others_agree,
        lambda g, c: {"run": _run(g, c), "zero_mm": sign(g) * c.span_mm * g.uniform(0.03, 0.12)},
        "zero_mm",
        (0.005, 1.0),
        Nature(("drive",), (("run",),), memory=False, rate=False, dissipative=None),
        ("run",),
        floor=1.5,
    ),
    "bending_length_label": Recipe(
        "record (one run)",
        "sensor",
        lambda p: _others_agree(p) and p.lengths >= 2 and p.response != "notch",
        lambda g, c: {"run": _run(g, c), "label_off_mm": sign(g) * g.uniform(2.0, 10.0)},
        "label_off_mm",
        (0.5, 14.0),
        Nature(("structure",), (("run",),), memory=False, rate=False, dissipative=None),
        ("run",),
        floor=1.5,
    ),
    "camera_saturation": Recipe(
        "camera",
        "sensor",
        lambda p: p.response != "notch",
        lambda g, _c: {"lost_share": g.uniform(0.08, 0.35), "soft": g.uniform(0.002, 0.012), "full": 0.0},
        "lost_share",
        (0.03, 0.5),
        _sensor(BEND),
        ("curvature",),
    ),
    "frozen_frames": Recipe(
        "camera",
        "sensor",
        lambda p: p.has("load", "triangle", "cycles", "partial"),
        lambda g, _c: {"bursts": int(g.integers(3, 9)), "share": g.uniform(0.08, 0.3)},
        "share",
        (0.03, 0.5),
        Nature(("sensor",), (("time", "rate"),), memory=True, rate=False, dissipative=None),
        ("time",),
        floor=1.2,
    ),
    "load_cell_scale": Recipe(
        "load cell",
        "sensor",
        lambda p: p.has_tension,
        lambda g, _c: {"scale": 1 + sign(g) * g.uniform(0.06, 0.25), "bow": g.uniform(-0.01, 0.01)},
        "scale",
        (0.6, 1.5),
        Nature(("load cell",), (("tension",),), memory=False, rate=False, dissipative=None),
        ("tension",),
        floor=1.0,
    ),
    "load_cell_offset": Recipe(
        "load cell",
        "sensor",
        lambda p: p.has_tension,
        lambda g, c: {"offset_n": sign(g) * c.tension * g.uniform(0.03, 0.15), "warming": g.uniform(0.0, 0.1)},
        "offset_n",
        (0.001, 5.0),
        Nature(("load cell",), CONSTANT, memory=False, rate=False, dissipative=None),
        ("tension",),
        floor=1.0,
    ),
    "lost_steps": Recipe(
        "actuator",
        "physics",
        lambda p: p.has_time and returns(p),
        _moments,
        "lost_mm",
        (0.003, 1.0),
        Nature(("drive",), (("time", "run"),), memory=True, rate=False, dissipative=None),
        ("time", "run"),
        floor=1.5,
    ),
    "periodic_disturbance": Recipe(
        "environment",
        "physics",
        lambda p: p.has_time,
        lambda g, c: {
            "acts_on": str(g.choice(["drive", "structure", "sensor"])),
            "amplitude": g.uniform(0.02, 0.08),
            "period_s": max(c.duration * g.uniform(0.03, 0.2), 8 * c.dt),
            "phase": g.uniform(0, 1),
            "shape": g.uniform(1.5, 4.0),
            "unevenness": g.uniform(0.0, 0.06),
            "full": 0.0,
        },
        "amplitude",
        (0.002, 0.4),
        Nature(("drive", "structure", "sensor"), (("time",),), memory=False, rate=False, dissipative=None),
        ("time",),
        floor=1.2,
    ),
    "doubled_rows": Recipe(
        "record",
        "sensor",
        lambda _p: True,
        lambda g, _c: {"share": g.uniform(0.1, 0.5)},
        "share",
        (0.1, 0.6),
        _sensor(),
        floor=0.0,
    ),
}

# The name that a right answer gives; a doubled row is a fault of the file, which no physics answers for.
BENCH_NAMES: dict[str, str] = {name: "run_differs" if name.startswith("run_differs") else name for name in BENCH}
