"""The folder of a search: it belongs to one study, and to one process at a time."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from zenvoy.scenarios import COMMAND_LINE, Spelling
from zenvoy.studies.sweeps.errors import bad_study
from zenvoy.studies.sweeps.store import make_folder


@contextmanager
def held(folder: Path, spelling: Spelling = COMMAND_LINE) -> Iterator[None]:
    """Make a folder if it does not exist, and keep other searches out of it.

    The lock ends with the process, in whatever way that ends. Raises BadStudyError if another
    search is running in the folder, or if it is a file.
    """
    make_folder(folder, spelling)
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            text = f"{spelling.option('out', folder)}: another zenvoy tune is at work there;"
            raise bad_study("", f"{text} wait for its end") from None
        yield
    finally:
        os.close(handle)
