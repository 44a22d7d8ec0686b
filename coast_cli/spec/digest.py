"""The SHA-256 of a validated configuration: the same for two files that say the same, whatever their comments."""

from __future__ import annotations

import hashlib
import json

from coast_cli.spec.config import Config


def config_digest(config: Config) -> str:
    """Return the SHA-256, in hexadecimal, of the validated document with its keys in order."""
    document = config.model_dump(mode="json", exclude_none=True)
    return hashlib.sha256(json.dumps(document, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
