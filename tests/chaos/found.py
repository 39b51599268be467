"""The observed ends of cases, and a table of them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from tests.chaos.cases import Case


@dataclass(slots=True)
class Found:
    """The observed end of a case: what is wrong, its duration, and what the log has lost, s."""

    case: Case
    wrong: list[str] = field(default_factory=list)
    took_s: float = 0.0
    lost_s: float = 0.0
    code: int = 0
    message: str = ""
    """The first line on stderr."""
    times: int = 1
    """How many times as long as usual the run is."""


def table(results: Sequence[Found]) -> str:
    """Return a row for each victim, signal and mode: runs, exit codes, time, loss, wrong ends."""
    rows: dict[tuple[str, str, str], list[Found]] = defaultdict(list)
    for one in results:
        rows[one.case.victim, one.case.blow, one.case.mode].append(one)
    lines = ["victim   signal    mode      runs  took s  lost s  wrong  exit codes"]
    for (victim, blow, mode), found in sorted(rows.items()):
        codes = [one.code for one in found]
        exits = ", ".join(f"{code}: {codes.count(code)}" for code in sorted(set(codes)))
        took_s = max((one.took_s for one in found if one.code), default=0.0)
        lost_s = max(one.lost_s for one in found)
        wrong = sum(bool(one.wrong) for one in found)
        lines.append(
            f"{victim:8} {blow:9} {mode:9} {len(found):4} {took_s:7.2f} {lost_s:7.2f} {wrong:6}  "
            + exits
        )
    return "\n".join(lines)
