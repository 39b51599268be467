"""What sections of a scenario may read from CSV files: speed traces, samples of latency."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.origin import Origin
from zenvoy.scenarios.tables import Numbers, Table
from zenvoy.scenarios.trace_files import TraceFile
from zenvoy.scenarios.tree import Node, planted
from zenvoy.scenarios.wording import dotted

TRACE: Final = Table("points", TraceFile())
LATENCY: Final = Table("samples_ms", Numbers("latency_ms"), required=False)


def with_tables(root: Node, origins: Mapping[str, Origin]) -> tuple[Node, list[Problem]]:
    """`root` with the contents of CSV files in place of their names, and what is wrong there.

    As `Table.filled`.
    """
    problems: list[Problem] = []
    for path, section, table in list(_sections(root)):
        filled, wrong = table.filled(section, dotted(path), origins)
        root = planted(root, path, filled)
        problems += wrong
    return root, problems


def _sections(root: Node) -> Iterator[tuple[tuple[str, ...], Node, Table]]:
    """The sections that may name a file, with their paths."""
    channels = [
        ("channel",),
        *(("channel", "rules", n) for n, _ in _items(root, "channel", "rules")),
    ]
    for path in channels:
        latency = root.find((*path, "latency"))
        if latency is not None:
            yield (*path, "latency"), latency, LATENCY
    for number, event in _items(root, "events"):
        kind = event.child("type")
        if kind is not None and kind.value == "trace":
            yield ("events", number), event, TRACE


def _items(root: Node, *path: str) -> list[tuple[str, Node]]:
    """The entries of a list, each with its index; none where there is no list."""
    node = root.find(path)
    found = node.value if node is not None and isinstance(node.value, tuple) else ()
    return [(str(index), item) for index, item in enumerate(found)]
