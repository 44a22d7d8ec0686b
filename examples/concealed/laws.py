"""All laws by name, and the digest that freezes them."""

from __future__ import annotations

import hashlib
from pathlib import Path

from examples.concealed.laws_bench import BENCH, BENCH_NAMES
from examples.concealed.laws_catalogue import JOINT_EFFECTS, NEAR_TWINS, TWINS
from examples.concealed.laws_outside import FAR, NEAR_SPAN, OUTSIDE
from examples.concealed.recipes import Recipe

RECIPES: dict[str, Recipe] = JOINT_EFFECTS | OUTSIDE | BENCH

# Every file that says what a law is; whoever changes one freezes anew and says why.
FROZEN_FILES = (
    "laws_bench.py",
    "laws_catalogue.py",
    "laws_outside.py",
    "recipes.py",
    "bending.py",
    "camera.py",
    "drive.py",
    "faults.py",
    "friction.py",
    "mechanism.py",
    "segment.py",
    "strand.py",
)


def digest() -> str:
    """Return the SHA-256 of the files that hold the laws, each by name and text."""
    total = hashlib.sha256()
    for name in FROZEN_FILES:
        text = (Path(__file__).parent / name).read_text(encoding="utf-8")
        total.update(f"{name}\n{text}\n".encode())
    return total.hexdigest()


def listing() -> str:
    """Return one Markdown row a law of the levels that leave the catalogue, the near twins, and the digest."""
    lines = ["| level | law | stage | variable | memory | rate | dissipative |", "|---|---|---|---|---|---|---|"]
    groups = (("L6", NEAR_SPAN), ("L6 far", FAR), ("L8", JOINT_EFFECTS), ("L9", BENCH))
    for level, laws in groups:
        for name, recipe in laws.items():
            nature = recipe.nature
            variables = " x ".join("/".join(words) for words in nature.variables) or "(constant)"
            facts = " | ".join({True: "yes", False: "no", None: "-"}[x] for x in _facts(recipe))
            lines.append(f"| {level} | `{name}` | {'/'.join(nature.stages)} | {variables} | {facts} |")
    lines += ["", "Concealed with each law of L8:", ""]
    lines += [f"- `{name}`: {', '.join(twins)}" for name, twins in sorted(NEAR_TWINS.items())]
    return "\n".join([*lines, "", f"digest {digest()}"]) + "\n"


def _facts(recipe: Recipe) -> tuple[bool | None, bool | None, bool | None]:
    return recipe.nature.memory, recipe.nature.rate, recipe.nature.dissipative


__all__ = ["BENCH", "BENCH_NAMES", "FAR", "JOINT_EFFECTS", "NEAR_SPAN", "NEAR_TWINS", "OUTSIDE", "RECIPES", "TWINS"]
