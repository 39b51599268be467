"""The folder of a sweep: its study, and the results of each finished run."""

from __future__ import annotations

import json
import os
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.arrays import as_json
from zenvoy.analysis.measures.summary import Summary
from zenvoy.bus.text import utf8
from zenvoy.scenarios import Spelling
from zenvoy.studies.sweeps.errors import bad_study
from zenvoy.studies.sweeps.study_file import StudyFile
from zenvoy.values.wording import listed

STUDY: Final = "study.yaml"
_IDENTITY: Final = "study.json"
_RUNS: Final = "runs"

_FORMS: Final = ("npz", "json")  # the summary comes last, because it marks a run as finished

Floats = NDArray[np.float64]

Files = Mapping[str, bytes]
"""The files of a run by their form: its summary, `json`, and its time series, `npz`, if any."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Store:
    """The runs of a sweep by their keys. Each is written whole or not at all."""

    folder: Path

    def has(self, key: str, study: StudyFile) -> bool:
        """Return whether a run is finished, with all measures and time series of the study."""
        summary = self.summary(key)
        if summary is None or (study.needs_log and summary.get("frames") is None):
            return False
        return not study.series or self.series(key, study.series) is not None

    def summary(self, key: str) -> Summary | None:
        """Return the summary of a run; None if it is not finished, or its file is damaged."""
        try:
            found = json.loads(self._path(key, "json").read_bytes())
        except (OSError, ValueError):
            return None
        return found if isinstance(found, dict) else None

    def series(self, key: str, names: tuple[str, ...]) -> dict[str, Floats] | None:
        """Return `time_s` and time series of a run, (T,) each; None if they are not all there."""
        try:
            with self._path(key, "npz").open("rb") as file, np.load(file) as stored:
                return {name: stored[name] for name in ("time_s", *names)}
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
            return None

    def write(self, key: str, summary: Summary, series: Mapping[str, Any]) -> None:
        """Keep a run; raises OSError."""
        files = {}
        if series:
            buffer = BytesIO()
            np.savez_compressed(buffer, **dict(series))
            files["npz"] = buffer.getvalue()
        self.put(key, files | {"json": utf8(as_json(summary))})

    def files(self, key: str) -> Files | None:
        """Return the files of a run, for another store; None if it is not finished."""
        try:
            summary = self._path(key, "json").read_bytes()
            series = self._path(key, "npz")
            return {"json": summary} | ({"npz": series.read_bytes()} if series.exists() else {})
        except OSError:
            return None

    def put(self, key: str, files: Files) -> None:
        """Keep a run, given by the files of another store; raises OSError."""
        for form in _FORMS:
            if form in files:
                partial = self._partial(key, form)
                partial.write_bytes(files[form])
                os.replace(partial, self._path(key, form))

    def _path(self, key: str, form: str) -> Path:
        return self.folder / _RUNS / f"{key}.{form}"

    def _partial(self, key: str, form: str) -> Path:
        return self.folder / _RUNS / f".{key}.{form}.{os.getpid()}.partial"


def open_store(folder: Path, study: StudyFile) -> Store:
    """Make the folder of a study, or open it again to resume the study.

    The same study may have more values, seeds, measures or time series than before. Raises
    BadStudyError if the folder holds anything else, which is left as it is, and OSError.
    """
    open_folder(folder, _identity(study), study.text, study.spelling)
    return Store(folder=folder)


def open_folder(folder: Path, identity: Mapping[str, Any], text: str, spelling: Spelling) -> None:
    """Make the folder of a study, or check that it holds the same study, and write its text.

    Two studies with the same `identity` are the same. Raises BadStudyError if the folder holds
    anything else, which is left as it is, and OSError.
    """
    make_folder(folder, spelling)
    out = spelling.option("out", folder)
    if holds := sorted(path.name for path in folder.iterdir()):
        before = _read(folder / _IDENTITY)
        if before is None:
            text = f"{out}: holds no study, but {listed(holds)};"
            raise bad_study("", f"{text} name a new folder or an empty one")
        if differing := [name for name, value in identity.items() if before.get(name) != value]:
            text = f"{out}: holds another study ({', '.join(differing)} differ);"
            raise bad_study("", f"{text} name a new folder or an empty one")
    new_store(folder)
    _write_whole(folder / _IDENTITY, json.dumps(identity, indent=2) + "\n")
    _write_whole(folder / STUDY, text)


def make_folder(folder: Path, spelling: Spelling) -> None:
    """Make a folder if it does not exist; raises BadStudyError if it is a file, and OSError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        text = f"{spelling.option('out', folder)}: is a file, not a folder"
        raise bad_study("", text) from None


def new_store(folder: Path) -> Store:
    """Return a store in a folder, which is made if it does not exist; raises OSError."""
    (folder / _RUNS).mkdir(parents=True, exist_ok=True)
    return Store(folder=folder)


def _identity(study: StudyFile) -> dict[str, Any]:
    """Return the values that stay the same when a study grows."""
    return {
        "scenario": Path(study.scenario).name if Path(study.scenario).is_file() else study.scenario,
        "settings": sorted(study.settings),
        "axes": list(study.axes),
        "duration_s": study.duration_s,
    }


def _read(path: Path) -> dict[str, Any] | None:
    try:
        found = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def _write_whole(path: Path, text: str) -> None:
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    partial.write_bytes(utf8(text))
    os.replace(partial, path)
