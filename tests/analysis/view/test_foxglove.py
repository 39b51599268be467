"""A client of Foxglove's WebSocket protocol sees a run, by the schemas that the server gives it."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
from pathlib import Path
from typing import Any, Final

import psutil
import pytest

from tests.analysis.view.foxglove_client import (
    address_in,
    class_by,
    client_at,
    wait_for_chunks,
)
from tests.conftest import command, wait_until
from tests.logs import write_log
from zenvoy.analysis.log.load import load
from zenvoy.analysis.log.records import Pass
from zenvoy.analysis.view.growing_log import GrowingLog
from zenvoy.bus.log_format import EPOCH_NS
from zenvoy.cli.app import app
from zenvoy.cli.usage import outcome

RUN: Final = "{duration_s: 5, fleet: {size: 4}}"
TOPICS: Final = ("/fleet/truth", "/scene", "/tf", "/fleet/summary")


@pytest.mark.parametrize("scene_in_log", ["false", "true"])
def test_a_client_sees_truth_and_scene_of_a_run_that_goes_on(
    tmp_path: Path, scene_in_log: str
) -> None:
    """Each comes once in a cycle, whether the log or the server has drawn the scene."""
    scenario = f"{{duration_s: 600, fleet: {{size: 4}}, log: {{scene: {scene_in_log}}}}}"
    (tmp_path / "s.yaml").write_text(scenario)
    arguments = ("run", "s.yaml", "--realtime", "--out", "shown", "--foxglove")
    with command(tmp_path, *arguments) as shown:
        with client_at(address_in(shown)) as client:
            assert "time" in client.server["capabilities"]
            client.subscribe(*TOPICS)
            seen: dict[str, dict[int, Any]] = {topic: {} for topic in TOPICS}
            for topic, time_ns, message in client.messages():
                assert time_ns not in seen[topic], topic
                seen[topic][time_ns] = message
                if all(len(of_topic) >= 5 for of_topic in seen.values()):
                    break
        log = GrowingLog(tmp_path / "shown" / "run.mcap")
        log.extend()
        assert not log.ended
        for time_ns, truth in list(seen["/fleet/truth"].items())[:4]:
            assert truth.time_ns == time_ns - EPOCH_NS
            road, *vehicles = seen["/scene"][time_ns].entities
            assert (road.id, len(vehicles), len(truth.position)) == ("road", 4, 4)
            assert seen["/fleet/summary"][time_ns].mean_speed == pytest.approx(sum(truth.speed) / 4)
            frames = [each.child_frame_id for each in seen["/tf"][time_ns].transforms]
            assert frames == ["fleet", *(vehicle.id for vehicle in vehicles)]
        shown.send_to_group(signal.SIGINT)
        shown.wait()
        assert shown.left() == []


def test_a_client_may_come_when_the_run_has_long_begun(tmp_path: Path) -> None:
    """Nobody watched when the server read the chunk that names the topics."""
    (tmp_path / "s.yaml").write_text("{duration_s: 600, fleet: {size: 4}}")
    arguments = ("run", "s.yaml", "--realtime", "--out", "shown", "--foxglove")
    with command(tmp_path, *arguments) as shown:
        address = address_in(shown)
        wait_for_chunks(tmp_path / "shown" / "run.mcap")
        with client_at(address) as client:
            assert client.time_on_coming() == EPOCH_NS
            client.subscribe(*TOPICS)
            seen: dict[str, int] = {}
            for topic, time_ns, _ in client.messages():
                seen[topic] = time_ns
                if seen.keys() == set(TOPICS):
                    break
            assert min(seen.values()) > EPOCH_NS
        shown.send_to_group(signal.SIGINT)
        assert shown.wait().code == 130


def test_a_client_learns_the_time_of_those_that_watch(tmp_path: Path) -> None:
    """A time before theirs would empty their plots. The log comes at once, with 4,001 cycles."""
    whole = write_log(tmp_path / "whole.mcap", "{duration_s: 400, fleet: {size: 3}}").read_bytes()
    path = tmp_path / "run.mcap"
    path.write_bytes(whole[:1000])  # not even the scenario
    os.utime(path, (2e9, 2e9))  # just now, however slow the machine is
    end_ns = EPOCH_NS + 400 * 10**9
    with command(tmp_path, "view", str(path), "--foxglove", "--port", "0") as server:
        address = address_in(server)
        with client_at(address) as client:
            client.subscribe("/fleet/truth")
            assert client.time_on_coming() == EPOCH_NS  # and counts as one that watches now
            with path.open("ab") as file:
                file.write(whole[1000:])
            assert any(time_ns == end_ns for _, time_ns, _ in client.messages())
            with client_at(address) as other:
                assert other.time_on_coming() == end_ns
        server.send(signal.SIGINT)
        assert server.wait().code == 0


def test_a_client_that_never_reads_neither_slows_nor_changes_a_run(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(RUN)
    arguments = ("run", "s.yaml", "--engine", "in-process", "--out", "shown", "--foxglove")
    with command(tmp_path, *arguments) as shown, client_at(address_in(shown)) as client:
        client.subscribe(*client.channels)
        wait_until(lambda: "stays until Ctrl-C" in shown.out, "the run has ended")
        shown.send_to_group(signal.SIGINT)
        ended = shown.wait()
        assert (ended.code, ended.err) == (0, "")
    plain = load(write_log(tmp_path / "plain.mcap", RUN))
    assert load(tmp_path / "shown" / "run.mcap").fingerprint == plain.fingerprint


@pytest.fixture(scope="module")
def log(folder: Path) -> Path:
    return write_log(folder / "run.mcap", "{duration_s: 1, fleet: {size: 4}, log: {scene: true}}")


def test_a_log_is_played_from_its_start_for_each_client(tmp_path: Path, log: Path) -> None:
    with command(tmp_path, "view", str(log), "--foxglove", "--port", "0") as server:
        address = address_in(server)
        listening = psutil.Process(server.pid).net_connections("tcp")
        assert {c.laddr.ip for c in listening} == {"127.0.0.1"}
        for _ in range(2):
            with client_at(address) as client:
                client.subscribe(*TOPICS)
                found = []
                for topic, time_ns, _ in client.messages():
                    found.append((topic, time_ns))
                    if found.count(("/fleet/summary", EPOCH_NS + 10**9)):
                        break
            times = [EPOCH_NS + cycle * 10**8 for cycle in range(11)]
            for topic in TOPICS:  # the scene is that of the log, and comes once
                came = [at for name, at in found if name == topic]
                assert came
                assert came == times[-len(came) :], topic
            assert ("/fleet/truth", times[0]) in found
        server.send(signal.SIGINT)
        ended = server.wait()
    assert (ended.code, ended.err) == (0, "")


def test_a_log_that_is_cut_is_played_too(tmp_path: Path, log: Path) -> None:
    cut = tmp_path / "cut.mcap"
    whole = GrowingLog(log)
    whole.extend()
    last = whole.chunks[-1]
    cut.write_bytes(log.read_bytes()[: last.at + last.length])
    os.utime(cut, ns=(0, 0))  # nobody has written to it for long
    with command(tmp_path, "view", str(cut), "--foxglove", "--port", "0") as server:
        address = address_in(server)
        for _ in range(2):
            with client_at(address) as client:
                client.subscribe("/fleet/truth")
                assert next(client.messages())[0] == "/fleet/truth"
        server.send(signal.SIGINT)
        assert server.wait().code == 0


def test_a_log_has_every_topic_and_field_of_the_layout(log: Path) -> None:
    layout = json.loads((Path(__file__).parents[3] / "docs" / "foxglove-layout.json").read_text())
    panels = layout["configById"]
    assert set(re.findall(r"'(\w+!\w+)'", str(layout["layout"]))) == set(panels)
    with Pass(log) as found:
        last = {message.topic: bytes(message.payload) for message in found.messages(None)}
        schemas = {
            channel.topic: found.schemas[channel.schema_id] for channel in found.channels.values()
        }
    assert panels["3D!scene"]["topics"].keys() <= last.keys()
    paths = [row["value"] for panel in panels.values() for row in panel.get("paths", ())]
    assert len(paths) > 10
    for path in paths:
        topic, _, field = path.partition(".")
        name, _, index = field.rstrip("]").partition("[")
        schema = schemas[topic]
        value = getattr(class_by(schema.name, schema.data).FromString(last[topic]), name)
        assert (not index) == isinstance(value, int | float), path


def test_a_port_that_is_taken_is_refused(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        assert outcome(app, ["view", str(log), "--foxglove", "--port", port]) == 2
    assert capsys.readouterr() == ("", f"--port {port}: Address already in use\n")


@pytest.mark.parametrize("arguments", [["run", "quickstart"], ["view", "run.mcap"]])
def test_without_the_package_the_option_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: list[str]
) -> None:
    monkeypatch.setattr("zenvoy.studies.extras.find_spec", lambda _: None)
    assert outcome(app, [*arguments, "--foxglove"]) == 2
    says = "--foxglove: foxglove is not installed; run: pip install 'zenvoy[foxglove]'\n"
    assert capsys.readouterr() == ("", says)
