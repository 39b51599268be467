"""The parameters of a search: a range of numbers, or a list of choices."""

from __future__ import annotations

import json
from abc import abstractmethod
from typing import Annotated, Any, Final

from pydantic import Field

from zenvoy.studies.sweeps.axes import Number
from zenvoy.values.section import Positive, Section

_DIGITS: Final = 6  # significant digits of a number: it can be read, and typed again
_ROUNDING: Final = 1e-9
_NUMBER: Final = "a number in [-1e9, 1e9]"
_LIST: Final = "a list of two values or more, each of them once"


class Parameter(Section):
    """A setting of the scenario whose best value is searched for."""

    @property
    @abstractmethod
    def samples(self) -> list[Any]:
        """Values that the scenario must allow: both ends of a range, or every choice."""

    @property
    @abstractmethod
    def shown(self) -> str:
        """The values in words."""

    @abstractmethod
    def proposed_as(self, value: Any) -> Any:
        """Return a value as the search represents it: a number, or the label of a choice."""

    @abstractmethod
    def value_of(self, proposed: Any) -> Any:
        """Return the value that a proposal of the search stands for."""


class Span(Parameter):
    """Numbers from low to high, both included; whole ones if low, high and step are whole."""

    low: Annotated[Number, Field(description=_NUMBER)]
    high: Annotated[Number, Field(description=_NUMBER)]
    step: Annotated[Positive | int | None, Field(description="a number in (0, 1e9]")] = None
    log: Annotated[bool, Field(description="true or false")] = False

    @property
    def whole(self) -> bool:
        """Whether its values are whole numbers."""
        return all(isinstance(number, int) for number in (self.low, self.high, self.step))

    @property
    def samples(self) -> list[Any]:
        """See Parameter."""
        return [self.low, self.high] if self.whole else [float(self.low), float(self.high)]

    @property
    def shown(self) -> str:
        """See Parameter."""
        step = "" if self.step is None else f" in steps of {self.step:g}"
        return f"{self.low:g} to {self.high:g}{step}{', logarithmic' if self.log else ''}"

    @property
    def problem(self) -> tuple[str, str] | None:
        """The key that does not agree with the others, and what is wrong; None if they agree."""
        if self.low >= self.high:
            return "low", f"{self.low:g} is not below high, {self.high:g}"
        if self.log and self.low <= 0:
            return "low", f"{self.low:g} is not above 0; log: true needs numbers above 0"
        if self.step is None:
            return None
        if self.log and not (self.whole and self.step == 1):
            return "step", f"{self.step:g} with log: true; allowed: 1, with whole low and high"
        steps = (self.high - self.low) / self.step
        if abs(steps - round(steps)) > _ROUNDING * max(1.0, steps) or round(steps) < 1:
            return "step", f"{self.step:g} does not lead from {self.low:g} to {self.high:g}"
        return None

    def proposed_as(self, value: Any) -> Any:
        """See Parameter."""
        return value

    def value_of(self, proposed: Any) -> Any:
        """Return a proposed number with few digits, within the range."""
        if self.whole:
            return int(proposed)
        rounded = float(f"{proposed:.{_DIGITS if self.step is None else 12}g}")
        return min(max(rounded, float(self.low)), float(self.high))


class Choices(Parameter):
    """One of some values, which may also be texts, lists or mappings."""

    choices: Annotated[list[Any], Field(min_length=2, description=_LIST)]

    @property
    def samples(self) -> list[Any]:
        """See Parameter."""
        return list(self.choices)

    @property
    def shown(self) -> str:
        """See Parameter."""
        return ", ".join(self.labels)

    @property
    def labels(self) -> list[str]:
        """The choices as JSON, by which the search tells them apart."""
        return [self.proposed_as(choice) for choice in self.choices]

    def proposed_as(self, value: Any) -> Any:
        """See Parameter."""
        return json.dumps(value, ensure_ascii=False, sort_keys=True)

    def value_of(self, proposed: Any) -> Any:
        """See Parameter."""
        return self.choices[self.labels.index(proposed)]
