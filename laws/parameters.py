"""Checks parameters of a law or an estimator against the annotations of their dataclass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from functools import cache
from typing import Annotated, Any, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, create_model

_CONFIG = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)

_LARGEST = 1e9
Positive = Annotated[float, Field(gt=0.0, le=_LARGEST)]
NonNegative = Annotated[float, Field(ge=0.0, le=_LARGEST)]
Finite = Annotated[float, Field(ge=-_LARGEST, le=_LARGEST)]
Sides = Annotated[int, Field(ge=1, le=100)]
"""A number of vehicles on each side."""
Exponent = Annotated[int, Field(ge=1, le=16)]
"""The exponent of a power that is computed by products."""


@cache
def model_of(parameters: type) -> type[BaseModel]:
    """Return a strict pydantic model with the fields of a dataclass; numbers must be finite."""
    hints = get_type_hints(parameters, include_extras=True)
    described: dict[str, Any] = {}
    for one in fields(parameters):
        default = one.default
        if default is MISSING and one.default_factory is not MISSING:
            default = one.default_factory()
        described[one.name] = (hints[one.name], Field() if default is MISSING else default)
    return create_model(parameters.__name__, __config__=_CONFIG, **described)


def parameters_of(parameters: type, values: Mapping[str, Any]) -> Any:
    """Return parameters of a type with the given values; raises pydantic.ValidationError."""
    checked = model_of(parameters).model_validate(dict(values))
    names = model_of(parameters).model_fields
    return parameters(**{name: getattr(checked, name) for name in names})
