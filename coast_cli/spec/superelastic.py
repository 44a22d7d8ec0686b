"""``[materials.NAME.superelastic]``: the stress-strain curve of a material past its elastic range, at a temperature."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from coast_cli.mechanics.superelastic import CLAUSIUS_CLAPEYRON, Superelastic
from coast_cli.spec.values import Document, Within, nominal
from coast_cli.units import GIGAPASCAL, MEGAPASCAL

if TYPE_CHECKING:
    from coast_cli.spec.config import Config, Material

Stress = Annotated[float, Within(1.0, 3000.0)]
Celsius = Annotated[float, Within(-150.0, 200.0)]


class SuperelasticFields(Document):
    """A flag-shaped stress-strain curve; the austenite's modulus is that of the material."""

    martensite_modulus_gpa: Annotated[float, Within(0.001, 10_000.0)] = Field(
        description="Young's modulus of the martensite, GPa; at most that of the austenite"
    )
    upper_plateau_mpa: Stress = Field(description="tensile stress at which the loading plateau begins, MPa")
    lower_plateau_mpa: Stress = Field(description="tensile stress at which the unloading plateau ends, MPa")
    transformation_strain: Annotated[float, Within(1e-4, 0.2)] = Field(
        0.046, description="length of the loading plateau, strain; nitinol about 0.046"
    )
    plateau_slope_gpa: Annotated[float, Within(0.0, 10_000.0)] = Field(
        0.0, description="slope of the loading plateau, GPa"
    )
    compression_ratio: Annotated[float, Within(0.5, 3.0)] = Field(
        1.0, description="plateau stresses in compression over those in tension; the plateau is as much shorter"
    )
    measured_at_c: Celsius = Field(22.0, description="temperature at which the plateaus were measured, degrees C")
    temperature_c: Celsius | None = Field(
        None, description="temperature in use, degrees C; else that of the measurement"
    )
    slope_mpa_per_k: Annotated[float, Within(0.0, 20.0)] = Field(
        CLAUSIUS_CLAPEYRON / MEGAPASCAL,
        description="rise of both plateaus with temperature (Clausius-Clapeyron), MPa/K",
    )

    @property
    def warming_k(self) -> float:
        """Temperature in use above that of the measurement, K."""
        return 0.0 if self.temperature_c is None else self.temperature_c - self.measured_at_c


def build_superelastic(material: Material) -> Superelastic | None:
    """Return the law of a material at its temperature in use, or None where it is linear."""
    fields = material.superelastic
    if fields is None:
        return None
    law = Superelastic(
        austenite_modulus=nominal(material.youngs_modulus_gpa) * GIGAPASCAL,
        martensite_modulus=fields.martensite_modulus_gpa * GIGAPASCAL,
        upper_plateau=fields.upper_plateau_mpa * MEGAPASCAL,
        lower_plateau=fields.lower_plateau_mpa * MEGAPASCAL,
        transformation_strain=fields.transformation_strain,
        plateau_modulus=fields.plateau_slope_gpa * GIGAPASCAL,
        compression_ratio=fields.compression_ratio,
    )
    return law.warmer(fields.warming_k, fields.slope_mpa_per_k * MEGAPASCAL)


def check_superelastic(config: Config) -> None:
    """Refuse a curve that no material has.

    Raises:
        BadInput: placed at the offending key.
    """
    for name, material in config.materials.items():
        if material.superelastic is not None:
            _check(config, name, material, material.superelastic)


def _check(config: Config, name: str, material: Material, fields: SuperelasticFields) -> None:
    table = ("materials", name, "superelastic")
    modulus = nominal(material.youngs_modulus_gpa)
    if fields.martensite_modulus_gpa > modulus:
        message, allowed = "martensite is stiffer than austenite", f"at most youngs_modulus_gpa, {modulus:g}"
        path = (*table, "martensite_modulus_gpa")
        raise config.refuse(path, message, found=fields.martensite_modulus_gpa, allowed=allowed)
    if fields.lower_plateau_mpa >= fields.upper_plateau_mpa:
        message, allowed = (
            "the plateaus are in the wrong order",
            f"below upper_plateau_mpa, {fields.upper_plateau_mpa:g}",
        )
        raise config.refuse((*table, "lower_plateau_mpa"), message, found=fields.lower_plateau_mpa, allowed=allowed)
    if fields.plateau_slope_gpa >= fields.martensite_modulus_gpa:
        message, allowed = (
            "the plateau is no plateau",
            f"below martensite_modulus_gpa, {fields.martensite_modulus_gpa:g}",
        )
        raise config.refuse((*table, "plateau_slope_gpa"), message, found=fields.plateau_slope_gpa, allowed=allowed)
    law = build_superelastic(material)
    if law is None:
        return
    if law.lower_plateau <= 0.0:
        lowest = fields.measured_at_c - fields.lower_plateau_mpa / fields.slope_mpa_per_k
        message = "at this temperature the tube stays bent: it is past the transformation, with no lower plateau left"
        raise config.refuse(
            (*table, "temperature_c"), message, found=fields.temperature_c, allowed=f"above {lowest:.4g}"
        )
    shortest = law.transformation_strain - law.lower_length
    if law.lower_length <= 0.0:
        message, allowed = "the loop is wider than its plateau is long", f"above {shortest:.4g}"
        raise config.refuse(
            (*table, "transformation_strain"), message, found=fields.transformation_strain, allowed=allowed
        )
