"""Design and test of the COAST guidewire robot: two notched nitinol tubes, one inside the other, bent by one tendon.

From Python, ``coast_cli`` has the functions that the commands call. Nothing is loaded before its name is used.
"""

from __future__ import annotations

from coast_cli.version import __version__ as __version__

TYPE_CHECKING = False  # typing itself takes longer to load than all else here
if TYPE_CHECKING:
    from coast_cli.design.checks import check_design as check_design
    from coast_cli.design.exploration import Exploration as Exploration
    from coast_cli.design.exploration import explore as explore
    from coast_cli.design.joint_state import JointState as JointState
    from coast_cli.design.joint_state import JointStep as JointStep
    from coast_cli.design.path import PathPlan as PathPlan
    from coast_cli.design.path import plan_path as plan_path
    from coast_cli.design.rank import Ranking as Ranking
    from coast_cli.design.rank import RankOptions as RankOptions
    from coast_cli.design.rank import rank as rank
    from coast_cli.design.sensitivity import sensitivity_rows as sensitivity_rows
    from coast_cli.design.stroke import StrokeTable as StrokeTable
    from coast_cli.design.stroke import stroke_table as stroke_table
    from coast_cli.design.tolerance import tolerance_rows as tolerance_rows
    from coast_cli.diagnosis.answer import Diagnosis as Diagnosis
    from coast_cli.diagnosis.compare import Comparison as Comparison
    from coast_cli.diagnosis.compare import compare as compare
    from coast_cli.diagnosis.joint.calibration import Calibration as Calibration
    from coast_cli.diagnosis.joint.calibration import calibrate as calibrate
    from coast_cli.diagnosis.joint.planning import Plan as Plan
    from coast_cli.diagnosis.joint.planning import plan as plan
    from coast_cli.diagnosis.joint.planning import sweep as sweep
    from coast_cli.diagnosis.model_file import model_text as model_text
    from coast_cli.diagnosis.recorded import diagnose as diagnose
    from coast_cli.diagnosis.recorded_answer import RecordedDiagnosis as RecordedDiagnosis
    from coast_cli.errors import (
        BadInput as BadInput,
    )
    from coast_cli.errors import (
        CoastError as CoastError,
    )
    from coast_cli.errors import (
        NotConverged as NotConverged,
    )
    from coast_cli.errors import (
        UsageError as UsageError,
    )
    from coast_cli.mechanics.beam import (
        BeamSolution as BeamSolution,
    )
    from coast_cli.mechanics.beam import (
        BeamSolutions as BeamSolutions,
    )
    from coast_cli.mechanics.beam import (
        BeamTips as BeamTips,
    )
    from coast_cli.mechanics.beam import (
        solve_beam as solve_beam,
    )
    from coast_cli.mechanics.beam import (
        solve_segments as solve_segments,
    )
    from coast_cli.mechanics.beam import (
        solve_tips as solve_tips,
    )
    from coast_cli.mechanics.joint import (
        Joint as Joint,
    )
    from coast_cli.mechanics.joint import (
        StrokeSolution as StrokeSolution,
    )
    from coast_cli.mechanics.joint import (
        curvature_from_stroke as curvature_from_stroke,
    )
    from coast_cli.mechanics.joint import (
        stroke as stroke,
    )
    from coast_cli.mechanics.joint import (
        tip as tip,
    )
    from coast_cli.mechanics.pairs import PairTable as PairTable
    from coast_cli.mechanics.pairs import pair_table as pair_table
    from coast_cli.mechanics.section import notched_section as notched_section
    from coast_cli.mechanics.tube import NotchedTube as NotchedTube
    from coast_cli.output.report import report as report
    from coast_cli.recordings.mapping import load_mapping as load_mapping
    from coast_cli.recordings.model import JointRun as JointRun
    from coast_cli.recordings.model import Recordings as Recordings
    from coast_cli.recordings.model import ShapeRun as ShapeRun
    from coast_cli.recordings.noise import NoiseEstimate as NoiseEstimate
    from coast_cli.recordings.noise import estimate_noise as estimate_noise
    from coast_cli.recordings.planar_path import PlanarPath as PlanarPath
    from coast_cli.recordings.planar_path import path_of_curvature as path_of_curvature
    from coast_cli.recordings.planar_path import read_path as read_path
    from coast_cli.recordings.read import read_recordings as read_recordings
    from coast_cli.spec.build import Design as Design
    from coast_cli.spec.build import build as build
    from coast_cli.spec.config import Config as Config
    from coast_cli.spec.load import (
        REFERENCE as REFERENCE,
    )
    from coast_cli.spec.load import (
        load_config as load_config,
    )
    from coast_cli.spec.load import (
        load_config_text as load_config_text,
    )

_PUBLIC = {
    "design.checks": ("check_design",),
    "design.exploration": ("Exploration", "explore"),
    "design.joint_state": ("JointState", "JointStep"),
    "design.path": ("PathPlan", "plan_path"),
    "design.rank": ("RankOptions", "Ranking", "rank"),
    "design.sensitivity": ("sensitivity_rows",),
    "design.stroke": ("StrokeTable", "stroke_table"),
    "design.tolerance": ("tolerance_rows",),
    "diagnosis.answer": ("Diagnosis",),
    "diagnosis.joint.calibration": ("Calibration", "calibrate"),
    "diagnosis.joint.planning": ("Plan", "plan", "sweep"),
    "diagnosis.compare": ("Comparison", "compare"),
    "diagnosis.model_file": ("model_text",),
    "diagnosis.recorded": ("diagnose",),
    "diagnosis.recorded_answer": ("RecordedDiagnosis",),
    "errors": ("BadInput", "CoastError", "NotConverged", "UsageError"),
    "mechanics.beam": ("BeamSolution", "BeamSolutions", "BeamTips", "solve_beam", "solve_segments", "solve_tips"),
    "mechanics.joint": ("Joint", "StrokeSolution", "curvature_from_stroke", "stroke", "tip"),
    "mechanics.pairs": ("PairTable", "pair_table"),
    "mechanics.section": ("notched_section",),
    "mechanics.tube": ("NotchedTube",),
    "output.report": ("report",),
    "recordings.mapping": ("load_mapping",),
    "recordings.model": ("JointRun", "Recordings", "ShapeRun"),
    "recordings.noise": ("NoiseEstimate", "estimate_noise"),
    "recordings.planar_path": ("PlanarPath", "path_of_curvature", "read_path"),
    "recordings.read": ("read_recordings",),
    "spec.build": ("Design", "build"),
    "spec.config": ("Config",),
    "spec.load": ("REFERENCE", "load_config", "load_config_text"),
}
_HOME = {name: f"{__name__}.{module}" for module, names in _PUBLIC.items() for name in names}


def __getattr__(name: str) -> object:
    """Load a public name from the module that defines it."""
    from importlib import import_module

    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*_HOME, "__version__"])
