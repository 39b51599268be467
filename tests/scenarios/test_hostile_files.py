"""Hostile and huge files are refused soon, in a few lines that do not quote them."""

from __future__ import annotations

import gzip
import os
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from zenvoy.scenarios import ScenarioError, UnreadableScenarioError, load, roster
from zenvoy.scenarios.reading.bounded import LARGEST_BYTES

Write = Callable[[str, str], Path]

SECRET = "hunter2"
FILES_OF_OTHERS = {
    "shadow": f"root:*:19000:0:99999:7:::\nadmin:{SECRET}:19000:0:99999:7:::\n",
    "env": f"PASSWORD={SECRET}\nUSER=me\n",
    "keys": f"{SECRET}: 1\npassword: {SECRET}\n",
    "twice": f"{SECRET}: 1\n{SECRET}: 2\n",
    "list": f"- {SECRET}\n",
    "number": "31337\n",
    "ini": f"[user]\n  password = {SECRET}\n",
    "alias": f"a: *{SECRET}\n",
    "tag": f"a: !{SECRET}!x 3\n",
    "bad tag": f"a: !!int {SECRET}\n",
    "quote": f"a: '{SECRET}\n",
    "csv": f"name,password\nme,{SECRET}\n",
    "columns": f"{SECRET};{SECRET}\n{SECRET};3\n",
}


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    monkeypatch.chdir(tmp_path)

    def write_it(name: str, text: str) -> Path:
        Path(name).write_text(text)
        return Path(name)

    return write_it


def refusal(name: str | Path = "s.yaml") -> str:
    with pytest.raises(ScenarioError) as caught:
        load(name)
    return str(caught.value)


@pytest.mark.parametrize("of_others", FILES_OF_OTHERS)
@pytest.mark.parametrize(
    "text",
    [
        "extends: other\n",
        "events: [{type: trace, vehicle: 1, at_s: 0, file: other}]\n",
        "events: [{type: trace, vehicle: 1, at_s: 0, file: other, column: v}]\n",
        "channel: {latency: {distribution: samples, file: other}}\n",
    ],
)
def test_the_text_of_any_other_file_is_not_quoted(write: Write, of_others: str, text: str) -> None:
    write("other", FILES_OF_OTHERS[of_others])
    write("s.yaml", text)
    message = refusal()
    assert SECRET not in message
    assert "31337" not in message
    assert "other" in message
    assert "root" not in message


def test_errors_in_a_users_own_base_are_reported_as_usual(write: Write) -> None:
    write("s.yaml", "extends: base.yaml\n")
    write("base.yaml", "seed: -4\nfleeet: {}\n")
    assert "seed: -4 is not in" in refusal()
    assert "fleeet: unknown key; did you mean 'fleet'?" in refusal()


@pytest.mark.parametrize(
    "text",
    ["extends: {}\n", "events: [{{type: trace, vehicle: 1, at_s: 0, file: {}}}]\n"],
)
def test_only_regular_files_are_opened(write: Write, text: str) -> None:
    os.mkfifo("pipe")
    for name, kind in (("/dev/zero", "a device"), ("pipe", "a pipe"), ("/dev/full", "a device")):
        write("s.yaml", text.format(name))
        assert f"cannot be read: {kind}, not a file" in refusal()
        assert f"cannot be read: {kind}, not a file" in refusal(name)


def test_files_have_a_maximum_size(write: Write) -> None:
    with Path("large.yaml").open("wb") as file:
        file.truncate(LARGEST_BYTES + 1)
    whole = "cannot be read: larger than the limit of 16 MiB  (large.yaml)"
    assert refusal("large.yaml") == whole
    write("s.yaml", "extends: large.yaml\n")
    assert refusal() == whole


def test_the_maximum_size_holds_for_unpacked_files(write: Write) -> None:
    Path("s.yaml.gz").write_bytes(gzip.compress(bytes(LARGEST_BYTES + 1)))
    assert "cannot be read: larger than the limit of 16 MiB" in refusal("s.yaml.gz")
    Path("s.yaml.gz").write_bytes(gzip.compress(b"") * 2_000)
    assert "cannot be read: more than 1000 gzip members" in refusal("s.yaml.gz")
    Path("s.yaml.gz").write_bytes(b"seed: 1\n")
    assert "cannot be read: not a gzip file" in refusal("s.yaml.gz")
    Path("s.yaml.gz").write_bytes(gzip.compress(b"seed: 7\n"))
    assert load("s.yaml.gz").scenario.seed == 7


