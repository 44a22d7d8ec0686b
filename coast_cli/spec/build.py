"""From document to mechanics: SI numbers, arrays with one entry a notch, and signed curvatures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import BadInput, nearest
from coast_cli.mechanics.joint import Joint, Tendon
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.rows import short_repr
from coast_cli.spec.config import Config
from coast_cli.spec.superelastic import build_superelastic
from coast_cli.spec.transmission import TransmissionFields, is_transmission, no_tubes
from coast_cli.spec.tubes import BenchTube, Role, assembly_fault, bench_tubes, pair_names
from coast_cli.spec.values import nominal
from coast_cli.units import GIGAPASCAL, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.effects.effect import Effect


@dataclass(frozen=True)
class Design:
    """The tubes of a configuration, ready for the mechanics.

    Attributes:
        outer, middle: the tubes in the order of the file; an outer tube's natural curvature is positive (against
            gravity), a middle tube's negative (along it) for a positive number in the file.
        gravity: m/s^2.
        config: the document it was built from.
        notes: what the user should know of the tubes, e.g. that one lies outside the table of end effects.
    """

    __repr__ = short_repr

    outer: tuple[NotchedTube, ...]
    middle: tuple[NotchedTube, ...]
    gravity: float
    config: Config
    notes: tuple[str, ...] = ()

    @property
    def joint_pair(self) -> str | None:
        """The pair, ``OUTER/MIDDLE`` or one tube, that a command answers for where none is named; None if unclear."""
        joint = self.config.joint
        if joint is not None and joint.pair is not None:
            return joint.pair
        if len(self.middle) == 1 and len(self.outer) <= 1:
            return "/".join(tube.name for tube in (*self.outer, *self.middle))
        return None

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects of ``[corrections]``, which act on the joint."""
        from coast_cli.effects.catalogue import build_effects

        return build_effects(self.config.corrections)

    @property
    def uncorrected(self) -> tuple[str, ...]:
        """What to say where tubes are answered for as configured, without any correction."""
        ids = ", ".join(self.config.corrections)
        return (f"the corrections {ids} are left out here.",) if ids else ()

    @property
    def uncorrected_joint(self) -> tuple[str, ...]:
        """What to say where a joint is answered for with its own corrections alone."""
        acting = {effect.id for effect in self.effects}
        ids = ", ".join(name for name in self.config.corrections if name not in acting)
        return (f"the corrections {ids} are of shapes and left out here.",) if ids else ()

    def tube(self, name: str) -> NotchedTube:
        """Return the tube of that name.

        Raises:
            BadInput: there is none.
        """
        tubes = {tube.name: tube for tube in (*self.outer, *self.middle)}
        if name not in tubes:
            known = list(tubes)
            raise BadInput(
                "there is no such tube",
                file=self.config.source or None,
                found=name,
                allowed=", ".join(known),
                hint=nearest(name, known),
            )
        return tubes[name]

    def pair(self, asked: str | None = None) -> tuple[str | None, str]:
        """Return (outer or None, middle) of the pair asked for, or of ``joint_pair``.

        Raises:
            BadInput: a tube is unknown, or none is asked for and the configuration leaves it open.
        """
        if asked is not None:
            return pair_names(self.config, asked, path=("pair",))
        if self.joint_pair is None:
            raise self.config.refuse(
                ("joint", "pair"),
                "which pair is meant is not said",
                allowed="joint.pair in the file, or a pair OUTER/MIDDLE asked for",
            )
        return pair_names(self.config, self.joint_pair)

    def joint(self, asked: str | None = None) -> Joint:
        """Return the joint of the pair asked for, or of ``joint_pair``.

        Raises:
            BadInput: as ``pair`` and ``build_joint``.
        """
        return build_joint(self.config, *self.pair(asked))


def build(config: Config) -> Design:
    """Return the design that ``config`` describes: its tubes, joint and corrections in SI units.

    Raises:
        BadInput: it is of a device without tubes.

    Example:
        >>> design = coast.build(coast.load_config(coast.REFERENCE))
        >>> [tube.name for tube in design.outer], design.joint_pair
        (['OT1', 'OT2', 'OT3', 'OT4'], 'OT4/MT1')
    """
    if is_transmission(config):
        raise no_tubes(config)
    notes: dict[str, None] = {}  # each once, in order
    outer, middle = (
        tuple(build_tube(config, tube, notes) for tube in bench_tubes(config, role)) for role in ("outer", "middle")
    )
    return Design(outer, middle, config.environment.gravity_m_per_s2, config, tuple(notes))


