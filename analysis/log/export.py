"""Exports a run as Parquet or CSV files, one per topic, for any tool that reads tables."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
from numpy.typing import NDArray

from zenvoy.analysis.log.cells import harmless
from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.log.units import UNITS
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import CLOCK, ESTIMATE, FLEET_COMMAND, FRAMES, LOGGED, RADAR, TRUTH, Topic

Form = Literal["parquet", "csv"]

_FLEET: Final = (TRUTH, RADAR, ESTIMATE, FLEET_COMMAND)
_SUFFIX: Final = {"m": "_m", "m/s": "_mps", "m/s²": "_mps2"}  # names of times end in their unit
# Columns in which a number below 0 stands for "never".
_NULL_BELOW_0: Final = frozenset(
    {"arrived_ns", "latency_ns", "age_ns", "ahead_measured_ns", "behind_measured_ns"}
)
_ENUMS: Final = {"mode": "Mode", "outcome": "Outcome", "kind": "EventKind"}
_ROWS_AT_ONCE: Final = 1 << 20  # also the size of Parquet's row groups


class ExportError(Exception):
    """A file cannot be written."""


def export(run: Run, folder: Path, form: Form) -> list[Path]:
    """Write a file per topic of the log into `folder`, and return the files in order of topic.

    Fleet topics have a row per cycle and vehicle: `cycle`, `time_s`, `vehicle`, then the columns of
    messages.proto with their unit in the name (`speed_mps`). Frames have a row per frame and
    receiver. In Parquet the unit is also metadata of the column. Modes, outcomes and kinds of
    events are words. Values that were not measured or never arrived are null. Existing files are
    replaced once all new ones are written. Raises ExportError, and LogError where the log has
    changed.
    """
    parts: list[tuple[Path, Path]] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for topic in LOGGED:
            name = topic.log_name.rsplit("/", 1)[-1]
            part = folder / f".{name}.{form}.{os.getpid()}.part"
            parts.append((part, folder / f"{name}.{form}"))
            _write(part, form, _pieces(run, topic))
        for _, file in parts:
            if file.is_dir():
                raise IsADirectoryError(0, f"{file.name} is a folder")
        for part, file in parts:
            part.replace(file)
    except OSError as error:
        raise ExportError(f"{folder}: {error.strerror or error}") from error
    finally:
        for part, _ in parts:
            with suppress(OSError):
                part.unlink(missing_ok=True)
    return [file for _, file in parts]


def _write(path: Path, form: Form, pieces: Iterator[pa.Table]) -> None:
    if form == "csv":
        pieces = map(_harmless, pieces)
    first = next(pieces)
    if form == "csv":
        writer = pyarrow.csv.CSVWriter(path, first.schema)
    else:
        writer = pyarrow.parquet.ParquetWriter(path, first.schema, compression="zstd")
    with writer:
        writer.write_table(first)
        for piece in pieces:
            writer.write_table(piece)


def _harmless(table: pa.Table) -> pa.Table:
    """Return the table with its texts escaped for CSV."""
    for number, field in enumerate(table.schema):
        if pa.types.is_string(field.type):
            texts = [harmless(text) for text in table.column(number).to_pylist()]
            table = table.set_column(number, field, pa.array(texts, pa.string()))
    return table


def _pieces(run: Run, topic: Topic[Any]) -> Iterator[pa.Table]:
    """Yield the table of a topic in pieces of bounded size."""
    if topic is FRAMES:
        frames = run.frames
        for start in range(0, max(1, run.frame_rows), _ROWS_AT_ONCE):
            rows = slice(start, start + _ROWS_AT_ONCE)
            yield _frames({name: column[rows] for name, column in frames.items()})
    elif topic is CLOCK:
        yield _table({**_times(run.clock), **_columns(topic, run.clock)})
    elif topic in _FLEET:
        yield _fleet(run, topic)
    else:
        yield _events(run.events)


def _fleet(run: Run, topic: Topic[Any]) -> pa.Table:
    """Return a table with a row per cycle and vehicle; vehicles vary fastest."""
    table, n = run[topic.log_name], run.vehicles
    times = {name: np.repeat(column, n) for name, column in _times(table).items()}
    rows = len(times["cycle"])
    vehicle = np.tile(np.arange(1, n + 1, dtype=np.uint32), rows // n)
    columns = {
        name: column.ravel() if column.size == rows else np.zeros(0, column.dtype)
        for name, column in _columns(topic, table).items()
    }
    if topic is not ESTIMATE:
        return _table({**times, "vehicle": vehicle, **columns}, rows)
    names = {law.mode: law.name for _, law in sorted(run.laws.items())}
    units = run.units[ESTIMATE.log_name]
    return _table({**times, "vehicle": vehicle, **columns}, rows, units, names)


def _frames(frames: Table) -> pa.Table:
    sent: Table = {"cycle": frames["cycle"], "time_s": frames["sent_ns"] / 1e9}
    return _table({**sent, **frames})


def _events(events: Sequence[pb.Event]) -> pa.Table:
    columns: Table = {
        "cycle": np.array([event.cycle for event in events], np.uint32),
        "time_s": np.array([event.time_ns for event in events], np.int64) / 1e9,
        "kind": np.array([event.kind for event in events], np.uint8),
    }
    vehicle = [event.vehicle or None for event in events]
    text = [event.text for event in events]
    table = _table(columns)
    table = table.append_column("vehicle", pa.array(vehicle, pa.uint32()))
    return table.append_column("text", pa.array(text, pa.string()))


def _times(table: Table) -> Table:
    """Return the columns of time that every file begins with."""
    cycle = table.get("cycle", np.zeros(0, np.uint32))
    return {"cycle": cycle, "time_s": table.get("time_ns", np.zeros(0, np.int64)) / 1e9}


def _columns(topic: Topic[Any], table: Table) -> Table:
    """Return the columns of a topic except its times; they are empty where there is no table."""
    fields = PackedCodec(topic.message.DESCRIPTOR).fields()
    left_out = {"cycle", "time_ns", "logged"}  # values that laws log have columns of their own
    known = {name: table.get(name, np.zeros(0, of)) for name, (of, _) in fields.items()}
    return {name: column for name, column in (known | table).items() if name not in left_out}


def _table(
    columns: Table,
    rows: int | None = None,
    units: Mapping[str, str] | None = None,
    laws: Mapping[int, str] | None = None,
) -> pa.Table:
    """Return an Arrow table of columns by their names in the log; an empty column becomes nulls.

    `laws` are the names of the laws, by mode.
    """
    fields, arrays = [], []
    for name, column in columns.items():
        array = _array(name, column, laws or {})
        if rows and not len(array):
            array = pa.nulls(rows, array.type)
        unit = "s" if name == "time_s" else (units or _UNIT).get(name, "")
        metadata = {"unit": unit} if unit else None
        fields.append(pa.field(name + _SUFFIX.get(unit, ""), array.type, metadata=metadata))
        arrays.append(array)
    return pa.table(arrays, schema=pa.schema(fields))


def _array(name: str, column: NDArray[Any], laws: Mapping[int, str]) -> pa.Array:
    """Return a column with words in place of enums, and nulls for missing values."""
    if name in _ENUMS:
        kinds = pb.DESCRIPTOR.enum_types_by_name[_ENUMS[name]].values
        # The prefix MODE_, OUTCOME_ or EVENT_ is dropped.
        words = {kind.number: kind.name.split("_", 1)[1] for kind in kinds}
        if name == "mode":
            del words[pb.MODE_OWN]
            words |= laws
        codes = np.searchsorted(list(words), column).astype(np.int8)
        return pa.DictionaryArray.from_arrays(codes, list(words.values()))
    if name in _NULL_BELOW_0:
        return pa.array(column, mask=column < 0)
    return pa.array(column, from_pandas=True)  # NaN is null


_UNIT: Final = {name: unit for columns in UNITS.values() for name, unit in columns.items()}
