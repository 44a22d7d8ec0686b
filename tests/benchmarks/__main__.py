"""``python -m tests.benchmarks [plot.png]``: the table of `coast guide accuracy`, measured here and now."""

from tests.benchmarks.beams import main

main()
