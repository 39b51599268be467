"""The lines on the progress of a run, where no terminal shows a bar."""

from __future__ import annotations

from io import StringIO

from rich.console import Console

from zenvoy.cli.progress import RunProgress
from zenvoy.fleet.progress import Progress

HELD_UP = "vehicles 5-8 on beta held up 100 % of the steps, by 93 ms each"


def lines(*notes: str) -> list[str]:
    """Return a line for each note, printed 10 s of wall time after the one before."""
    console = Console(file=StringIO(), width=200)
    with RunProgress(console, "s", 100.0) as shown:
        for number, note in enumerate(notes, start=1):
            shown.note(note)
            wall_s = 10.0 * number
            shown.show(
                Progress(time_s=number, duration_s=100.0, wall_s=wall_s, real_time_factor=0.1)
            )
    assert isinstance(console.file, StringIO)
    return console.file.getvalue().splitlines()


def test_lines_name_a_machine_only_while_it_holds_up_the_run() -> None:
    assert lines("", HELD_UP, "") == [
        "1.0 of 100 s, 0.1 × real time, 990 s left",
        f"2.0 of 100 s, 0.1 × real time, 980 s left; {HELD_UP}",
        "3.0 of 100 s, 0.1 × real time, 970 s left",
    ]
