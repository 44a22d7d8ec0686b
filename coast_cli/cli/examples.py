"""What help shows of each command: lines that run as they stand from the top of the checkout."""

from __future__ import annotations

_CONFIG = "configs/tubes.toml"
_RECORDING = "examples/diagnose/recording.csv"

EXAMPLES: dict[str, tuple[str, ...]] = {
    "rank-pairs": (f"{_CONFIG}", f"{_CONFIG} --rigidity series --top 3", f"{_CONFIG} --sort -margin -o ranking.csv"),
    "explore": ("examples/explore.toml --top 10 --all pairs.csv",),
    "design": (f"{_CONFIG} --target rigidity_ratio_series=2.5 --vary outer.depth_mm --save designed.toml",),
    "snap": (f"{_CONFIG}", f"{_CONFIG} --x2 30 --sort margin"),
    "stroke": (f"{_CONFIG} --kappa 0:40:10 --x2 20,40", f"{_CONFIG} --stroke 2.5 --x2 30 --pair OT3/MT1"),
    "path": (f"{_CONFIG} --path examples/path/branch.csv",),
    "beam": (f"{_CONFIG} --tube MT3 --points 6",),
    "pattern": (f"{_CONFIG} --tube OT4 --kerf 0.02 -o OT4.dxf",),
    "sensitivity": (f"{_CONFIG} --sort -change_percent --top 10",),
    "check": (f"{_CONFIG}", f"{_CONFIG} --set joint.pair=OT3/MT1", f"{_CONFIG} --format github -o report.xml"),
    "tolerance": (f"{_CONFIG} --samples 2000 --only check,first",),
    "trace": ("frame.png --scale 0.0227 --clamp 161,1050 --tube OT4 -o shape.csv --overlay look.png",),
    "recordings": (f"{_RECORDING} --config {_CONFIG}",),
    "calibrate": (f"{_CONFIG} {_RECORDING} --fit youngs_modulus_gpa,deadband_mm -o calibrated.toml",),
    "compare": (f"{_CONFIG} {_RECORDING}",),
    "diagnose": (f"{_CONFIG} {_RECORDING}", f"{_CONFIG} {_RECORDING} --save-model corrected.toml --report page.html"),
    "plan": (f"{_CONFIG} --drive 0.9:3 --x2 20",),
    "report": (f"{_CONFIG} {_RECORDING} -o report.html",),
    "validate": (f"{_CONFIG}",),
    "init": ("bench.toml", "-"),
    "schema": ("-o tubes.schema.json",),
    "explain": ("backlash", "joint", "stroke_mm", "--top 20"),
    "effects": ("", "--show effect,title"),
    "guide": ("", "diagnose"),
}


def epilog(command: str) -> str:
    """Return the examples of a command as its help ends with them."""
    lines = "\n".join(f"  coast {command} {words}".rstrip() for words in EXAMPLES[command])
    return f"\b\nExamples:\n{lines}"
