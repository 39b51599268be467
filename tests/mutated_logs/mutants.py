"""Mutants of logs come in an order that depends on the seed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from random import Random
from typing import Final, NamedTuple

from tests.mutated_logs.bases import Base, Mutation
from tests.mutated_logs.bytes_of_the_file import BYTES
from tests.mutated_logs.contents import CONTENTS
from tests.mutated_logs.records import RECORDS

MUTATIONS: Final[dict[str, Mutation]] = {**BYTES, **RECORDS, **CONTENTS}
"""All mutations by kind."""


class Mutant(NamedTuple):
    """A changed log."""

    kind: str
    content: bytes
    must_report: bool
    """Whether what was changed must be reported."""


def mutants(bases: Sequence[Base], seed: int) -> Iterator[Mutant]:
    """Yield mutants without end, of all kinds in turn."""
    random = Random(seed)
    while True:
        for kind, (change, must_report) in MUTATIONS.items():
            base = random.choice(bases)
            content = change(base, random)
            if content != base.content:
                yield Mutant(kind, content, must_report)
