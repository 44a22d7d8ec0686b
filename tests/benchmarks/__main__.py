"""``python -m tests.benchmarks [plot.png]``: the table "Accuracy and speed" of the README, measured here and now."""

from tests.benchmarks.beams import main

main()
