"""What a person may do to a run in real time from its page."""

from __future__ import annotations

import hmac
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class Act:
    """What may be done with a number: a vehicle, or a percentage if it says so.

    `do` gets the number and the name of the run, and returns whether it could be done.
    """

    do: Callable[[int, str], bool]
    is_percentage: bool = False

    def takes(self, number: int, vehicles: int) -> bool:
        """Return whether the number can be meant, for a fleet of so many vehicles."""
        return 0 <= number <= 100 if self.is_percentage else 1 <= number <= vehicles


@dataclass(frozen=True, slots=True, kw_only=True)
class Controls:
    """Acts by name, for those who know the key.

    The key is in the address that the command prints, so other users of this machine can look on,
    but not interfere.
    """

    key: str = ""
    acts: Mapping[str, Act] = field(default_factory=dict)

    def refusal(self, key: str, act: str) -> str | None:
        """Return why an act is refused, or None."""
        if not self.key or not hmac.compare_digest(key.encode(), self.key.encode()):
            return "the page was not opened by the address that the command printed"
        if act not in self.acts:
            return f"{act}: cannot be done to this run"
        return None


NO_CONTROLS: Final = Controls()
