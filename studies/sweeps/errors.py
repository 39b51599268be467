"""The errors of a user's own study."""

from __future__ import annotations

from zenvoy.scenarios import Place, Problem, ScenarioError
from zenvoy.studies.study import StudyError


class BadStudyError(ScenarioError):
    """A study is not valid, or its folder holds something else. Nothing was run."""


class ClusterError(StudyError):
    """A Dask cluster no longer makes the runs; finished runs are kept."""


class NoClusterError(ClusterError):
    """There is no Dask cluster that could make the runs. Nothing was run."""


def bad_study(key: str, text: str, place: Place | None = None) -> BadStudyError:
    """Return the error of a single problem."""
    return BadStudyError([Problem(key=key, text=text, place=place)])