def test_the_number_of_reads_of_a_table_is_limited(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("zenvoy.scenarios.reading.tables._MOST_CHARACTERS", 2**20)
    Path("t.csv").write_text("latency_ms\n1\n" + "\n" * 2**15)
    rule = "{latency: {distribution: samples, file: t.csv}}"
    write("s.yaml", f"channel: {{rules: [{', '.join([rule] * 40)}]}}\n")
    assert "more than 1 MiB in all tables together" in refusal()


def test_the_length_of_a_chain_of_scenarios_is_limited(write: Write) -> None:
    for number in range(60):
        write(f"{number}.yaml", f"extends: {number + 1}.yaml\n")
    assert "more than 50 scenarios, each of which extends the next" in refusal("0.yaml")


MANY = 300
MISTAKES = {
    "keys": "".join(f"k{n}: {n}\n" for n in range(MANY)),
    "long keys": "".join(f"{'k' * 1_000}{n}: {n}\n" for n in range(MANY)),
    "groups": "fleet:\n  groups:\n"
    + "".join(f"    - {{name: g{n}, vehicles: x{n}}}\n" for n in range(MANY)),
    "names": "fleet:\n  groups:\n" + f"    - {{name: {'g' * 900}, vehicles: 1}}\n" * MANY,
    "events": "events:\n"
    + "    - {vehicle: 41, at_s: 1, duration_s: 1, deceleration_mps2: -1}\n" * MANY,
    "values": "events:\n" + f"    - {{vehicle: {'x' * 900}}}\n" * MANY,
    "twice": "seed: 1\n" * MANY,
    "tags": "events:\n" + "    - {vehicle: !!int x}\n" * MANY,
}


@pytest.mark.parametrize("kind", MISTAKES)
def test_the_first_of_many_mistakes_are_reported_with_a_count(write: Write, kind: str) -> None:
    write("s.yaml", MISTAKES[kind])
    lines = refusal().splitlines()
    assert len(lines) == 21
    assert int(lines[-1].split()[1]) >= MANY - 21
    assert lines[-1].startswith("and ")
    assert lines[-1].endswith(" more")
    assert max(map(len, lines)) < 1_000


def test_the_first_of_many_mistakes_in_a_table_are_reported(write: Write) -> None:
    write("t.csv", "latency_ms\n" + "x\n" * MANY)
    write("s.yaml", "channel: {latency: {distribution: samples, file: t.csv}}\n")
    lines = refusal().splitlines()
    assert (len(lines), lines[-1]) == (21, f"and {MANY - 20} more")


def test_time_is_linear_in_the_number_of_entries(write: Write) -> None:
    """Quadratic work on 16 times the entries would take 256 times as long."""
    group, points = "{{name: g{0}, vehicles: y{0}}}", "points: [[0, 1], [1, 1]]"
    trace = f"{{{{type: trace, vehicle: 1, at_s: {{0}}00, {points}}}}}"
    shapes = {
        group: "fleet: {{groups: [{}]}}",
        trace: "events: [{}]",
        "k{0}: 3": "{{{}}}",
        "{0}": "channel: {{latency: {{distribution: samples, samples_ms: [{}]}}}}",
    }

    def cost_s(text: str) -> float:
        write("s.yaml", text)
        began = time.process_time()
        with suppress(ScenarioError):
            load("s.yaml")
        return time.process_time() - began

    for entry, around in shapes.items():
        few, many = (
            cost_s(around.format(", ".join(map(entry.format, range(count))))) for count in (50, 800)
        )
        assert many < 16 * 6 * few, entry


def test_a_flood_of_values_is_not_read_to_its_end(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("zenvoy.scenarios.reading.source._MOST_VALUES", 500)

    def cost_s(values: int) -> float:
        write("s.yaml", "x: [" + "1," * values + "]\n")
        began = time.process_time()
        with pytest.raises(UnreadableScenarioError, match="more than the limit of 500 values"):
            load("s.yaml")
        return time.process_time() - began

    assert cost_s(100_000) < 20 * cost_s(1_000)


def test_the_total_size_of_sets_is_limited(write: Write) -> None:
    groups = ", ".join(f"{{name: g{n}, vehicles: all}}" for n in range(300))
    write("s.yaml", f"fleet: {{size: 10000, groups: [{groups}]}}\n")
    text = "fleet.groups: the sets have 3000000 members together, more than the limit of 2000000"
    text += "  (s.yaml, line 1)"
    assert refusal() == text


@pytest.mark.parametrize(
    "text",
    [
        "fleet: {groups: [{name: a, vehicles: a}]}",
        "fleet: {groups: [{name: a, vehicles: not a}]}",
        "fleet: {groups: [{name: a, vehicles: '1, a'}]}",
        "fleet: {groups: [{name: a, vehicles: b}, {name: b, vehicles: 1}]}",
        "fleet: {groups: [{name: a, vehicles: 1, share: 0.5}]}",
        "control: {schedule: [{at_s: 1, model: FM, vehicles: b}]}",
        "fleet: {groups: [{name: a, vehicles: '99999999999999999999'}]}",
        "fleet: {groups: [{name: a, vehicles: '٣'}]}",
        "channel: {outages: [{source: a}]}",
    ],
)
def test_sets_that_a_run_would_refuse_are_refused(write: Write, text: str) -> None:
    write("s.yaml", text)
    assert "(s.yaml, line" in refusal()


def test_a_group_may_name_those_before_it(write: Write) -> None:
    write(
        "s.yaml", "fleet: {groups: [{name: a, vehicles: 1}, {name: b, vehicles: not a, model: FM}]}"
    )
    assert [own.models for own in roster(load("s.yaml").scenario)[:2]] == [{"PBCM"}, {"FM"}]
