"""Where an answer comes from: versions, digests of the inputs, options and seed. No clock: same input, same bytes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from coast_cli.effects.own import SOURCES
from coast_cli.version import __version__

if TYPE_CHECKING:
    from coast_cli.spec.config import Config


def provenance(
    *configs: Config,
    recordings: Iterable[tuple[str, str]] = (),
    options: Mapping[str, Any] | None = None,
    seed: int | None = None,
) -> dict[str, Any]:
    """Return the provenance of an answer.

    Args:
        configs: validated configurations; each gives the SHA-256 of what it says.
        recordings: (path, SHA-256) of each recording.
        options: the options that shaped the answer.
        seed: of the random numbers, where there were any.
    """
    import platform
    from importlib.metadata import version

    origin: dict[str, Any] = {
        "versions": {
            "coast": __version__,
            "python": platform.python_version(),
            **{name: version(name) for name in ("numpy", "scipy")},
        }
    }
    if configs:
        from coast_cli.spec.digest import config_digest

        origin["configs"] = [_config(config.source, config_digest(config)) for config in configs]
    known = [{"file": path, "sha256": digest} for path, digest in recordings]
    if known:
        origin["recordings"] = known
    if SOURCES:
        origin["effects"] = [{"file": path, "sha256": digest} for path, digest in SOURCES]
    if options:
        origin["options"] = dict(options)
    if seed is not None:
        origin["seed"] = seed
    return origin


def _config(file: str, digest: str) -> dict[str, Any]:
    """Return what a configuration was: its file, the values that stood for those in it, and its digest."""
    from coast_cli.spec.changes import changes_of

    changes = list(changes_of(file))
    return {"file": file, **({"set": changes} if changes else {}), "sha256": digest}
