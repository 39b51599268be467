"""The axes of a study: a list of values, a range, or draws from a distribution."""

from __future__ import annotations

import math
import zlib
from abc import abstractmethod
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import Field

from zenvoy.keyed_random.draws import Purpose, normals, uniforms
from zenvoy.studies.sweeps.settings import setting_of
from zenvoy.studies.sweeps.study_keys import DescribedSeed
from zenvoy.values.section import LARGEST, Positive, Section

_DIGITS: Final = 6  # significant digits of a drawn value: it can be read, and typed again
_MOST: Final = 10**12  # the plan has its own limit, which names the number of runs

Number = Annotated[int | float, Field(ge=-LARGEST, le=LARGEST)]
_Samples = Annotated[int, Field(ge=1, le=_MOST, description="a whole number of at least 1")]
_Number = Field(description="a number in [-1e9, 1e9]")
_Positive = Field(description="a number in (0, 1e9]")
_List = Annotated[
    list[Any], Field(min_length=1, description="a list of one value or more, each of them once")
]


class Axis(Section):
    """A setting of the scenario that the study varies."""

    @property
    def random(self) -> bool:
        """Whether the values are random. All random axes of a study are drawn together."""
        return False

    @property
    @abstractmethod
    def size(self) -> int:
        """The number of values, without making them."""

    @abstractmethod
    def values_of(self, key: str) -> list[Any]:
        """Return the values that the setting `key` takes, in order."""

    def keys(self, key: str) -> tuple[str, ...]:
        """Return the settings of the scenario that the axis `key` varies."""
        return (key,)

    def settings_of(self, key: str, value: Any) -> tuple[str, ...]:
        """Return the settings that a value of the axis `key` stands for, as KEY=VALUE."""
        return (setting_of(key, value),)


class Listed(Axis):
    """An axis with listed values."""

    values: _List

    @property
    def size(self) -> int:
        """See Axis."""
        return len(self.values)

    def values_of(self, key: str) -> list[Any]:
        """See Axis."""
        return list(self.values)


class Variants(Axis):
    """An axis with names as values, each of which stands for any number of settings."""

    variants: Annotated[
        dict[str, dict[str, Any]],
        Field(min_length=1, description="a mapping of names to mappings of settings"),
    ]

    @property
    def size(self) -> int:
        """See Axis."""
        return len(self.variants)

    def values_of(self, key: str) -> list[Any]:
        """See Axis."""
        return list(self.variants)

    def keys(self, key: str) -> tuple[str, ...]:
        """See Axis."""
        return tuple(dict.fromkeys(name for of_one in self.variants.values() for name in of_one))

    def settings_of(self, key: str, value: Any) -> tuple[str, ...]:
        """See Axis."""
        return tuple(setting_of(name, one) for name, one in self.variants[value].items())


class Range(Axis):
    """An axis with `steps` equally spaced values, both ends included."""

    start: Annotated[Number, Field(alias="from"), _Number]
    end: Annotated[Number, Field(alias="to"), _Number]
    steps: Annotated[int, Field(ge=2, le=_MOST, description="a whole number of at least 2")]

    @property
    def size(self) -> int:
        """See Axis."""
        return self.steps

    def values_of(self, key: str) -> list[Any]:
        """Return whole numbers if both ends and the distance are whole numbers."""
        parts = self.steps - 1
        span = self.end - self.start
        if isinstance(self.start, int) and isinstance(span, int) and span % parts == 0:
            return [self.start + span // parts * k for k in range(self.steps)]
        inner = [_rounded(self.start + span * k / parts, 12) for k in range(1, parts)]
        return [float(self.start), *inner, float(self.end)]


class Random(Axis):
    """An axis with `samples` random values.

    Value i depends only on seed, key and i, so more samples keep the earlier ones.
    """

    samples: _Samples
    seed: DescribedSeed = 1

    @property
    def random(self) -> bool:
        """See Axis."""
        return True

    @property
    def size(self) -> int:
        """See Axis."""
        return self.samples

    def _uniforms(self, key: str) -> Any:
        who = zlib.crc32(key.encode())
        return uniforms(self.seed, Purpose.STUDY_AXIS, who, 0, np.arange(self.samples))[0]

    def _normals(self, key: str) -> Any:
        who = zlib.crc32(key.encode())
        return normals(self.seed, Purpose.STUDY_AXIS, who, 0, np.arange(self.samples))


class Uniform(Random):
    """An axis with uniformly distributed numbers in [low, high)."""

    distribution: Literal["uniform"]
    low: Annotated[Number, _Number]
    high: Annotated[Number, _Number]

    def values_of(self, key: str) -> list[Any]:
        """See Axis."""
        return [_rounded(self.low + (self.high - self.low) * u) for u in self._uniforms(key)]


class Normal(Random):
    """An axis with normally distributed numbers."""

    distribution: Literal["normal"]
    mean: Annotated[Number, _Number]
    sd: Annotated[Positive, _Positive]

    def values_of(self, key: str) -> list[Any]:
        """See Axis."""
        return [_rounded(self.mean + self.sd * z) for z in self._normals(key)]


class Lognormal(Random):
    """An axis with lognormally distributed numbers.

    Their natural logarithm has the standard deviation `sigma`.
    """

    distribution: Literal["lognormal"]
    median: Annotated[Positive, _Positive]
    sigma: Annotated[float, Field(gt=0, le=20, description="a number in (0, 20]")]

    def values_of(self, key: str) -> list[Any]:
        """See Axis."""
        return [_rounded(self.median * math.exp(self.sigma * z)) for z in self._normals(key)]


class Choice(Random):
    """An axis with random choices from a list; all values have the same probability."""

    distribution: Literal["choice"]
    values: _List

    def values_of(self, key: str) -> list[Any]:
        """See Axis."""
        return [self.values[int(u * len(self.values))] for u in self._uniforms(key)]


DISTRIBUTIONS: Final[dict[str, type[Random]]] = {
    "uniform": Uniform,
    "normal": Normal,
    "lognormal": Lognormal,
    "choice": Choice,
}


def _rounded(value: float, digits: int = _DIGITS) -> float:
    return float(f"{value:.{digits}g}")
