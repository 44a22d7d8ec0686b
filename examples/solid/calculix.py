"""CalculiX: write a mesh and a step as an input file, run `ccx`, read the printed displacements.

Number fields are cut at 20 characters by `ccx`, so every number is written in at most 17.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from mesh import Floats, Integers, Solid


def program() -> str:
    """Find `ccx`."""
    found = shutil.which("ccx")
    if found is None:
        raise SystemExit("CalculiX is not installed: apt install calculix-ccx")
    return found


def version() -> str:
    """Return the name and version that `ccx -v` says, e.g. "CalculiX 2.20"."""
    out = subprocess.run([program(), "-v"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"[Vv]ersion\s+(\S+)", out)
    return f"CalculiX {found.group(1)}" if found else "CalculiX"


def number(value: float) -> str:
    """Write a number in at most 17 characters."""
    return f"{value:.9e}"


def mesh_cards(solid: Solid, extra_nodes: Floats | None = None) -> list[str]:
    """*NODE and *ELEMENT cards, numbers from 1; `extra_nodes` (k, 3) are numbered after the mesh."""
    nodes = solid.nodes if extra_nodes is None else np.vstack([solid.nodes, extra_nodes])
    cards = ["*NODE, NSET=ALL"]
    cards += [f"{i},{number(x)},{number(y)},{number(z)}" for i, (x, y, z) in enumerate(nodes.tolist(), 1)]
    first = 1
    for name, elements in solid.elements.items():
        if len(elements):
            cards.append(f"*ELEMENT, TYPE={name}, ELSET=TUBE")
            cards += [",".join(map(str, [i, *row])) for i, row in enumerate((elements + 1).tolist(), first)]
            first += len(elements)
    # a data line of ccx holds at most 16 entries
    return [line for card in cards for line in _wrapped(card)]


def _wrapped(card: str) -> Iterable[str]:
    parts = card.split(",")
    if card.startswith("*") or len(parts) <= 16:
        return [card]
    return [",".join(parts[:11]) + ",", ",".join(parts[11:])]


def set_card(name: str, nodes: Integers) -> list[str]:
    """Write a node set, from numbers counted from 0."""
    return [f"*NSET, NSET={name}", *(f"{i + 1}," for i in np.asarray(nodes).tolist())]


def run(cards: Iterable[str], *, keep: Path | None = None) -> list[dict[int, Floats]]:
    """Run `ccx` in one thread; the displacements of every *NODE PRINT block in order, node number from 0 to (3,).

    Raises RuntimeError with the last lines of what `ccx` printed when it ends before its last step.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "job.inp").write_text("\n".join(cards) + "\n")
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "CCX_NPROC_EQUATION_SOLVER": "1"}
        done = subprocess.run(
            [program(), "-i", "job"], cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        if "Job finished" not in done.stdout:
            raise RuntimeError("ccx stopped early:\n" + "\n".join(done.stdout.splitlines()[-15:]))
        return _blocks((folder / "job.dat").read_text())


def _blocks(text: str) -> list[dict[int, Floats]]:
    blocks: list[dict[int, Floats]] = []
    for line in text.splitlines():
        if "displacements" in line:
            blocks.append({})
        elif line.strip() and blocks:
            node, *values = line.split()
            blocks[-1][int(node) - 1] = np.array([float(v) for v in values])
    return blocks
