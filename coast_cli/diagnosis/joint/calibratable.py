"""Which numbers of a configuration a calibration moves, between which bounds, and which it holds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.diagnosis.joint.problem import CONFIG_KEYS
from coast_cli.errors import BadInput, nearest
from coast_cli.spec.values import Calibrated, Document, Within

if TYPE_CHECKING:
    from coast_cli.spec.config import Config

# In the order in which they are given up where the recordings cannot tell them apart.
HELD_FIRST = (
    "wrap_angle_rad",
    "pulley_friction",
    "tendon_length_mm",
    "tendon_youngs_modulus_gpa",
    "notch_friction",
    "youngs_modulus_gpa",
    "deadband_mm",
    "load_ratio",
    "zero_mm",
    "ratio",
)
USUAL = ("youngs_modulus_gpa", "notch_friction", "deadband_mm", "ratio", "zero_mm")  # each where the device has it
LOGARITHMIC = ("youngs_modulus_gpa", "tendon_youngs_modulus_gpa", "tendon_length_mm")


def _tenth(value: float) -> float:
    return value / 10.0


def _tenfold(value: float) -> float:
    return 10.0 * value


REASON: Mapping[str, tuple[Callable[[float], float], Callable[[float], float]]] = {
    "youngs_modulus_gpa": (_tenth, _tenfold),
    "tendon_youngs_modulus_gpa": (_tenth, _tenfold),
    "tendon_length_mm": (_tenth, _tenfold),
    "notch_friction": (lambda _: 1.0, lambda _: 1.2),
    "pulley_friction": (lambda _: 0.0, lambda _: 2.0),
    "wrap_angle_rad": (lambda _: 0.0, lambda value: value + 2.0 * np.pi),
    "deadband_mm": (lambda _: 0.0, lambda value: value + 20.0),
    **dict.fromkeys(("ratio", "zero_mm", "load_ratio"), (lambda _: -1e6, lambda _: 1e6)),
}


@dataclass(frozen=True)
class Calibratable:
    """A number of the configuration that may be fitted: its value there and its bounds, in the unit of its name.

    ``given``: whether the configuration says the bounds; else they are assumed.
    """

    name: str
    value: float
    low: float
    high: float
    given: bool = True

    @property
    def key(self) -> str:
        """Its dotted key in the configuration."""
        return CONFIG_KEYS[self.name]

    def inner(self, value: float) -> float:
        """Return the coordinate that is fitted: the logarithm of a modulus or a length."""
        return float(np.log(value)) if self.name in LOGARITHMIC else value

    def outer(self, coordinate: float) -> float:
        """Return the value of a coordinate."""
        return float(np.exp(coordinate)) if self.name in LOGARITHMIC else coordinate


def calibratable(
    config: Config, names: Sequence[str] = (), fixed: Mapping[str, float] | None = None
) -> tuple[Calibratable, ...]:
    """Return the parameters to fit: those named, else those the configuration gives bounds, else the usual ones.

    Args:
        fixed: values at which parameters are held, which are then not fitted, in the units of their names.

    Raises:
        BadInput: a name is not a parameter, is both fitted and fixed, a value is out of range, or no table has it.
    """
    fixed = fixed or {}
    for name in (*names, *fixed):
        _check(config, name)
    both = next((name for name in names if name in fixed), None)
    if both is not None:
        raise BadInput("a parameter is to be fitted and fixed at once", found=both, allowed="one of the two")
    for name, value in fixed.items():
        limits = _limits(config, name)
        if not (limits.low <= value <= limits.high and not (limits.above and value == limits.low)):
            raise BadInput(f"{name} cannot be fixed there", found=value, allowed=f"a number {limits.text}")
    bounded = [name for name in CONFIG_KEYS if isinstance(_given(config, name), Calibrated)]
    usual = [name for name in USUAL if _given(config, name) is not None]
    chosen = [name for name in dict.fromkeys(names or bounded or usual) if name not in fixed]
    if not chosen:
        raise BadInput("every parameter is fixed, so none is left to fit", allowed="some of the parameters")
    return tuple(_within_reason(name, *config.bounds(CONFIG_KEYS[name]), given=name in bounded) for name in chosen)


def _check(config: Config, name: str) -> None:
    if name not in CONFIG_KEYS:
        hint = nearest(name, CONFIG_KEYS) or None
        raise BadInput("there is no such parameter to fit", found=name, allowed=", ".join(CONFIG_KEYS), hint=hint)
    if _given(config, name) is None:
        raise config.refuse(tuple(CONFIG_KEYS[name].split(".")), "cannot be fitted: the configuration has none")


def _given(config: Config, name: str) -> object:
    table, key = CONFIG_KEYS[name].split(".")
    return getattr(getattr(config, table), key, None)


def _limits(config: Config, name: str) -> Within:
    table, key = CONFIG_KEYS[name].split(".")
    found: Document = getattr(config, table)
    return next(item for item in type(found).model_fields[key].metadata if isinstance(item, Within))


def _within_reason(name: str, value: float, low: float, high: float, *, given: bool) -> Calibratable:
    """Return a parameter with its given bounds, or with bounds that no device of this kind has exceeded."""
    if not given:
        low, high = max(low, REASON[name][0](value)), min(high, REASON[name][1](value))
    return Calibratable(name, value, low, high, given)


def ranged_elsewhere(config: Config) -> tuple[str, ...]:
    """Return the dotted keys of numbers with a range that strokes and tensions of a joint do not depend on."""
    return tuple(key for key in _ranged(config) if key not in CONFIG_KEYS.values())


def _ranged(document: Any, above: tuple[str, ...] = ()) -> Iterator[str]:  # noqa: ANN401
    """Yield the dotted key of every number that has a range."""
    if isinstance(document, Calibrated):
        yield ".".join(above)
    elif isinstance(document, Mapping):
        for name, value in document.items():
            yield from _ranged(value, (*above, str(name)))
    elif isinstance(document, Document):
        for name in type(document).model_fields:
            yield from _ranged(getattr(document, name), (*above, name))
