"""What is fuzzed of other people's files: mappings, foreign tables and MATLAB files, by the standard library and scipy."""

import random
from io import BytesIO
from pathlib import Path

from tests.fuzz.targets import JSON, RECORDING, Target, mutate_csv, mutate_toml

FILE = Path(__file__).with_name("foreign.csv")
FOREIGN = FILE.read_text(encoding="utf-8")
MAPPINGS = (
    '[columns]\nstroke_mm = { from = "motor_deg", scale = 0.1, offset = 3.0 }\nbend_deg = "jaw_deg"\n',
    (
        '[columns]\ntime_s = "t_s"\nstroke_mm = { from = "motor_deg", scale = 0.1 }\n'
        'bend_deg = { from = "jaw_deg", scale = -1 }\nload_n_m = "torque_n_m"\nrun = ["wrist", "trial"]\n'
        '[rows]\nskip = 0\ncomment = "%"\nwhere = { t_s = { min = 0.5 } }\n'
    ),
    (
        '[columns]\nstroke_mm = { from = "motor_deg", scale = 1 }\nposition_mm = { from = "jaw_deg", scale = 1 }\n'
        'load_n = { file = "{}" }\nrun = { file = "*{}" }\nmiddle = { constant = "MT1" }\nbending_length_mm = { constant = 20 }\n'
    ),
    (
        '[columns]\ntension_n = { from = "b" , scale = 1 }\nforce_n = { from = "c", scale = 2 }\n[rows]\n'
        'skip = 1\nunits_row = true\nnames = ["a", "b", "c", "d", "e", "f"]\n[rows.where]\ne = [0, "1"]\n'
    ),
)


def _mapping_seeds() -> list[bytes]:
    return [text.encode() for text in MAPPINGS]


def _foreign_seeds() -> list[bytes]:
    plain = FOREIGN.encode()
    units = FOREIGN.replace("\n0.0", "\ns,deg,deg,-,-,N m\n0.0").encode()
    headed = b"% a rig\n%\n" + plain
    spaced, decimal = plain.replace(b",", b"  "), plain.replace(b",", b";").replace(b".", b",")
    return [plain, units, headed, spaced, decimal, plain.partition(b"\n")[2], RECORDING.read_bytes()[:4000]]


def _mat_seeds() -> list[bytes]:
    import numpy as np
    from scipy.io import savemat

    drive = np.concatenate((np.linspace(0.0, 4.0, 20), np.linspace(4.0, 0.0, 20)))
    variables = {
        "stroke_mm": drive,
        "bend_deg": 8.0 * drive,
        "log": {"tip": drive, "name": "monday"},
        "data": np.column_stack((drive, drive)),
        "cells": np.array([drive, "a"], dtype=object),
        "whole": np.arange(40, dtype=np.int16),
        "many": drive + 1j,
    }
    seeds = []
    for options in ({}, {"do_compression": True}, {"oned_as": "column"}):
        stream = BytesIO()
        savemat(stream, variables, **options)
        seeds.append(stream.getvalue())
    stream = BytesIO()
    savemat(stream, {"stroke_mm": drive, "bend_deg": 8.0 * drive}, format="4")
    return [*seeds, stream.getvalue()]


def mutate_bytes(data: bytes, chance: random.Random) -> bytes:
    """Change, repeat, remove and insert bytes, more often near the head of an element, where lengths and types stand."""
    found = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 4, 16))):
        if not found:
            break
        at = chance.randrange(len(found))
        if chance.random() < 0.6:
            at = min(8 * chance.randrange(max(len(found) // 8, 1)) + chance.randrange(8), len(found) - 1)
        kind = chance.randrange(6)
        if kind == 0:
            found[at] ^= 1 << chance.randrange(8)
        elif kind == 1:
            found[at] = chance.choice((0, 1, 7, 14, 15, 127, 128, 255))
        elif kind == 2:
            del found[at : at + chance.choice((1, 4, 8, 64))]
        elif kind == 3:
            found[at:at] = bytes(chance.randrange(256) for _ in range(chance.choice((1, 4, 8))))
        elif kind == 4:
            found[at : at + 4] = chance.choice((0, 1, 2**16, 2**31 - 1, 2**32 - 1)).to_bytes(4, "little")
        else:
            other = chance.randrange(len(found))
            found[at : at + 16] = found[other : other + 16]
    return bytes(found)


TARGETS = {
    "mapping": Target(
        ".toml",
        (
            ("recordings", str(FILE), "--columns", "{file}", *JSON),
            ("recordings", str(FILE), "--columns", "{file}", "--noise", "0.1", *JSON),
        ),
        _mapping_seeds,
        mutate_toml,
    ),
    "foreign": Target(
        ".csv",
        (
            ("recordings", "{file}", "--suggest"),
            ("recordings", "{file}", "--columns", "stroke_mm=x,bend_deg=jaw_deg", *JSON),
            ("recordings", "{file}", "--convert", "/dev/null"),
        ),
        _foreign_seeds,
        mutate_csv,
    ),
    "mat": Target(
        ".mat",
        (("recordings", "{file}", *JSON), ("recordings", "{file}", "--suggest")),
        _mat_seeds,
        mutate_bytes,
    ),
}
