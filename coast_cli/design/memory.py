"""How much memory one command may take: what would need more is refused before it starts."""

from __future__ import annotations

from coast_cli.errors import UsageError

MOST_BYTES = 4 * 2**30
# Bytes a row while it is worked out and written, measured (/usr/bin/time -v) with some to spare.
STROKE_ROW, BEAM_POINT = 400, 900


def require_memory(rows: int, bytes_each: int, what: str) -> None:
    """Refuse what would need more than `MOST_BYTES`.

    Args:
        rows: how many. bytes_each: what one needs. what: the rows in words, e.g. "points".

    Raises:
        UsageError: saying how much it would be and how many rows are allowed.
    """
    if rows * bytes_each > MOST_BYTES:
        raise UsageError(
            f"{rows:.3g} {what} would need about {rows * bytes_each / 2**30:.3g} GB, more than the "
            f"{MOST_BYTES / 2**30:g} GB that a command may take; allowed at once: {MOST_BYTES // bytes_each:.2g} {what}."
        )
