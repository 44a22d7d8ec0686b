"""One page on one effect: what it does, its equation, its signature as a picture, when it shows, what decides, the source."""

from __future__ import annotations

from collections.abc import Iterator
from typing import IO, TYPE_CHECKING, Any

from coast_cli.output.layout import fold
from coast_cli.output.picture import COLOURS, RECORDED, Picture
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.design.signature import Signature
    from coast_cli.effects.effect import Effect

WIDTH = 80
_HEIGHT = 11
_INDENT = "   "
NEEDS = {
    "stroke": "a stroke as the drive",
    "time": "times",
    "release": "release as well as load",
    "hold": "a hold",
    "rates": "two rates",
    "reversals": "reversals inside the loop",
    "pairs": "several pairs",
    "outer": "an outer tube",
    "runs": "several runs",
    "witness": "a second measurement",
    "period": "several periods",
    "load": "the load at the far end",
}
STAGES = {
    "drive": "between motor and tendon",
    "tendon": "in the tendon",
    "transmission": "where the tendon rubs",
    "structure": "in what bends",
    "sensor": "in what is read",
}


def write_effect(effect: type[Effect], found: Signature | None, stream: IO[str], width: int | None) -> None:
    """Write the page.

    Args:
        found: its signature on a joint, where it has one.
        stream, width: where, and how wide; None is 80 columns.
    """
    room = min(width or WIDTH, WIDTH)
    for line in _page(effect, found, room):
        stream.write(f"{line.rstrip()}\n")


def plot_signature(found: Signature) -> Picture:
    """Draw response over stroke without and with the effect."""

    def paint(figure: Any) -> None:  # noqa: ANN401
        axes = figure.add_subplot()
        stroke = found.stroke / MILLIMETRE
        axes.plot(stroke, found.base, color=RECORDED, lw=2.4, label="without")
        axes.plot(stroke, found.changed, color=COLOURS[1], label=f"with {_values(found)}")
        axes.set(xlabel="stroke X1 (mm)", ylabel="curvature (1/m)")
        axes.legend()

    return Picture((4.6, 3.2), paint)


def _page(effect: type[Effect], found: Signature | None, room: int) -> Iterator[str]:
    from coast_cli.effects.effect import declared
    from coast_cli.output.glossary import WHERE

    for number, recording in enumerate(effect.recordings):
        kind = declared(effect, recording)
        if number:
            yield ""
        yield from _said(f"{effect.id}: {kind.title}", room, "")
        where = f"{WHERE[recording]}, {effect.component}; acts {STAGES[effect.stage]}"
        yield from _said(f"{effect.kind} effect of {where}", room)
        yield ""
        yield from _said(kind.equation, room, 2 * _INDENT)
        yield ""
        for name in (parameter for parameter in kind.parameters if parameter.role != "run"):
            yield from _said(f"{name.name}: {name.low:g} to {name.high:g}; {name.source}", room)
        if found is not None and recording == "joint":
            yield ""
            yield from _drawn(found, room)
        yield ""
        needs = ", ".join(NEEDS.get(need, need) for need in kind.needs)
        yield from _said(
            f"Shows in a recording with {needs}." if needs else "Shows in any recording that reaches it.", room
        )
        yield from _said(f"What decides: {kind.decided_by}.", room)
        yield from _said(f"Source: {kind.source}.", room)


def _drawn(found: Signature, room: int) -> Iterator[str]:
    """Yield curvature over stroke as characters: dots without the effect, stars with it."""
    columns = max(room - len(_INDENT) - 2, 10)
    grid = [[" "] * columns for _ in range(_HEIGHT)]
    low, high = min(found.base.min(), found.changed.min()), max(found.base.max(), found.changed.max())
    left, right = found.stroke.min(), found.stroke.max()
    for mark, response in ((".", found.base), ("*", found.changed)):
        for x, y in zip(found.stroke, response, strict=True):
            across = _cell((columns - 1) * (x - left) / (right - left))
            up = _cell((_HEIGHT - 1) * (y - low) / (high - low))
            grid[_HEIGHT - 1 - up][across] = mark
    yield from _said(
        f"Signature: curvature {low:.3g} to {high:.3g} 1/m over stroke {left / MILLIMETRE:.3g} to "
        f"{right / MILLIMETRE:.3g} mm; . without, * with {_values(found)}",
        room,
    )
    for row in grid:
        yield f"{_INDENT}|{''.join(row)}"
    yield f"{_INDENT}+{'-' * columns}"


def _cell(place: float) -> int:
    """Return the cell of a place, the same on every processor where the place lies between two."""
    return round(round(place, 9))


def _values(found: Signature) -> str:
    effect = found.effect
    pairs = zip(effect.parameters, effect.values(), strict=True)
    return (
        ", ".join(f"{p.name} = {value:.3g}" for p, value in pairs if p.role != "run" and value != p.null) or effect.id
    )


def _said(text: str, room: int, indent: str = _INDENT) -> list[str]:
    return [indent + line for line in fold(text, room - len(indent))]
