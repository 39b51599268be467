"""`zenvoy sweep --dask` gives the same table as local cores, even if a worker dies."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import command, wait_until, zenvoy
from tests.dask_cluster import DaskCluster, dask_cluster
from tests.idm import IDM
from zenvoy.studies.sweeps.errors import BadStudyError, NoClusterError
from zenvoy.studies.sweeps.sweep import run_sweep

# A worker gets everything from the caller: a scenario that extends another one and reads a trace,
# and a law elsewhere with a module beside it, which fails in one of the cells.
SCENARIO: Final = """
extends: base.yaml
events: [{type: trace, vehicle: 1, at_s: 0, file: drive.csv}]
control: {model: "../laws/idm.py:smith"}
"""
BASE: Final = """
extends: quickstart
fleet: {size: 4}
road: {type: open}
"""
LIMITS: Final = "def too_close(seen, p):\n    return p.headway_s < 1.1 and seen.speed < 29.0\n"
LINE: Final = "    v, gap = "
FAILING: Final = "    if too_close(seen, p):\n        raise RuntimeError('too close')\n"
STUDY: Final = """
scenario: s.yaml
duration_s: 3
axes: {control.parameters.headway_s: [1.0, 1.6]}
seeds: 4
measures: [frames.lost]
series: [mean_speed_mps]
"""
COMMAND: Final = ("sweep", "study/study.yaml", "--allow-code", "--out")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the study, which local cores have run into `local`."""
    folder = tmp_path_factory.mktemp("dask")
    for name in ("study", "laws", "cluster"):
        (folder / name).mkdir()
    (folder / "study" / "study.yaml").write_text(STUDY)
    (folder / "study" / "s.yaml").write_text(SCENARIO)
    (folder / "study" / "base.yaml").write_text(BASE)
    (folder / "study" / "drive.csv").write_text("time_s,speed_mps\n0,30\n1,30\n3,26\n")
    law = IDM.replace(LINE, FAILING + LINE)
    (folder / "laws" / "idm.py").write_text(f"from limits import too_close\n{law}")
    (folder / "laws" / "limits.py").write_text(LIMITS)
    outcome = zenvoy(folder, *COMMAND, "local")
    assert outcome.code == 1
    assert outcome.err == "4 of 8 runs failed; see local/README.md\n"
    return folder


@pytest.fixture(scope="module")
def cluster(folder: Path) -> Iterator[DaskCluster]:
    with dask_cluster(folder / "cluster", workers=2) as started:
        yield started


def finished(out: Path) -> int:
    return len(list((out / "runs").glob("[!.]*.json")))


def test_stops_and_dead_workers_leave_the_table_of_local_cores(
    folder: Path, cluster: DaskCluster
) -> None:
    arguments = (*COMMAND, "out", "--dask", cluster.address)
    with command(folder, *arguments) as sweeping:
        wait_until(lambda: finished(folder / "out") >= 1, "a run is done")
        sweeping.send_to_group(signal.SIGINT)
        outcome = sweeping.wait()
    assert (outcome.code, outcome.err) == (130, "interrupted; the finished runs are kept\n")
    done = finished(folder / "out")
    with command(folder, *arguments) as sweeping:
        wait_until(lambda: finished(folder / "out") > done, "one more run is done")
        cluster.workers[0].kill()
        outcome = sweeping.wait()
    assert outcome.code == 1
    assert outcome.err == "4 of 8 runs failed; see out/README.md\n"
    assert f"8 runs, {8 - done} to do\n" in outcome.out
    line = (
        r"headway_s=1.0, seed 2 failed: vehicle-\d\d died: law Smith raised RuntimeError: too close"
    )
    assert re.search(line, outcome.out)
    for name in ("table.parquet", "series.parquet", "means.csv", "frames.lost.svg"):
        same = (folder / "local" / name).read_bytes()
        assert (folder / "out" / name).read_bytes() == same, name


def test_few_tasks_are_in_flight(folder: Path, cluster: DaskCluster) -> None:
    """In a process of its own, as Dask's client has threads."""
    script = f"""if True:
        from pathlib import Path
        from zenvoy.studies.sweeps.cluster.crew import cluster_at
        from zenvoy.studies.sweeps.plan import plan_of
        from zenvoy.studies.sweeps.store import open_store
        from zenvoy.studies.sweeps.study_file import read_study
        from zenvoy.studies.sweeps.tasks import missing_tasks
        study = read_study({{
            "scenario": "quickstart",
            "engine": "in-process",
            "duration_s": 0.1,
            "settings": {{"fleet.size": 3, "events": []}},
            "axes": {{"channel.loss.p": [0]}},
            "seeds": 24,
        }})
        plan, store = plan_of(study), open_store(Path("many"), study)
        tasks = missing_tasks(plan, store, 1)
        assert len(tasks) == 24
        taken = []
        done = []
        def counted():
            for task in tasks:
                taken.append(task)
                yield task
        with cluster_at({cluster.address!r}, print) as crew:
            for one in crew.each_done(counted(), plan, store):
                assert one.failure is None, one.failure
                assert len(taken) - len(done) <= crew.most_in_flight == 8
                done.append(one.task)
        assert sorted(map(str, done)) == sorted(map(str, tasks))
        assert all(store.has(task.key, study) for task in tasks)
    """
    outcome = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=False
    )
    assert (outcome.returncode, outcome.stderr) == (0, "")


