"""The trials of a search on disk: an SQLite database of Optuna's."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Final

import optuna
from optuna.exceptions import OptunaError
from optuna.storages import RDBStorage
from sqlalchemy.exc import SQLAlchemyError

from zenvoy.fleet.requests import requests_held
from zenvoy.studies.sweeps.errors import bad_study
from zenvoy.studies.tuning.search import as_frozen
from zenvoy.studies.tuning.study import TuneStudy
from zenvoy.studies.tuning.trial import Trial

TRIALS: Final = "trials.db"
_NAME: Final = "zenvoy"
_KEPT: Final = "zenvoy"


class Trials:
    """The finished trials in a folder. Each is written in one transaction, once it is finished."""

    def __init__(self, folder: Path, study: TuneStudy) -> None:
        """Open the database, or make it; raises BadStudyError if it cannot be read."""
        self._study = study
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        try:
            with requests_held():
                # The path is no part of the URL, in which some of its characters have a meaning.
                connect = partial(sqlite3.connect, folder / TRIALS)
                self._storage = RDBStorage(
                    f"sqlite:///{TRIALS}", engine_kwargs={"creator": connect}
                )
                self._kept = optuna.create_study(
                    storage=self._storage,
                    study_name=_NAME,
                    direction=study.direction,
                    load_if_exists=True,
                )
            self.finished = [_read(number, one) for number, one in enumerate(self._frozen(), 1)]
        except (OptunaError, SQLAlchemyError, RuntimeError, LookupError, ValueError) as error:
            raise bad_study("", f"{folder / TRIALS}: cannot be read: {_line(error)}") from None

    def add(self, trial: Trial) -> None:
        """Keep a finished trial; raises OSError."""
        frozen = as_frozen(self._study, trial)
        kept = {"point": trial.point, "figures": dict(trial.figures), "failure": trial.failure}
        frozen.set_user_attr(_KEPT, json.dumps(kept))
        try:
            with requests_held(), self._closed_afterwards():
                self._kept.add_trial(frozen)
        except (OptunaError, SQLAlchemyError) as error:
            raise OSError(f"{TRIALS}: {_line(error)}") from error
        self.finished.append(trial)

    def _frozen(self) -> list[optuna.trial.FrozenTrial]:
        with self._closed_afterwards():
            return self._kept.get_trials()

    @contextmanager
    def _closed_afterwards(self) -> Iterator[None]:
        """Close the database on exit, because a forked process must not share it."""
        try:
            yield
        finally:
            self._storage.remove_session()
            self._storage.engine.dispose()


def _read(number: int, frozen: optuna.trial.FrozenTrial) -> Trial:
    kept = json.loads(frozen.user_attrs[_KEPT])
    return Trial(
        number=number,
        point=kept["point"],
        figures={name: tuple(values) for name, values in kept["figures"].items()},
        failure=kept["failure"],
    )


def _line(error: Exception) -> str:
    """Return the first line of a message: the others are SQL and links."""
    return (str(error).splitlines() or [type(error).__name__])[0]
