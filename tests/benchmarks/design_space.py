"""Speed of tolerance runs and explorations, all in one run: ``python tests/benchmarks/design_space.py [--large]``.

Processor times, so that other work on the machine counts little; ``--large`` adds a million pairs. Nothing is asserted.
"""

import resource
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from coast_cli.design.exploration import explore  # noqa: E402
from coast_cli.design.samples import make_pair  # noqa: E402
from coast_cli.design.tolerance import tolerance_rows  # noqa: E402
from coast_cli.design.variation import variation  # noqa: E402
from coast_cli.mechanics.pairs import pair_table  # noqa: E402
from coast_cli.output.stream import CsvStream  # noqa: E402
from coast_cli.spec.build import build  # noqa: E402
from coast_cli.spec.load import load_config, load_config_text  # noqa: E402

RANGES = """
[explore]
tubes = {tubes}
refinements = 0
[explore.outer]
depth_mm = {{ min = 0.314, max = 0.400 }}
[explore.middle]
depth_mm = {{ min = 0.243, max = 0.287 }}
"""
CUTS = "cut_mm = { min = 0.2, max = 0.4 }\n"
STEPPED = CUTS.replace(" }", ", step = 0.05 }")


def timed(function):
    start = time.process_time()
    value = function()
    return time.process_time() - start, value


def tolerances(design) -> None:
    tubes = design.tube("OT4"), design.tube("MT1")
    varied = variation(design.config, tubes)
    draws = np.random.default_rng(0).random((10_000, len(varied.inputs)))
    took, made = timed(lambda: make_pair(design, varied, tubes, draws))
    one, _ = timed(lambda: [pair_table(tubes[:1], tubes[1:], design.gravity) for _ in range(20)])
    speed = f"{10_000 / took:.0f} pairs/s, {20_000 / took:.0f} tubes/s"
    print(f"10,000 samples of one pair                    {took:8.2f} s, {speed}")
    print(f"  one pair at a time over that                {one / 20 * 10_000 / took:8.1f}")
    print(
        f"  samples solved                              {np.isfinite(made.columns['total_precurvature_rad']).sum():8d}"
    )
    took, _ = timed(lambda: tolerance_rows(design, ("OT4", "MT1"), samples=10_000, seed=0))
    print(f"the whole command: ranking and Sobol indices  {took:8.2f} s")


def exploration(name: str, tubes: int, cuts: str, *, stream: bool) -> None:
    reference = (ROOT / "configs" / "tubes.toml").read_text(encoding="utf-8")
    table = RANGES.format(tubes=tubes).replace("[explore.middle]\n", f"{cuts}[explore.middle]\n{cuts}")
    text = reference + table
    config = load_config_text(text)
    with TemporaryDirectory() as folder:
        file = CsvStream(Path(folder) / "pairs.csv", "", overwrite=False) if stream else None
        save = None if file is None else file.write
        took, _ = timed(lambda: explore(config, save=save, every=stream))
        if file is not None:
            file.finish()
            size = file.path.stat().st_size / 1e6
            name = f"{name}, {size:.0f} MB of CSV"
    pairs = tubes * tubes
    print(f"{name:<45} {took:8.2f} s, {pairs / took:.0f} pairs/s")


def main() -> None:
    tolerances(build(load_config(ROOT / "configs" / "tubes.toml")))
    exploration("256 x 256 tubes of one pattern", 256, "", stream=False)
    exploration("128 x 128 tubes, each its own pattern", 128, CUTS, stream=False)
    exploration("256 x 256 tubes, cuts of 0.05 mm steps", 256, STEPPED, stream=False)
    exploration("256 x 256 tubes", 256, "", stream=True)
    if "--large" in sys.argv:
        exploration("1,000 x 1,000 tubes of one pattern", 1000, "", stream=False)
        exploration("1,000 x 1,000 tubes, each its own pattern", 1000, CUTS, stream=False)
        exploration("1,000 x 1,000 tubes, cuts of 0.05 mm steps", 1000, STEPPED, stream=False)
        exploration("1,000 x 1,000 tubes", 1000, "", stream=True)
    print(
        f"most memory                                   {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:8.0f} MB"
    )


if __name__ == "__main__":
    main()
