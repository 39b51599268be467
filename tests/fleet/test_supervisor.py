"""The supervisor names every process that ends, and how it ended."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from tests.conftest import wait_until
from zenvoy.bus.errors import StalledError, StoppedError
from zenvoy.fleet.ends import Death
from zenvoy.fleet.interruption import Interrupted
from zenvoy.fleet.spawn import Program
from zenvoy.fleet.supervisor import Supervisor


def wait_forever() -> None:
    """Do nothing until a signal ends it."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGTERM,))
    while True:
        signal.pause()


def fail_with(error: BaseException) -> None:
    """Raise an error."""
    raise error


def watched(folder: Path, *mains: Callable[[], None], essential: bool = True) -> Death | None:
    """Return the death that ends a run of a leader that waits forever, and of others."""
    programs = [Program(name="world", run="r", main=wait_forever)]
    for number, main in enumerate(mains, start=1):
        programs.append(
            Program(name=f"vehicle-{number:02d}", run="r", main=main, essential=essential)
        )
    return death_of(folder, programs)[0]


def death_of(folder: Path, programs: list[Program]) -> tuple[Death | None, list[Death], bool]:
    """Return the death that ends a run, the other deaths, and whether the leader was done."""
    read_fd, write_fd = os.pipe()
    losses: list[Death] = []
    supervisor = Supervisor(programs, folder, stall_limit_s=60.0)
    try:
        with supervisor:
            death = supervisor.watch(read_fd, lambda _: True, losses.append)
    finally:
        os.close(read_fd)
        os.close(write_fd)
    return death, losses, supervisor.completed


def test_a_process_that_exits_with_0_before_its_work_is_done_has_died(tmp_path: Path) -> None:
    death = watched(tmp_path, partial(os._exit, 0))
    assert death is not None
    assert (str(death), death.refused) == ("vehicle-01 died: exit status 0", False)


def test_an_error_of_a_process_is_shown_with_the_tail_of_its_log(tmp_path: Path) -> None:
    death = watched(tmp_path, partial(fail_with, ValueError("a mistake")))
    assert death is not None
    assert (str(death), death.refused) == ("vehicle-01 died: exit status 1", False)
    assert death.tail[-1] == "ValueError: a mistake"


def test_a_shortage_is_reported_in_one_line(tmp_path: Path) -> None:
    error = OSError(28, "No space left on device", "/disk/run.mcap")
    death = watched(tmp_path, partial(fail_with, error))
    expected = "vehicle-01 cannot go on: No space left on device: /disk/run.mcap"
    assert death == Death("vehicle-01", expected.partition(" ")[2], refused=True)


def test_a_process_that_is_asked_to_end_by_somebody_else_has_died(tmp_path: Path) -> None:
    death = watched(tmp_path, partial(fail_with, StoppedError("asked to end")))
    assert str(death) == "vehicle-01 died: ended by SIGTERM"


def test_the_process_that_others_wait_for_is_blamed(tmp_path: Path) -> None:
    error = StalledError("no progress for 5 s, waiting for beacon of vehicle 2", ("vehicle-02",))
    death = watched(tmp_path, partial(fail_with, error), wait_forever)
    assert str(death) == (
        "vehicle-02 stalled: vehicle-01 has made no progress for 5 s, "
        "waiting for beacon of vehicle 2"
    )


def test_a_process_that_died_is_blamed_before_those_that_wait(tmp_path: Path) -> None:
    """The supervisor sees both at once, since it looks after both have ended."""
    waits = partial(fail_with, StalledError("no progress", ("vehicle-03",)))
    programs = [
        Program(name="world", run="r", main=wait_forever),
        Program(name="vehicle-01", run="r", main=waits),
        Program(name="vehicle-02", run="r", main=partial(os._exit, 7)),
    ]
    read_fd, write_fd = os.pipe()
    with Supervisor(programs, tmp_path, stall_limit_s=60.0) as supervisor:
        for child in list(supervisor._children.values())[1:]:
            os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
        death = supervisor.watch(read_fd, lambda _: False, lambda _: None)
    os.close(read_fd)
    os.close(write_fd)
    assert str(death) == "vehicle-02 died: exit status 7"


def end_after(path: Path) -> None:
    """Wait until a file is there, and end with status 7."""
    wait_until(path.exists, f"{path.name} is there")
    os._exit(7)


