"""The laws that leave the catalogue are frozen, and are what is said of them: memory, rate, passivity."""

import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest

from examples.concealed.camera import observe
from examples.concealed.case import make_case
from examples.concealed.design import Joint, Robot, Tube
from examples.concealed.faults import seen_by_camera
from examples.concealed.laws import BENCH, JOINT_EFFECTS, NEAR_SPAN, NEAR_TWINS, OUTSIDE, RECIPES, digest, listing
from examples.concealed.mechanism import simulate
from examples.concealed.recipes import Context

# Whoever changes a law freezes it anew, before the code that it judges is run on it, and says why in the commit.
# A camera that freezes repeats the frame that it measured, noise and all; before, each repeat had noise of its own.
# Last: the load cell's scale is a twin of the cable's compliance, as the tubes' modulus is free; it is concealed with it.
FROZEN = "4c1dfa93355a6b0a82b8bec034d20fb830b7b88e78828ec2aa9f1ae6342b9e2d"

MM = 1e-3
OUTER = Tube("OT4", 0.5 * MM, 0.4 * MM, 0.4 * MM, 0.3 * MM, 0.3 * MM, 188, 1.1)
MIDDLE = Tube("MT1", 0.36 * MM, 0.28 * MM, 0.243 * MM, 0.3 * MM, 0.3 * MM, 125, 2.0)
JOINT = Joint(OUTER, MIDDLE, 42.6e9, 0.2965, np.pi, 1.0063, 1.2 * MM, 0.038 * MM, 53.965e9, 388.68 * MM)
LARGEST = 30.0
CONTEXT = Context(
    JOINT, Robot((OUTER,), (MIDDLE,), JOINT, (0.0, 0.0)), LARGEST, 1.5, 2.0, duration=40.0, dt=0.1, bend=False, runs=1
)
CORNERS = np.array([1.3, 2.3, 1.8, 2.6, 1.3]) * MM
LEG = 80
# Knees inside the range of these loops.
KNEES = {
    "knee_strain": 0.001,
    "knee_tension_n": 0.5,
    "contact_curvature_per_m": 15.0,
    "release_tension_n": 0.18,
    "return_tension_n": 0.12,
}


def respond(name, rate=1.0):
    """Curvature and tension of loops of two heights under one law, with strong, fixed parameters."""
    values = RECIPES[name].draw(np.random.default_rng(4), CONTEXT)
    values |= {key: knee for key, knee in KNEES.items() if key in values}
    values |= {"full": LARGEST} if values.get("full") == 0.0 else {}
    values |= {"run": 0} if "run" in values else {}
    effects = {name: values}
    drive = np.interp(np.linspace(0, 4, 4 * LEG + 1), np.arange(5), CORNERS)
    time = np.linspace(0, 40.0 / rate, drive.size)
    trace = simulate(JOINT, 20 * MM, drive, time, effects, np.random.default_rng(0), largest=LARGEST, run=0)
    seen = observe(trace.theta, trace.weight, trace.length, time, trace.simulated, "curvature", effects)
    return drive, seen_by_camera(seen, time, effects, 0, np.random.default_rng(1))[:, 0], trace.tension


def variables(name):
    return {word for words in RECIPES[name].nature.variables for word in words}


def test_the_laws_are_frozen():
    assert digest() == FROZEN


def test_a_frozen_camera_repeats_what_it_measured():
    case = make_case(969001, "L9", "frozen_frames")
    rows = [line.split(",") for text in case.files.values() for line in text.splitlines()[1:]]
    again = sum(one[-1] == other[-1] != "" and one[0] == other[0] for one, other in pairwise(rows))
    assert again >= 0.04 * len(rows)


def test_the_command_prints_laws_twins_and_digest():
    call = [sys.executable, "-m", "examples.concealed", "laws"]
    assert subprocess.run(call, capture_output=True, text=True, check=True).stdout == listing()
    assert digest() in listing()
    assert all(f"`{name}`" in listing() for name in (*NEAR_SPAN, *BENCH, *JOINT_EFFECTS))


def test_enough_laws_near_the_span_and_none_like_one_of_the_catalogue():
    assert len(NEAR_SPAN) >= 12
    assert not OUTSIDE.keys() & JOINT_EFFECTS.keys()
    assert all(twin in RECIPES for twins in NEAR_TWINS.values() for twin in twins)
    known = {cell(name) for name in JOINT_EFFECTS}
    # The one remembers the largest bend, not a friction; the other is a factor on the stiffness, not a moment.
    assert [name for name in NEAR_SPAN if cell(name) in known] == ["jacket_softening", "stiffness_along"]


def cell(name):
    nature = RECIPES[name].nature
    return nature.stages, nature.variables, nature.memory, nature.rate


JOINT_LAWS = [name for name in RECIPES if name not in ("notch_closure", "doubled_rows")]
TIMELESS = [name for name in JOINT_LAWS if not variables(name) & {"time"}]


@pytest.mark.parametrize("name", TIMELESS)
def test_a_law_depends_on_the_rate_where_it_says_so(name):
    slow, fast = respond(name)[1], respond(name, rate=10.0)[1]
    assert (np.abs(slow - fast).max() > 1e-3 * LARGEST) == RECIPES[name].nature.rate


@pytest.mark.parametrize("name", [name for name in TIMELESS if not RECIPES[name].nature.rate])
def test_a_law_remembers_where_it_says_so(name):
    # The first loading from rest is left out: a stage that has settled repeats itself on every leg, or it remembers.
    drive, seen, tension = respond(name)
    legs = [slice(k * LEG, (k + 1) * LEG + 1) for k in range(4)]
    common = np.linspace(1.85, 2.25, 9) * MM
    on = [np.array([np.interp(common, *order(drive[leg], column[leg])) for column in (seen, tension)]) for leg in legs]
    spread = max(float(np.abs((leg - on[0]) / on[0].max(axis=1, keepdims=True)).max()) for leg in on)
    assert (spread > 2e-3) == RECIPES[name].nature.memory


def order(x, y):
    return (x, y) if x[-1] > x[0] else (x[::-1], y[::-1])


@pytest.mark.parametrize("name", [name for name in JOINT_LAWS if RECIPES[name].nature.dissipative is not None])
def test_no_law_of_the_mechanism_gives_energy_away(name):
    drive, _, tension = respond(name)
    # The loop closes in stroke: work put in is what was lost, but for what a memory still stores at the end.
    work = float(np.sum((tension[1:] + tension[:-1]) / 2 * np.diff(drive)))
    stored = float(tension.max() * np.ptp(drive))
    if RECIPES[name].nature.dissipative:
        assert work > 1e-4 * stored
    else:
        assert abs(work) < 2e-2 * stored
