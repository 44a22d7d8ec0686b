"""The kinds of value a configuration may hold, each with its range; a refusal always says the whole range.

``Within`` bounds a number, a list of numbers or a calibratable number; ``Allowed`` words any other choice.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, StringConstraints
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

NUMBER, TABLE = "<number>", "<table>"  # which form of a calibratable number a location is in
REFUSED = "refused"  # the error type that carries its own "allowed" text


class Document(BaseModel):
    """A table of a configuration: unknown keys are refused, types are not coerced, values do not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True)


class Calibrated(Document):
    """A number that calibration may move between two bounds."""

    value: float
    min: float
    max: float


def nominal(number: float | Calibrated) -> float:
    """Return the value of a number that may be calibratable."""
    return number.value if isinstance(number, Calibrated) else number


@dataclass(frozen=True)
class Allowed:
    """Words what a field takes; any failure below it is reported as this one sentence."""

    text: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:  # noqa: ANN401
        """Wrap the field's own schema."""
        return _worded(handler(source), self.text)


@dataclass(frozen=True)
class Within:
    """Bounds a number: low <= x <= high, or low < x where ``above`` is set.

    On ``int`` it takes whole numbers, on ``float | Calibrated`` also ``{ value, min, max }`` inside the same
    bounds, on ``float | tuple[float, ...]`` also a list.
    """

    low: float
    high: float
    above: bool = False

    @property
    def text(self) -> str:
        """The range in words."""
        return f"{'above' if self.above else 'from'} {self.low:g} {'and at most' if self.above else 'to'} {self.high:g}"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:  # noqa: ANN401
        """Build the schema of the number, and of its list or calibratable form where the annotation has one."""
        if source is int:
            whole = core_schema.int_schema(strict=True, ge=int(self.low), le=int(self.high))
            return _worded(whole, f"a whole number {self.text}")
        at_least, above = (None, self.low) if self.above else (self.low, None)
        number = core_schema.float_schema(strict=True, allow_inf_nan=False, ge=at_least, gt=above, le=self.high)
        if source is float:
            return _worded(number, f"a number {self.text}")
        if source == float | Calibrated:
            table = core_schema.no_info_after_validator_function(self._ordered, handler.generate_schema(Calibrated))
            choices = {NUMBER: _worded(number, f"a number {self.text}, or {{ value, min, max }}"), TABLE: table}
            return core_schema.tagged_union_schema(choices, discriminator=_table_or_number)
        several = core_schema.tuple_variable_schema(number, min_length=1, strict=False)
        either = core_schema.union_schema([number, several])
        return _worded(either, f"a number {self.text}, or a list of them")

    def _ordered(self, table: Calibrated) -> Calibrated:
        above_low = table.min > self.low if self.above else table.min >= self.low
        if not (above_low and table.min <= table.value <= table.max <= self.high and table.min < table.max):
            raise PydanticCustomError(
                REFUSED, "not in order", {"allowed": f"min <= value <= max with min < max, all {self.text}"}
            )
        return table


def _worded(schema: CoreSchema, text: str) -> CoreSchema:
    return core_schema.custom_error_schema(
        schema, custom_error_type=REFUSED, custom_error_message="not allowed", custom_error_context={"allowed": text}
    )


def _table_or_number(value: object) -> str:
    return TABLE if isinstance(value, dict | Calibrated) else NUMBER


Diameter = Annotated[float, Within(0.01, 100.0)]
Length = Annotated[float, Within(0.001, 1000.0)]
Curvature = Annotated[float, Within(-1000.0, 1000.0)]
Modulus = Annotated[float | Calibrated, Within(0.001, 10_000.0)]
Name = Annotated[
    str,
    StringConstraints(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_.+-]*$", max_length=60),
    Allowed("a name of letters, digits and any of _ . + -"),
]
SectionChoice = Annotated[Literal["sector", "chord"], Allowed("'sector' or 'chord'")]
_ExtraCut = Annotated[float, Field(ge=0.0, le=100.0)]
EndEffect = Annotated[
    Literal["none", "table"] | _ExtraCut | Annotated[tuple[_ExtraCut, ...], Field(strict=False)],
    Allowed("'none', 'table', a length in mm from 0 to 100, or a list of lengths"),
]