@pytest.mark.parametrize(("begun", "blamed"), [(True, "world"), (False, "vehicle-01")])
def test_a_run_that_has_not_begun_does_not_go_on_without_a_process(
    tmp_path: Path, begun: bool, blamed: str
) -> None:
    """In real time too it waits for all, and the first news are of those who have come."""
    reported, lost = tmp_path / "reported", tmp_path / "lost"
    programs = [
        Program(name="world", run="r", main=partial(end_after, lost)),
        Program(name="vehicle-01", run="r", main=partial(end_after, reported), essential=False),
    ]

    def begins(data: bytes) -> bool:
        reported.touch()
        return begun and data == b"news"

    read_fd, write_fd = os.pipe()
    os.write(write_fd, b"news")
    with Supervisor(programs, tmp_path, stall_limit_s=60.0) as supervisor:
        death = supervisor.watch(read_fd, begins, lambda _: lost.touch())
    os.close(read_fd)
    os.close(write_fd)
    assert str(death) == f"{blamed} died: exit status 7"
    assert lost.exists() == begun


def test_no_process_has_died_once_the_leader_is_done(tmp_path: Path) -> None:
    programs = [
        Program(name="world", run="r", main=lambda: None),
        Program(name="vehicle-01", run="r", main=wait_forever),
    ]
    assert death_of(tmp_path, programs) == (None, [], True)


def test_an_interrupted_run_knows_whether_its_leader_still_finished(tmp_path: Path) -> None:
    """The world may be about to finish the log when the request to end comes."""

    def finish_when_asked() -> None:
        signal.sigwait({signal.SIGTERM})

    world = Program(name="world", run="r", main=finish_when_asked)
    supervisor = Supervisor([world], tmp_path, stall_limit_s=60.0)
    with pytest.raises(KeyboardInterrupt), supervisor:
        raise KeyboardInterrupt
    assert supervisor.completed
    message = [str(Interrupted(complete=complete)) for complete in (True, False)]
    assert message == [
        "interrupted; the run was complete by then",
        "interrupted; the log up to here is kept",
    ]


def test_a_run_that_has_not_begun_needs_every_process(tmp_path: Path) -> None:
    """In real time a fleet goes on without a vehicle, but does not start without one."""
    death = watched(tmp_path, partial(os._exit, 7), essential=False)
    assert str(death) == "vehicle-01 died: exit status 7"


def test_a_parent_that_ignores_sigchld_changes_nothing(tmp_path: Path) -> None:
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        death = watched(tmp_path, partial(os._exit, 7))
    finally:
        signal.signal(signal.SIGCHLD, before)
    assert str(death) == "vehicle-01 died: exit status 7"


def test_a_process_that_kills_itself_as_planned_is_replaced(tmp_path: Path) -> None:
    second = Program(name="vehicle-01", run="r", main=partial(os._exit, 0))
    first = Program(
        name="vehicle-01", run="r", main=lambda: None, killed_with="planned", successor=second
    )
    world = Program(name="world", run="r", main=wait_forever)
    death, losses, _ = death_of(tmp_path, [world, first])
    assert (str(death), losses) == ("vehicle-01 died: exit status 0", [])  # the second one's
    assert sorted(path.name for path in tmp_path.glob("vehicle-*")) == [
        "vehicle-01-2.log",
        "vehicle-01.log",
    ]


def test_a_process_that_is_killed_before_it_is_to_die_has_died(tmp_path: Path) -> None:
    def killed() -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    world = Program(name="world", run="r", main=wait_forever)
    doomed = Program(name="vehicle-01", run="r", main=killed, killed_with="planned")
    death, losses, _ = death_of(tmp_path, [world, doomed])
    assert (str(death), losses) == ("vehicle-01 died: killed by SIGKILL", [])


def alarmed() -> None:
    """End as a process does that has no time left to end."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.raise_signal(signal.SIGALRM)


@pytest.mark.parametrize(
    ("at_end", "expected"),
    [
        (partial(fail_with, StoppedError("asked to end")), []),
        (partial(fail_with, ValueError("a mistake")), ["world died: exit status 1"]),
        (alarmed, ["world was killed, because it did not end in time"]),
    ],
    ids=["finished", "error", "alarm"],
)
def test_a_leader_that_cannot_finish_is_named(
    tmp_path: Path, at_end: Callable[[], None], expected: list[str]
) -> None:
    def lead() -> None:
        signal.sigwait({signal.SIGTERM})
        at_end()

    programs = [
        Program(name="world", run="r", main=lead),
        Program(name="channel", run="r", main=partial(fail_with, ValueError("not reported"))),
    ]
    supervisor = Supervisor(programs, tmp_path, stall_limit_s=60.0)
    with pytest.raises(KeyboardInterrupt), supervisor:
        raise KeyboardInterrupt
    assert [str(one) for one in supervisor.bad_ends] == expected
