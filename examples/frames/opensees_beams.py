"""Solve the reference tubes with OpenSees (corotational frame elements) and write tips and times as CSV to stdout.

Needs openseespy (PyPI) beside this project: python examples/frames/opensees_beams.py > opensees_beams.csv
"""

import time

import numpy as np
import openseespy.opensees as ops
from reference_tubes import NATURAL_CURVATURES, FrameModel, frame_model

LOAD_STEPS = (10, 20, 50, 100, 200)  # the fewest that converge are the ones timed
AXIAL = 1e3  # N, over loads of 1e-4 N: an inextensible beam to 1e-7


def solve(model: FrameModel, load_steps: int) -> tuple[float, float, float] | None:
    """Return tip x, y (m) and tip angle less the natural one (rad); None where Newton's method fails."""
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for node, (x, y) in enumerate(zip(model.x, model.y, strict=True)):
        ops.node(node, float(x), float(y))
    ops.fix(0, 1, 1, 1)
    ops.geomTransf("Corotational", 1)
    lengths = np.hypot(np.diff(model.x), np.diff(model.y))
    force = np.zeros(model.x.size)
    for element, rigidity in enumerate(model.rigidity):
        ops.element("elasticBeamColumn", element, element, element + 1, AXIAL, 1.0, float(rigidity), 1)
        force[element : element + 2] += model.weight[element] * lengths[element] / 2.0
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    for node in range(1, model.x.size):
        ops.load(node, 0.0, -float(force[node]), 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-11, 100)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / load_steps)
    ops.analysis("Static")
    if ops.analyze(load_steps) != 0:
        return None
    tip = model.x.size - 1
    return float(model.x[-1]) + ops.nodeDisp(tip, 1), float(model.y[-1]) + ops.nodeDisp(tip, 2), ops.nodeDisp(tip, 3)


def main() -> None:
    """Solve every tube at three finenesses."""
    print("natural_curvature_per_m,elements_per_piece,load_steps,tip_x_m,tip_y_m,tip_angle_rad,seconds")
    for curvature in NATURAL_CURVATURES:
        for parts in (1, 2, 4):
            frame = frame_model(curvature, parts)
            for steps in LOAD_STEPS:
                start = time.process_time()
                found = solve(frame, steps)
                seconds = time.process_time() - start
                if found is not None:
                    tip_x, tip_y, turn = found
                    angle = turn + curvature * 0.1128
                    print(f"{curvature},{parts},{steps},{tip_x:.15g},{tip_y:.15g},{angle:.15g},{seconds:.3f}")
                    break


if __name__ == "__main__":
    main()
