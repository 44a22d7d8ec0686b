"""The noise of recordings drawn wide: how often its 90 % interval holds the truth, and how far the level is off.

Signals are straight, curved, kinked, looped, creeping and saturating; drives have 20 to 600 samples a branch; noise is
white, coloured, mixed, or as slow as a fifth of a branch; a recording has one of six faults or none. ``python
tests/validation/test_noise_coverage.py 600`` prints the table for more recordings than the test draws.
"""

import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from scipy.signal import lfilter

from coast_cli.recordings.noise import estimate_noise

FAULTS = ("none", "none", "quantum", "outliers", "frozen", "dropped", "clipped")
COLOURS = ("white", "coloured", "slow", "mixed")


def coloured(rng, count, memory):
    return lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], rng.normal(size=count + 4000))[-count:]


def played(drive, width):
    state, states = 0.0, []
    for value in drive:
        state = min(max(state, value - width), value)
        states.append(state)
    return np.array(states)


def drive_of(rng, branch):
    half, parts = np.linspace(0.0, 5.0, branch), []
    for _ in range(rng.integers(1, 4)):
        top = rng.uniform(0.5, 1.0)
        parts += [top * half, top * half[::-1]]
        if rng.random() < 0.3:
            parts.append(np.full(rng.integers(5, 40), parts[-1][-1]))
    drive = np.concatenate(parts)
    return 2.5 * (1.0 - np.cos(np.pi * drive / 5.0)) if rng.random() < 1 / 3 else drive


def signal_of(rng, drive):
    kind = rng.choice(("line", "curve", "knee", "loop", "creep", "saturation"))
    return {
        "line": lambda: 8.0 * drive,
        "curve": lambda: 40.0 * (drive / 5.0) ** 1.5 + 3.0 * np.sin(0.6 * drive),
        "knee": lambda: 8.0 * drive - 5.0 * np.maximum(drive - 2.5, 0.0),
        "loop": lambda: 8.0 * played(drive, rng.uniform(0.1, 1.0)),
        "creep": lambda: 8.0 * drive + 2.0 * (1.0 - np.exp(-3.0 * np.arange(len(drive)) / len(drive))),
        "saturation": lambda: 40.0 * np.tanh(drive / 3.0),
    }[kind]()


def noise_of(rng, colour, count, branch):
    memory, white = {
        "white": lambda: (0.0, 1.0),
        "coloured": lambda: (rng.uniform(0.1, 0.9), 0.0),
        "slow": lambda: (np.exp(-1.0 / max(1.0, rng.uniform(0.05, 0.2) * branch)), 0.0),
        "mixed": lambda: (rng.uniform(0.5, 0.97), rng.uniform(0.2, 0.8)),
    }[colour]()
    return np.sqrt(1.0 - white) * coloured(rng, count, memory) + np.sqrt(white) * rng.normal(size=count)


def spoiled(rng, fault, values, level):
    """Return the recorded response, and the level that an estimate should find."""
    count = len(values)
    if fault == "quantum":
        step = level * rng.uniform(0.3, 4.0)
        return np.round(values / step) * step, np.hypot(level, step / np.sqrt(12.0))
    if fault == "outliers":
        alone = rng.random(count) < rng.uniform(0.002, 0.05)
        values[alone] += level * rng.choice([-1.0, 1.0], alone.sum()) * rng.uniform(8.0, 40.0, alone.sum())
    if fault == "dropped":
        values[rng.random(count) < rng.uniform(0.02, 0.2)] = np.nan
    if fault == "clipped":
        values = np.minimum(values, np.quantile(values, rng.uniform(0.8, 0.97)))
    if fault == "frozen":
        share, at = rng.uniform(0.05, 0.4), 0
        while at < count:
            length = rng.integers(2, 10) if rng.random() < share / 6.0 else 1
            values[at : at + length] = values[at]
            at += length
    return values, level


def tried(seed):
    """Return (colour, fault, level found over true level, whether the interval holds the truth) of one recording."""
    rng = np.random.default_rng([2027, seed])
    branch = int(10.0 ** rng.uniform(1.3, 2.8))
    drive = drive_of(rng, branch)
    level = 40.0 * 10.0 ** rng.uniform(-3.0, -1.5)
    colour, fault = rng.choice(COLOURS), rng.choice(FAULTS)
    values = signal_of(rng, drive) + level * noise_of(rng, colour, len(drive), branch)
    values, level = spoiled(rng, fault, values, level)
    found = estimate_noise(values, drive)
    return str(colour), str(fault), found.level / level, found.interval[0] <= level <= found.interval[1]


def table(rows):
    """Return (name, recordings, coverage, median ratio, RMS of its logarithm) of all, each colour and each fault."""
    groups = {"all": rows}
    groups |= {name: [row for row in rows if name in row[:2]] for name in (*COLOURS, *dict.fromkeys(FAULTS))}
    return {
        name: (
            len(members),
            float(np.mean([row[3] for row in members])),
            float(np.median([row[2] for row in members])),
            float(np.sqrt(np.mean(np.log([row[2] for row in members]) ** 2))),
        )
        for name, members in groups.items()
    }


@pytest.fixture(scope="module")
def measured():
    return table([tried(seed) for seed in range(200)])


def test_the_90_percent_interval_holds_the_truth_about_so_often(measured):
    for name, (count, coverage, median, scatter) in measured.items():
        print(f"{name:9s} {count:4d} recordings: covered {coverage:.3f}, level {median:.2f}, RMS log {scatter:.2f}")
    assert 0.87 <= measured["all"][1] <= 0.98
    assert all(coverage > 0.75 for _, coverage, _, _ in measured.values())


def test_no_fault_moves_the_level(measured):
    assert all(0.8 < measured[fault][2] < 1.2 for fault in FAULTS)
    assert all(measured[fault][3] < 0.5 for fault in FAULTS)


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 600
    with ProcessPoolExecutor(2) as pool:
        for name, (number, coverage, median, scatter) in table(
            list(pool.map(tried, range(count), chunksize=10))
        ).items():
            print(
                f"{name:9s} {number:4d} recordings: covered {coverage:.3f}, level {median:.2f}, RMS log {scatter:.2f}"
            )
