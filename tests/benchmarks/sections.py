"""Superelastic sections and answers: ``python -m tests.benchmarks.sections``.

Processor times. Curves are held against the same curve in plain Python, one strain at a time; answers of the reference input
with superelastic tubes against those with linear ones.
"""

import numpy as np

from coast_cli.mechanics.fibres import Fibres, moment_curvature, strip_fibres
from coast_cli.mechanics.superelastic import Superelastic
from tests.benchmarks.beams import best

LAW = Superelastic(45e9, 25e9, 450e6, 180e6, 0.046, 0.5e9, 1.2)
CURVES, POINTS = 4000, 24


def plain_curve(fibres: Fibres, curvature: list[float]) -> list[float]:
    """One curve by loops and bisection of the neutral axis to 1e-12."""
    layers = list(zip(fibres.area[0].tolist(), fibres.position[0].tolist(), strict=True))
    reach, start = float(fibres.reach[0]), LAW.upper_plateau / LAW.austenite_modulus

    def stress(strain: float) -> float:
        ratio = 1.0 if strain >= 0.0 else LAW.compression_ratio
        size, first, length = abs(strain), ratio * start, LAW.transformation_strain / ratio
        if size <= first:
            return LAW.austenite_modulus * strain
        top = ratio * LAW.upper_plateau + ratio**2 * LAW.plateau_modulus * min(size - first, length)
        return (top + LAW.martensite_modulus * max(size - first - length, 0.0)) * (1.0 if strain > 0.0 else -1.0)

    moments = []
    for kappa in curvature:
        low, high = -abs(kappa) * reach, abs(kappa) * reach
        while high - low > 1e-12:
            centre = 0.5 * (low + high)
            force = sum(area * stress(kappa * arm + centre) for area, arm in layers)
            low, high = (centre, high) if force < 0.0 else (low, centre)
        moments.append(sum(area * arm * stress(kappa * arm + centre) for area, arm in layers) if kappa else 0.0)
    return moments


def main() -> None:
    depth = np.random.default_rng(0).uniform(0.26e-3, 0.42e-3, CURVES)
    kappa = np.linspace(0.0, 800.0, POINTS)
    fibres = strip_fibres(0.25e-3, 0.2e-3, depth)
    many = best(lambda: moment_curvature(fibres, LAW, kappa), 3) / CURVES
    one = strip_fibres(0.25e-3, 0.2e-3, depth[:1])
    plain = best(lambda: plain_curve(one, kappa.tolist()), 2)
    print(f"one moment-curvature curve of {POINTS} points and {fibres.area.shape[-1]} layers, among {CURVES}")
    print(f"  numpy                                       {1e6 * many:8.0f} us, {1.0 / many:.0f} curves/s")
    print(f"  plain Python                                {1e3 * plain:8.1f} ms")
    print(f"  ratio                                       {plain / many:8.0f}")
    answers()


def answers() -> None:
    from coast_cli.design.rank import rank
    from coast_cli.design.stroke import stroke_table
    from coast_cli.design.tolerance import tolerance_rows
    from coast_cli.spec.build import build
    from coast_cli.spec.load import REFERENCE, load_config_text

    text = REFERENCE.read_text(encoding="utf-8")
    table = "martensite_modulus_gpa = 25.0\nupper_plateau_mpa = 300.0\nlower_plateau_mpa = 120.0\n"
    linear, curved = (load_config_text(words) for words in (text, f"{text}\n[materials.nitinol.superelastic]\n{table}"))
    bends = np.linspace(1.0, 60.0, 60).tolist()
    print("answers with superelastic tubes over those with linear ones")
    for name, answer in (
        ("ranked table", rank),
        ("stroke table", lambda config: stroke_table(build(config).joint(), [0.02, 0.04], curvatures=bends)),
        (
            "tolerances, 2,000 samples",
            lambda config: tolerance_rows(
                build(config), ("OT4", "MT1"), samples=2000, seed=0, ranked=False, index_samples=64
            ),
        ),
    ):
        times = [best(lambda config=config: answer(config), 3) for config in (linear, curved)]  # noqa: B023
        print(f"  {name:41}   {times[1] / times[0]:8.2f} ({1e3 * times[0]:.0f} and {1e3 * times[1]:.0f} ms)")


if __name__ == "__main__":
    main()
