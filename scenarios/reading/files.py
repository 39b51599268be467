"""Reads the files that a scenario names: speed traces, latency samples, technologies."""

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
    """Return `root` with the contents of files in place of their names, and the errors in them.

    A file name is relative to the file that contains it, which `origins` finds by the `source` of
    the place. In an option, it is relative to the current folder.
    """
    errors: list[ScenarioError] = []
    allowance = Allowance()

    def filled(table: Table, section: Node, path: Path) -> Node:
        changed, error = table.filled(section, dotted(path), origins, allowance)
        if error is not None:
            errors.append(error)
        return changed

    def with_latency(holder: Node, path: Path) -> Node:
        return _changed(holder, "latency", path, lambda node, at: filled(LATENCY, node, at))

    def with_points(event: Node, path: Path) -> Node:
        kind = event.child("type")
        is_trace = kind is not None and kind.value == "trace"
        return filled(TRACE, event, path) if is_trace else event

    def with_rules(channel: Node, path: Path) -> Node:
        return _changed(channel, "rules", path, lambda node, at: _each(node, at, with_latency))

    def with_technologies(channel: Node, path: Path) -> Node:
        return _changed(channel, "technology", path, lambda node, _: technology(node))

    def technology(named: Node) -> Node:
        try:
            return with_technology(named, origins)
        except ScenarioError as error:
            errors.append(error)
            return replace(named, value=Unreadable.UNREADABLE)

    root = _changed(root, "channel", (), with_technologies)
    root = _changed(root, "channel", (), with_latency)
    root = _changed(root, "channel", (), with_rules)
    root = _changed(root, "events", (), lambda node, at: _each(node, at, with_points))
    return root, errors


def _changed(holder: Node, key: str, path: Path, change: Change) -> Node:
    """Return `holder`, which is at `path`, with its entry under `key`, if any, changed."""
    if not isinstance(holder.value, dict) or key not in holder.value:
        return holder
    entry = change(holder.value[key], (*path, key))
    return replace(holder, value={**holder.value, key: entry})


def _each(node: Node, path: Path, change: Change) -> Node:
    """Return a list with each entry changed, and anything else as it is."""
    if not isinstance(node.value, tuple):
        return node
    entries = tuple(change(entry, (*path, index)) for index, entry in enumerate(node.value))
    return replace(node, value=entries)
