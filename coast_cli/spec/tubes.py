"""Samples merged with their stock, and the geometry every configuration must have: notches, walls, nesting, fits."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from coast_cli.errors import BadInput, nearest
from coast_cli.spec.config import FATIGUE_CYCLES, Config, Notch, RatioLimits, Sample, Stock
from coast_cli.spec.positions import Path
from coast_cli.spec.superelastic import check_superelastic
from coast_cli.spec.transmission import check_transmission, is_transmission
from coast_cli.spec.values import Calibrated

Role = Literal["outer", "middle"]
MISSING = "a required key is missing"
MOST_NOTCHES = 2_000_000  # of all samples of a stock


@dataclass(frozen=True)
class BenchTube:
    """One sample with every field it takes from its stock: lengths in mm, one depth, cut and uncut for each notch."""

    role: Role
    name: str
    material: str
    outer_diameter_mm: float
    inner_diameter_mm: float
    cut_mm: float
    uncut_mm: float
    count: int
    depth_mm: tuple[float, ...]
    natural_curvature_per_m: float
    section: Literal["sector", "chord"]
    end_effect: Literal["none", "table"] | tuple[float, ...]


def bench_tubes(config: Config, role: Role) -> tuple[BenchTube, ...]:
    """Return the samples of a stock, each merged with it and checked; empty where the config has no such stock."""
    stock: Stock | None = getattr(config, role)
    if stock is None:
        return ()
    return tuple(_Merge(config, role, stock, index, sample).tube() for index, sample in enumerate(stock.samples))


def check_tubes(config: Config) -> None:
    """Check what one table cannot see of another.

    Raises:
        BadInput: placed at the offending key.
    """
    for rule in rules(config):
        rule.check()


@dataclass(frozen=True)
class Rule:
    """One thing that a document must keep to; ``check`` raises BadInput where it does not.

    Attributes:
        check: what raises.
        of_all: it looks at every tube, so it says nothing of a document in which one tube is wrong by itself.
    """

    check: Callable[[], object]
    of_all: bool = False


def rules(config: Config) -> Iterator[Rule]:
    """Yield what is checked, in the order in which it is told."""
    if is_transmission(config):
        yield Rule(partial(check_transmission, config))
        yield Rule(partial(_check_corrections, config))
        yield Rule(partial(_check_fitted, config))
        return
    yield Rule(partial(_check_materials, config))
    yield Rule(partial(_check_any_tube, config))
    yield Rule(partial(check_superelastic, config))
    yield Rule(partial(_check_names, config))
    yield Rule(partial(_check_size, config))
    roles: tuple[Role, ...] = ("outer", "middle")
    for role in roles:
        stock: Stock | None = getattr(config, role)
        if stock is not None:
            yield from (Rule(_Merge(config, role, stock, *each).tube) for each in enumerate(stock.samples))
    yield Rule(partial(_check_fits, config), of_all=True)
    yield Rule(partial(_check_assembly, config), of_all=True)
    yield Rule(partial(_check_pair, config))
    yield Rule(partial(_check_limits, config))
    yield Rule(partial(_check_corrections, config))
    yield Rule(partial(_check_fitted, config))


def _check_materials(config: Config) -> None:
    if not config.materials:
        raise config.refuse(("materials",), MISSING)


def _check_any_tube(config: Config) -> None:
    if config.outer is None and config.middle is None:
        raise config.refuse((), "there is no tube", allowed="an [outer] table, a [middle] table or both")


def _check_assembly(config: Config) -> None:
    outer, middle = bench_tubes(config, "outer"), bench_tubes(config, "middle")
    if not (outer and middle):
        return
    widest = max(outer, key=lambda tube: tube.inner_diameter_mm)
    if all(assembly_fault(config, widest, one) for one in middle):
        reason = assembly_fault(config, outer[0], middle[0])
        raise config.refuse(("middle", "outer_diameter_mm"), f"no pair can be assembled: {reason}")


def _check_pair(config: Config) -> None:
    if config.joint is not None and config.joint.pair is not None:
        pair_names(config, config.joint.pair)


def assembly_fault(config: Config, outer: BenchTube | None, middle: BenchTube) -> str | None:
    """Return why a pair cannot be put together, or None where it can."""
    if outer is not None and middle.outer_diameter_mm >= outer.inner_diameter_mm:
        return (
            f"{middle.name} ({middle.outer_diameter_mm:g} mm outside) does not go into "
            f"{outer.name} ({outer.inner_diameter_mm:g} mm inside)"
        )
    if config.inner is not None and config.inner.outer_diameter_mm >= middle.inner_diameter_mm:
        return (
            f"the inner tube ({config.inner.outer_diameter_mm:g} mm outside) does not go into "
            f"{middle.name} ({middle.inner_diameter_mm:g} mm inside)"
        )
    return None


def pair_names(config: Config, pair: str, *, path: Path = ("joint", "pair")) -> tuple[str | None, str]:
    """Return (outer or None, middle) of a pair written ``OUTER/MIDDLE``, or of one tube written alone.

    Raises:
        BadInput: a name that the configuration does not have.
    """
    parts = pair.split("/")
    roles: tuple[Role, ...] = ("middle",) if len(parts) == 1 else ("outer", "middle")
    if len(parts) > len(roles):
        raise config.refuse(path, "more than two tubes", found=pair, allowed="'OUTER/MIDDLE', or one middle tube")
    for name, role in zip(parts, roles, strict=True):
        stock: Stock | None = getattr(config, role)
        names = [sample.name for sample in stock.samples] if stock else []
        if name not in names:
            allowed = ", ".join(names) if names else f"none, since there is no [{role}]"
            if len(parts) == 1 and config.outer is not None:
                allowed = f"'OUTER/MIDDLE', or one of {allowed}"
            raise config.refuse(
                path, f"there is no {role} tube of that name", found=name, allowed=allowed, hint=nearest(name, names)
            )
    return (None, parts[0]) if len(parts) == 1 else (parts[0], parts[1])


@dataclass(frozen=True)
class _Merge:
    """One sample on its way to a ``BenchTube``; knows where each of its fields was written."""

    config: Config
    role: Role
    stock: Stock
    index: int
    sample: Sample

    def tube(self) -> BenchTube:
        count = self._notch("count")
        tube = BenchTube(
            role=self.role,
            name=self.sample.name,
            material=self._material(),
            outer_diameter_mm=self._required("outer_diameter_mm"),
            inner_diameter_mm=self._required("inner_diameter_mm"),
            cut_mm=self._notch("cut_mm"),
            uncut_mm=self._notch("uncut_mm"),
            count=count,
            depth_mm=self._each_notch("depth_mm", self._required("depth_mm"), count),
            natural_curvature_per_m=self._value("natural_curvature_per_m") or 0.0,
            section=self._value("section") or "sector",
            end_effect=self._end_effect(count),
        )
        self._check(tube)
        return tube

    def _check(self, tube: BenchTube) -> None:
        outer, inner = tube.outer_diameter_mm, tube.inner_diameter_mm
        if inner >= outer:
            raise self._refuse("inner_diameter_mm", "no wall is left", inner, f"below the outer diameter, {outer:g}")
        for depth in tube.depth_mm:
            if not outer / 2.0 <= depth < outer:
                allowed = f"from the outer radius, {outer / 2.0:g}, to below the outer diameter, {outer:g}"
                raise self._refuse("depth_mm", f"the notch of {tube.name} is not one that bends", depth, allowed)

    def _material(self) -> str:
        name: str = self._required("material")
        known = list(self.config.materials)
        if name not in known:
            raise self._refuse("material", "there is no such material", name, ", ".join(known), nearest(name, known))
        return name

    def _end_effect(self, count: int) -> Literal["none", "table"] | tuple[float, ...]:
        choice = self._value("end_effect")
        if choice in {None, "none", "table"}:
            return choice or "none"
        return self._each_notch("end_effect", choice, count)

    def _each_notch(self, field: str, value: float | tuple[float, ...], count: int) -> tuple[float, ...]:
        if not isinstance(value, tuple):
            return (value,) * count
        if len(value) != count:
            found = f"{len(value)} values"
            raise self._refuse(field, "a list has one value for each notch", found, f"{count} values, clamp to tip")
        return value

    def _notch(self, key: str) -> Any:  # noqa: ANN401
        own, shared = self.sample.notch or Notch(), self.stock.notch or Notch()
        value = getattr(own, key) if getattr(own, key) is not None else getattr(shared, key)
        return value if value is not None else self._raise_missing(f"notch.{key}")

    def _value(self, field: str) -> Any:  # noqa: ANN401
        own = getattr(self.sample, field)
        return own if own is not None else getattr(self.stock, field)

    def _required(self, field: str) -> Any:  # noqa: ANN401
        value = self._value(field)
        return value if value is not None else self._raise_missing(field)

    def _raise_missing(self, field: str) -> None:
        path = (self.role, "samples", self.index, *field.split("."))
        allowed = f"a value in this sample or in [{self.role}]"
        raise self.config.refuse(path, f"{self.sample.name} has no {field}", allowed=allowed)

    def _refuse(self, field: str, message: str, found: object, allowed: str, hint: str = "") -> BadInput:
        own = getattr(self.sample, field) is not None
        path: Path = (self.role, "samples", self.index, field) if own else (self.role, field)
        return self.config.refuse(path, message, found=found, allowed=allowed, hint=hint or None)


def _check_names(config: Config) -> None:
    seen: dict[str, str] = {}
    for role in ("outer", "middle"):
        stock: Stock | None = getattr(config, role)
        for index, sample in enumerate(stock.samples if stock else ()):
            path: Path = (role, "samples", index, "name")
            if sample.name in seen:
                message = f"two tubes have this name, the other is in [{seen[sample.name]}]"
                raise config.refuse(path, message, found=sample.name, allowed="a name of its own")
            seen[sample.name] = role


def _check_size(config: Config) -> None:
    """Refuse more notches in all than a computer holds, before any is made."""
    for role in ("outer", "middle"):
        stock: Stock | None = getattr(config, role)
        if stock is None:
            continue
        shared = (stock.notch or Notch()).count or 1
        total = sum((sample.notch and sample.notch.count) or shared for sample in stock.samples)
        if total > MOST_NOTCHES:
            allowed = f"up to {MOST_NOTCHES}"
            raise config.refuse(
                (role, "samples"), "too many notches on all tubes together", found=total, allowed=allowed
            )


def _check_fits(config: Config) -> None:
    if config.inner is not None and config.inner.inner_diameter_mm >= config.inner.outer_diameter_mm:
        found, outer = config.inner.inner_diameter_mm, config.inner.outer_diameter_mm
        allowed = f"below the outer diameter, {outer:g}"
        raise config.refuse(("inner", "inner_diameter_mm"), "no wall is left", found=found, allowed=allowed)
    if config.tendon is None:
        return
    bores = {"inner tube": config.inner.inner_diameter_mm} if config.inner else {}
    bores |= {tube.name: tube.inner_diameter_mm for tube in bench_tubes(config, "middle")}
    for name, bore in bores.items():
        if 2.0 * config.tendon.radius_mm >= bore:
            message = f"the tendon does not go into the bore of {name}"
            allowed = f"below half of it, {bore / 2.0:g}"
            raise config.refuse(("tendon", "radius_mm"), message, found=config.tendon.radius_mm, allowed=allowed)


def _check_limits(config: Config) -> None:
    if config.checks is None:
        return
    if all(limit is None for _, limit in config.checks):
        allowed = f"one or more of {', '.join(type(config.checks).model_fields)}"
        raise config.refuse(("checks",), "no limit is given", allowed=allowed)
    ratio: RatioLimits | None = config.checks.rigidity_ratio
    if ratio is not None:
        if ratio.min is None and ratio.max is None:
            raise config.refuse(("checks", "rigidity_ratio"), "no limit is given", allowed="min, max or both")
        if ratio.min is not None and ratio.max is not None and ratio.min > ratio.max:
            path = ("checks", "rigidity_ratio", "min")
            raise config.refuse(path, "min is above max", found=ratio.min, allowed=f"at most {ratio.max:g}")
    for name in ("max_tendon_strain", "max_tension_n", "max_web_strain", "min_closure_margin", "fatigue"):
        if getattr(config.checks, name) is not None and config.checks.max_stroke_mm is None:
            message = "it is taken at the point of max_stroke_mm, which is not given"
            raise config.refuse(("checks", name), message)
    fatigue = config.checks.fatigue
    if fatigue is not None and fatigue.max_strain_amplitude is None and fatigue.cycles > FATIGUE_CYCLES:
        message = "no amplitude is known for so many cycles"
        allowed = f"at most {FATIGUE_CYCLES}, or max_strain_amplitude of your own"
        raise config.refuse(("checks", "fatigue", "cycles"), message, found=fatigue.cycles, allowed=allowed)
    if fatigue is not None and fatigue.source is not None and fatigue.max_strain_amplitude is None:
        message = "a source is named, but not the limit that it gives"
        raise config.refuse(("checks", "fatigue", "source"), message, allowed="max_strain_amplitude beside it")


def _check_fitted(config: Config) -> None:
    fitted = config.fitted
    if fitted is None:
        return
    count = len(fitted.keys)
    if len(fitted.std) != count:
        raise config.refuse(("fitted", "std"), "not one for each key", found=len(fitted.std), allowed=str(count))
    if len(fitted.correlation) != count or any(len(row) != count for row in fitted.correlation):
        raise config.refuse(
            ("fitted", "correlation"), "not one for each key with each", allowed=f"{count} rows of {count}"
        )
    for key in fitted.keys:
        if not _is_number(config, key):
            raise config.refuse(("fitted", "keys"), "there is no such number in this file", found=key)


def _is_number(config: Config, key: str) -> bool:
    """Return whether a dotted key leads to a number of the document."""
    place: Any = config
    for part in key.split("."):
        place = place.get(part) if isinstance(place, dict) else getattr(place, part, None) if part[:1] != "_" else None
        if place is None:
            return False
    return isinstance(place, float | int | Calibrated) and not isinstance(place, bool)


def _check_corrections(config: Config) -> None:
    if not config.corrections:
        return
    from coast_cli.effects.catalogue import CATALOGUE, OF_DEVICES
    from coast_cli.effects.corrections import faults
    from coast_cli.effects.own import add_installed

    if not CATALOGUE.keys() >= config.corrections.keys():
        add_installed()
    for fault in faults(config.corrections, CATALOGUE, OF_DEVICES):
        path: Path = ("corrections", *fault.path)
        raise config.refuse(path, fault.message, found=fault.found, allowed=fault.allowed, hint=fault.hint)
