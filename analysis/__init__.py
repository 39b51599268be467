"""Analysis of runs: logs as arrays, measures, linear theory, and the chapters of a report."""

from zenvoy.analysis.log.arrays import LogError, read_events, read_facts, read_fleet, read_frames
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.measures.summary import summarize

__all__ = [
    "LogError",
    "Run",
    "load",
    "read_events",
    "read_facts",
    "read_fleet",
    "read_frames",
    "summarize",
]
