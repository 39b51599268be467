"""The base of every section of a scenario, and the types of numbers with their ranges."""

from __future__ import annotations

import re
from decimal import Decimal
from typing import Annotated, Any, Final

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
)
from pydantic_core.core_schema import CoreSchema, no_info_before_validator_function

# Keeps every sum and product of settings finite, and every time in ns within an int64.
LARGEST = 1e9

_PERCENT: Final = re.compile(r"\s*([+-]?(?:\d{1,20}\.?\d{0,20}|\.\d{1,20}))\s*%\s*", re.ASCII)


def _fraction(value: object) -> object:
    """Return 0.333 for "33.3%", rounded once; return other values as they are."""
    percent = _PERCENT.fullmatch(value) if isinstance(value, str) else None
    return value if percent is None else float(Decimal(percent[1]) / 100)


class _Percent:
    """Lets a fraction be written in percent, and marks it so in the JSON schema."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return no_info_before_validator_function(_fraction, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {**handler(schema), "percent": True}


Percent: Final = _Percent()
"""Lets a fraction be written in percent."""
Fraction = Annotated[float, Field(ge=0, le=1), Percent]
NonNegative = Annotated[float, Field(ge=0, le=LARGEST)]
Positive = Annotated[float, Field(gt=0, le=LARGEST)]

SEED_LIMIT: Final = 2**63  # a seed is kept in an int64
Seed = Annotated[int, Field(ge=0, lt=SEED_LIMIT)]

NS_PER_MS = 1_000_000
NS_PER_S = 1_000_000_000


class Section(BaseModel):
    """The base of every section: immutable, no unknown keys, no conversions, finite numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
