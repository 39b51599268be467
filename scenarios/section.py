"""What every section of a scenario shares: strictness, and the ranges of numbers."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

# Keeps every sum and product of settings finite, and every time within an int64 of nanoseconds.
LARGEST = 1e9

Fraction = Annotated[float, Field(ge=0, le=1)]
NonNegative = Annotated[float, Field(ge=0, le=LARGEST)]
Positive = Annotated[float, Field(gt=0, le=LARGEST)]

NS_PER_MS = 1_000_000
NS_PER_S = 1_000_000_000


class Section(BaseModel):
    """Base of every section: immutable, no unknown keys, no silent conversions, finite numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
