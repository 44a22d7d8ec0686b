"""What a function of the Python interface was given in place of what it works on: a path, where a file is to be read first."""

from __future__ import annotations

from coast_cli.errors import BadInput
from coast_cli.recordings.model import Recordings
from coast_cli.spec.config import Config


def require_read(config: object, recordings: object) -> None:
    """Refuse a configuration or recordings that are not read yet.

    Raises:
        BadInput: naming the function that reads them.
    """
    for what, value, kind, reader in (
        ("configuration", config, Config, "load_config"),
        ("recordings", recordings, Recordings, "read_recordings"),
    ):
        if not isinstance(value, kind):
            raise BadInput(f"no {what}", found=type(value).__name__, allowed=f"what {reader} returns")