def test_dead_workers_and_a_lost_scheduler_are_told(folder: Path, tmp_path: Path) -> None:
    with dask_cluster(tmp_path, workers=2, allowed_failures=0) as cluster:
        with command(folder, *COMMAND, "told", "--dask", cluster.address) as sweeping:
            wait_until(lambda: finished(folder / "told") >= 1, "a run is done")
            cluster.workers[0].kill()
            outcome = sweeping.wait()
        assert outcome.code == 1
        assert re.search(
            r"failed: its Dask worker died 1 time; the last one was tcp://127", outcome.out
        )
        with command(folder, *COMMAND, "lost", "--dask", cluster.address) as sweeping:
            wait_until(lambda: finished(folder / "lost") >= 1, "a run is done")
            cluster.scheduler.kill()
            outcome = sweeping.wait()
    lost = f"the sweep cannot go on: the Dask scheduler at {cluster.address} is lost\n"
    assert (outcome.code, outcome.err) == (1, lost)
    assert 1 <= finished(folder / "lost") < 8


def test_a_scheduler_lost_before_its_answer_is_fetched_is_told(
    folder: Path, tmp_path: Path
) -> None:
    """The task is done, and its answer is still at the worker when the scheduler dies."""
    script = """if True:
        import os, signal, sys
        from pathlib import Path
        from dask.distributed import Client
        from zenvoy.studies.sweeps.cluster.crew import cluster_at
        from zenvoy.studies.sweeps.errors import ClusterError
        from zenvoy.studies.sweeps.plan import plan_of
        from zenvoy.studies.sweeps.store import open_store
        from zenvoy.studies.sweeps.study_file import read_study
        from zenvoy.studies.sweeps.tasks import missing_tasks
        address, scheduler = sys.argv[1], int(sys.argv[2])
        study = read_study({
            "scenario": "quickstart",
            "engine": "in-process",
            "duration_s": 0.1,
            "settings": {"fleet.size": 3, "events": []},
            "axes": {"channel.loss.p": [0]},
            "seeds": 1,
        })
        plan, store = plan_of(study), open_store(Path("fetched"), study)
        def states(dask_scheduler):
            return [task.state for task in dask_scheduler.tasks.values()]
        def then_lost():
            yield from missing_tasks(plan, store, 1)
            with Client(address, set_as_default=False) as observer:
                while observer.run_on_scheduler(states) != ["memory"]:
                    pass
                os.kill(scheduler, signal.SIGKILL)
        with cluster_at(address, print) as crew:
            try:
                list(crew.each_done(then_lost(), plan, store))
            except ClusterError as error:
                print(error)
    """
    with dask_cluster(tmp_path, workers=1) as cluster:
        command = [sys.executable, "-c", script, cluster.address, str(cluster.scheduler.pid)]
        outcome = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    lost = f"the Dask scheduler at {cluster.address} is lost"
    assert outcome.stdout.splitlines()[-1:] == [lost], outcome.stderr


def test_an_address_without_a_scheduler_ends_with_a_line(folder: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answering() -> None:
            while True:
                try:
                    connection, _ = server.accept()
                except OSError:
                    return
                connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")
                connection.close()

        thread = threading.Thread(target=answering)
        thread.start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        outcome = zenvoy(folder, *COMMAND, "nobody", "--dask", address)
        server.shutdown(socket.SHUT_RDWR)
        thread.join()
    assert outcome.code == 2
    assert outcome.err == f"--dask {address}: no Dask scheduler answers there\n"
    assert not (folder / "nobody").exists()


def refused(folder: Path, **options: int) -> str:
    """Return why a sweep is refused."""
    study = {"scenario": "quickstart", "axes": {"channel.loss.p": [0]}}
    jobs = options.get("jobs")
    with pytest.raises((BadStudyError, NoClusterError)) as error:
        run_sweep(study, out=folder / "o", jobs=jobs, on_line=print, command="c", dask="tcp://x:1")
    assert not (folder / "o").exists()
    return str(error.value)


def test_without_dask_a_line_says_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("zenvoy.studies.extras.find_spec", lambda _: None)
    wanted = "distributed is not installed; run: pip install 'zenvoy[dask]'"
    assert refused(tmp_path) == wanted


def test_the_cluster_says_how_many_runs_go_at_a_time(tmp_path: Path) -> None:
    assert refused(tmp_path, jobs=2).startswith("--jobs: with --dask, the workers say how many")
