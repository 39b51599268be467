"""What a person may do to a run in real time from its page."""

from __future__ import annotations

import hmac
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class Act:
    """What may be done with a number, such as that of a vehicle; `of` says what the number is.

    `do` gets the number and the name of the run, and returns whether it could be done.
    """

    of: str
    allowed: range
    do: Callable[[int, str], bool]


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
