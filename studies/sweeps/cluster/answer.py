"""The answer of a worker: the files of finished runs, and why the others failed."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """The files of each finished run, by key and form, and one line about what failed."""

    runs: Mapping[str, Mapping[str, bytes]] = field(default_factory=dict)
    failure: str | None = None

    def packed(self) -> bytes:
        """Return the answer as bytes."""
        return pickle.dumps(self)


def answer_in(packed: bytes) -> Answer:
    """Return the answer in packed bytes."""
    answer: Answer = pickle.loads(packed)
    return answer
