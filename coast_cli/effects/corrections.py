"""What a ``[corrections]`` table may hold: the effects of joints and of shapes together, by id and parameter.

A model that was corrected on shapes is compared on joints too: each kind of recording takes the effects of its own
catalogue, and of an effect that both know the parameters that its own form has.
"""

from __future__ import annotations

from collections.abc import Mapping

from coast_cli.effects.effect import Parameter


def correction_parameters() -> Mapping[str, Mapping[str, tuple[float, float]]]:
    """Return the range of every parameter of every effect; of one that both catalogues know, the wider range."""
    from coast_cli.effects.catalogue import CATALOGUE
    from coast_cli.effects.shapes.catalogue import SHAPE_CATALOGUE

    found: dict[str, dict[str, tuple[float, float]]] = {}
    for effect in (*CATALOGUE.values(), *SHAPE_CATALOGUE.values()):
        ranges = found.setdefault(effect.id, {})
        for parameter in effect.parameters:
            low, high = ranges.get(parameter.name, (parameter.low, parameter.high))
            ranges[parameter.name] = min(low, parameter.low), max(high, parameter.high)
    return found


def own_values(parameters: tuple[Parameter, ...], values: Mapping[str, float]) -> dict[str, float]:
    """Return the values that belong to these parameters."""
    known = {parameter.name for parameter in parameters}
    return {name: value for name, value in values.items() if name in known}
