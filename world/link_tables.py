"""Tables of frames in real time, which the channel sends in any number per cycle."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.frame_table import FrameTable
from zenvoy.bus.refusals import STALE, RefusedError


class LinkTables:
    """The tables of the cycles that are not logged yet, each with other senders."""

    def __init__(self, table_of: Callable[[pb.Links], FrameTable]) -> None:
        """table_of: decodes and checks a table; raises RefusedError."""
        self._table_of = table_of
        self._kept: defaultdict[int, list[FrameTable]] = defaultdict(list)

    def take_in(self, links: pb.Links) -> str | None:
        """Keep a table, or return why it is refused: it is malformed, or repeats a sender."""
        try:
            table = self._table_of(links)
        except RefusedError as refused:
            return refused.reason
        kept, source = self._kept[links.cycle], table.columns["source"]
        if any(np.isin(source, one.columns["source"]).any() for one in kept):
            return STALE
        if not kept or len(source):
            kept.append(table)
        return None

    def take_out(self, cycle: int) -> list[FrameTable]:
        """Remove and return the tables of a cycle."""
        return self._kept.pop(cycle, [])
