"""Laws without a name of a saved model on recordings: whether these stay inside the range that the laws were seen in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.unnamed.cells import Scene
from coast_cli.effects.seen import outside_note
from coast_cli.effects.unnamed import UnnamedLaw, remember

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem
    from coast_cli.mechanics.section import FloatArray
    from coast_cli.recordings.model import Recordings
    from coast_cli.spec.config import Config


def notes_on_range(config: Config, recordings: Recordings) -> tuple[str, ...]:
    """Return a note for each law of a configuration that recordings take outside the range that it was seen in."""
    from coast_cli.diagnosis.joint.build import build_joint_problem

    if recordings.joint is None or not any(name.startswith("unnamed_") for name in config.corrections):
        return ()
    problem = build_joint_problem(config, recordings.joint.runs)
    laws = [effect for effect in problem.fixed_effects if isinstance(effect, UnnamedLaw)]
    found = problem.predict(problem.configured(), ())
    scene = Scene(problem, [one.response for one in found], [one.tension for one in found])
    notes = (outside_note(law, _remembered(problem, scene, law)) for law in laws)
    return tuple(note for note in notes if note)


def _remembered(problem: JointProblem, scene: Scene, law: UnnamedLaw) -> FloatArray:
    """Return a law's remembered variable at every row of every run and response column."""
    parts = []
    for index in range(len(problem.runs)):
        for column in range(scene.responses[index].shape[1]):
            series = scene.series(law.variable, law.place, law.memory, index, column)
            parts.append(remember(series, scene.histories[index], law.memory, law.setting))
    return np.concatenate(parts)