def build_joint(config: Config, outer: str | None, middle: str) -> Joint:
    """Return the joint of one pair, or of one tube where ``outer`` is None.

    Raises:
        BadInput: there is no [joint], no such tube, or the pair cannot be assembled.
    """
    if config.joint is None:
        raise config.refuse((), "there is no [joint] table", hint="Run `coast explain joint` for what it holds.")
    if isinstance(config.joint, TransmissionFields):
        raise no_tubes(config)
    pair_names(config, middle if outer is None else f"{outer}/{middle}", path=("joint",))
    outer_tube = None if outer is None else _named(config, "outer", outer)
    middle_tube = _named(config, "middle", middle)
    fault = assembly_fault(config, outer_tube, middle_tube)
    if fault is not None:
        raise config.refuse(("joint", "pair"), f"the pair cannot be assembled: {fault}")
    joint = config.joint
    return Joint(
        outer=None if outer_tube is None else build_tube(config, outer_tube),
        middle=build_tube(config, middle_tube),
        tendon=build_tendon(config),
        youngs_modulus=nominal(joint.youngs_modulus_gpa) * GIGAPASCAL,
        pulley_friction=nominal(joint.pulley_friction),
        wrap_angle=nominal(joint.wrap_angle_rad),
        notch_friction=nominal(joint.notch_friction),
        deadband=nominal(joint.deadband_mm) * MILLIMETRE,
        outer_cover=None if joint.outer_cover_mm is None else joint.outer_cover_mm * MILLIMETRE,
    )


def build_tendon(config: Config) -> Tendon | None:
    """Return the tendon, or None where the configuration has none."""
    if config.tendon is None:
        return None
    return Tendon(
        radius=config.tendon.radius_mm * MILLIMETRE,
        youngs_modulus=nominal(config.tendon.youngs_modulus_gpa) * GIGAPASCAL,
        length=nominal(config.tendon.length_mm) * MILLIMETRE,
    )


def build_tube(config: Config, tube: BenchTube, notes: dict[str, None] | None = None) -> NotchedTube:
    """Return one tube in SI units, its natural curvature signed by its role; what it says is added to ``notes``."""
    material = config.materials[tube.material]
    depth = np.array(tube.depth_mm) * MILLIMETRE
    return NotchedTube(
        name=tube.name,
        outer_radius=tube.outer_diameter_mm / 2.0 * MILLIMETRE,
        inner_radius=tube.inner_diameter_mm / 2.0 * MILLIMETRE,
        depth=depth,
        cut=np.full(tube.count, tube.cut_mm * MILLIMETRE),
        uncut=np.full(tube.count, tube.uncut_mm * MILLIMETRE),
        youngs_modulus=nominal(material.youngs_modulus_gpa) * GIGAPASCAL,
        density=material.density_kg_per_m3,
        natural_curvature=(1.0 if tube.role == "outer" else -1.0) * tube.natural_curvature_per_m,
        section=tube.section,
        end_length=_end_length(tube, {} if notes is None else notes),
        superelastic=build_superelastic(material),
    )


def _end_length(tube: BenchTube, notes: dict[str, None]) -> FloatArray | float:
    if tube.end_effect == "none":
        return 0.0
    if tube.end_effect == "table":
        from coast_cli.mechanics.end_effect import end_length

        lengths, remarks = end_length(
            outer_radius=tube.outer_diameter_mm / 2.0 * MILLIMETRE,
            inner_radius=tube.inner_diameter_mm / 2.0 * MILLIMETRE,
            depth=np.array(tube.depth_mm) * MILLIMETRE,
            cut=tube.cut_mm * MILLIMETRE,
            uncut=tube.uncut_mm * MILLIMETRE,
            kind=tube.section,
        )
        notes.update((f"{tube.name}: {remark}.", None) for remark in remarks)
        return lengths
    return np.array(tube.end_effect) * MILLIMETRE


def _named(config: Config, role: Role, name: str) -> BenchTube:
    return next(tube for tube in bench_tubes(config, role) if tube.name == name)
