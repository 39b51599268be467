"""The parameters of a law, checked against the annotations of its dataclass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from functools import cache
from typing import Any, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, create_model

from zenvoy.laws.law import Law

_CONFIG = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


@cache
def model_of(law: Law) -> type[BaseModel]:
    """Return a pydantic model with the fields of the law's parameters, strict and finite."""
    hints = get_type_hints(law.parameters, include_extras=True)
    described: dict[str, Any] = {}
    for one in fields(law.parameters):
        default = one.default
        if default is MISSING and one.default_factory is not MISSING:
            default = one.default_factory()
        described[one.name] = (hints[one.name], Field() if default is MISSING else default)
    return create_model(law.parameters.__name__, __config__=_CONFIG, **described)


def parameters_of(law: Law, values: Mapping[str, Any]) -> Any:
    """Return the law's parameters from checked values; raises pydantic.ValidationError."""
    checked = model_of(law).model_validate(dict(values))
    return law.parameters(**{name: getattr(checked, name) for name in model_of(law).model_fields})
