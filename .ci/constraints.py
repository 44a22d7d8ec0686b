"""``python .ci/constraints.py lowest|newest``: constraints for pip, so that each end of what is declared is tested.

Lowest pins every dependency of ``pyproject.toml``, extras too, to its lower bound; newest leaves pip free.
"""

import re
import sys
import tomllib
from pathlib import Path


def lowest() -> list[str]:
    """Return ``name==bound`` of each dependency that has a lower bound."""
    project = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = [
        *project["dependencies"],
        *(one for extra in project["optional-dependencies"].values() for one in extra),
    ]
    bounds = (re.fullmatch(r"([\w-]+)(?:\[[\w,]+\])?>=([\w.]+)", one) for one in declared)
    return sorted({f"{bound[1]}=={bound[2]}" for bound in bounds if bound})


if __name__ == "__main__":
    sys.stdout.write("".join(f"{line}\n" for line in (lowest() if sys.argv[1:] == ["lowest"] else [])))
