"""The table ``[joint]`` of a device that is no notched tube: a ratio and a zero, and nothing of tubes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from coast_cli.mechanics.transmission import Transmission
from coast_cli.spec.values import Allowed, Calibrated, Document, Within, nominal
from coast_cli.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.errors import BadInput
    from coast_cli.spec.config import Config

NOTCHED, TRANSMISSION = "notched", "transmission"
KINDS = f"{NOTCHED!r} (the usual) or {TRANSMISSION!r}"
_RESPONSES = {"bend": DEGREE, "position": MILLIMETRE, "force": 1.0}  # SI value of the unit in which a ratio is given
_OF_TUBES = ("materials", "outer", "middle", "inner", "tendon", "checks", "rank", "explore", "tolerances")


class TransmissionFields(Document):
    """A transmission without tubes: response = ratio (drive - zero), to both sides."""

    kind: Annotated[Literal["transmission"], Allowed(KINDS)] = Field(description="transmission: a device without tubes")
    ratio: Annotated[float | Calibrated, Within(-1e6, 1e6)] = Field(
        description="response for one mm of drive: degrees, mm or N, by what the recording holds; the sign is free"
    )
    zero_mm: Annotated[float | Calibrated, Within(-1e6, 1e6)] = Field(
        0.0, description="drive at which the response is zero, mm (N where a tension drives)"
    )
    load_ratio: Annotated[float | Calibrated, Within(-1e6, 1e6)] = Field(
        0.0, description="N of response for one N or N m that the far end carries, where the response is a force"
    )

    @property
    def pair(self) -> None:
        """There are no tubes, so there is no pair."""
        return


def kind_of(value: Any) -> str:  # noqa: ANN401
    """Return which form of ``[joint]`` a table is."""
    kind = value.get("kind") if isinstance(value, Mapping) else getattr(value, "kind", None)
    meant = (
        kind not in (None, NOTCHED) and isinstance(value, Mapping) and "ratio" in value
    )  # of a kind that is misspelt
    return TRANSMISSION if kind == TRANSMISSION or meant else NOTCHED


def is_transmission(config: Config) -> bool:
    """Return whether a configuration is of a device without tubes."""
    return isinstance(config.joint, TransmissionFields)


def check_transmission(config: Config) -> None:
    """Refuse tables of tubes beside a device that has none.

    Raises:
        BadInput: at the first of them.
    """
    for table in _OF_TUBES:
        if getattr(config, table):
            raise config.refuse((table,), "a transmission has no tubes", allowed="[joint], [corrections] and [fitted]")


def no_tubes(config: Config) -> BadInput:
    """Return the refusal of what needs tubes."""
    takes = "coast recordings, diagnose, compare, calibrate and validate take it"
    return config.refuse(("joint", "kind"), f"a transmission has no tubes, which this needs; {takes}")


def build_transmission(fields: TransmissionFields, kind: str, *, by_stroke: bool) -> Transmission:
    """Return the transmission in SI units for one kind of response (``bend``, ``position``, ``force``) and of drive."""
    drive = MILLIMETRE if by_stroke else 1.0
    return Transmission(
        ratio=nominal(fields.ratio) * _RESPONSES[kind] / drive,
        zero=nominal(fields.zero_mm) * drive,
        load_ratio=nominal(fields.load_ratio),
        ratio_unit=_RESPONSES[kind] / drive,
        drive_unit=drive,
    )


def takes_response(kind: str) -> bool:
    """Return whether a transmission can have this kind of response."""
    return kind in _RESPONSES
