"""Print how long a frame of five megapixels takes to trace, and the share of the time in each step."""

import cProfile
import pstats
import sys
import time

import numpy as np

from coast_cli.recordings.trace import trace_levels
from tests.rendered_tube import Scene, Tube


def main():
    for width in (12, 60):
        tube = Tube(width, 2200, 1 / 2200, (0, 1500))
        levels = Scene((1944, 2592), (tube,), gradient=(0.3, 0.2), noise=4, blur=1).image().astype(np.float32)
        trace_levels(levels, mm_per_px=0.01)
        wall, cpu = time.perf_counter(), time.process_time()
        trace_levels(levels, mm_per_px=0.01)
        print(
            f"5 megapixels, tube {width} px: {time.perf_counter() - wall:.2f} s wall, {time.process_time() - cpu:.2f} s cpu"
        )
        if "--profile" in sys.argv:
            with cProfile.Profile() as profile:
                trace_levels(levels, mm_per_px=0.01)
            pstats.Stats(profile).sort_stats("cumulative").print_stats(15)


if __name__ == "__main__":
    main()
