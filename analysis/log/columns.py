"""Turns many messages of one type into one table, without a step of Python per value.

Nearly all messages of a topic have the same layout: the same numbers at the same offsets. Messages
of one layout form one array of bytes, and each column of the table is a slice of it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus.packed import PackedCodec

Table = dict[str, NDArray[Any]]


def stack(codec: PackedCodec, payloads: Sequence[bytes]) -> Table:
    """Return a table with a row per message: single fields (rows,), columns (rows, vehicles).

    It is {} where there is no message. A column that no message has is (rows, 0). A column that
    some messages lack is 0 there, as in protobuf. Raises ValueError where messages cannot be
    decoded or their columns differ in length.
    """
    if not payloads:
        return {}
    by_length: dict[int, list[int]] = defaultdict(list)
    for row, payload in enumerate(payloads):
        by_length[len(payload)].append(row)
    table: Table = {
        name: np.zeros((len(payloads), 0) if column else len(payloads), dtype)
        for name, (dtype, column) in codec.fields().items()
    }
    for length, members in by_length.items():
        joined = b"".join(payloads[row] for row in members)
        data = np.array(memoryview(joined), np.uint8).reshape(len(members), length)
        rows = np.array(members)
        while len(rows):
            spans = codec.spans(payloads[rows[0]])
            alike = _alike(data, spans)
            _fill(table, rows[alike], data[alike], spans)
            rows, data = rows[~alike], data[~alike]
    return table


def _alike(data: NDArray[np.uint8], spans: dict[str, tuple[int, int]]) -> NDArray[np.bool_]:
    """Return which messages (rows of bytes) have the same layout as the first one.

    `spans` are the offsets of the values in the first. All bytes between them, which are tags and
    lengths, must agree.
    """
    between = np.ones(data.shape[1], dtype=np.bool_)
    for at, size in spans.values():
        between[at : at + size] = False
    tags = data[:, between]
    return np.asarray((tags == tags[0]).all(axis=1))


def _fill(
    table: Table,
    rows: NDArray[np.int64],
    data: NDArray[np.uint8],
    spans: dict[str, tuple[int, int]],
) -> None:
    """Put messages of one layout into their rows of the table."""
    for name, (at, size) in spans.items():
        dtype = table[name].dtype
        values = np.ascontiguousarray(data[:, at : at + size]).view(dtype)
        if table[name].ndim == 1:
            table[name][rows] = values[:, 0]
            continue
        if table[name].shape[1] == 0:
            table[name] = np.zeros((len(table[name]), values.shape[1]), dtype)
        if values.shape[1] not in {0, table[name].shape[1]}:
            raise ValueError(f"field {name} differs in length from message to message")
        table[name][rows] = values if values.shape[1] else 0
