"""What a scenario may name files for: speed traces, samples of latency, a technology."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from zenvoy.scenarios.errors import ScenarioError
from zenvoy.scenarios.reading.origin import Origin
from zenvoy.scenarios.reading.tables import Allowance, Numbers, Table
from zenvoy.scenarios.reading.technology_files import with_technology
from zenvoy.scenarios.reading.trace_files import TraceFile
from zenvoy.scenarios.reading.tree import Node, Path, Unreadable
from zenvoy.values.wording import dotted

TRACE: Final = Table("points", TraceFile())
LATENCY: Final = Table("samples_ms", Numbers("latency_ms"), required=False)

Change = Callable[[Node, Path], Node]


def with_files(root: Node, origins: Mapping[str, Origin]) -> tuple[Node, list[ScenarioError]]:
    """`root` with the contents of files in place of their names, and what is wrong there.

    The name of a file is relative to the file that says it, one of `origins` by what places call
    it; that of an option is relative to the folder of the command.
    """
    errors: list[ScenarioError] = []
    allowance = Allowance()

    def filled(table: Table, section: Node, path: Path) -> Node:
        told, wrong = table.filled(section, dotted(path), origins, allowance)
        if wrong is not None:
            errors.append(wrong)
        return told

    def with_latency(holder: Node, path: Path) -> Node:
        return _changed(holder, "latency", path, lambda node, at: filled(LATENCY, node, at))

    def with_points(event: Node, path: Path) -> Node:
        kind = event.child("type")
        is_trace = kind is not None and kind.value == "trace"
        return filled(TRACE, event, path) if is_trace else event

    def with_rules(channel: Node, path: Path) -> Node:
        return _changed(channel, "rules", path, lambda node, at: _each(node, at, with_latency))

    def of_technology(channel: Node, path: Path) -> Node:
        return _changed(channel, "technology", path, lambda node, _: technology(node))

    def technology(named: Node) -> Node:
        try:
            return with_technology(named, origins)
        except ScenarioError as error:
            errors.append(error)
            return replace(named, value=Unreadable.UNREADABLE)

    root = _changed(root, "channel", (), of_technology)
    root = _changed(root, "channel", (), with_latency)
    root = _changed(root, "channel", (), with_rules)
    root = _changed(root, "events", (), lambda node, at: _each(node, at, with_points))
    return root, errors


def _changed(holder: Node, key: str, path: Path, change: Change) -> Node:
    """`holder` with another entry under `key`, where it has one; `path` leads to `holder`."""
    if not isinstance(holder.value, dict) or key not in holder.value:
        return holder
    entry = change(holder.value[key], (*path, key))
    return replace(holder, value={**holder.value, key: entry})


def _each(node: Node, path: Path, change: Change) -> Node:
    """A list with each of its entries changed; anything else as it is."""
    if not isinstance(node.value, tuple):
        return node
    entries = tuple(change(entry, (*path, index)) for index, entry in enumerate(node.value))
    return replace(node, value=entries)
