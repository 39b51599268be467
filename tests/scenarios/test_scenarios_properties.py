"""A written scenario is read back, and any text loads or is refused."""

from __future__ import annotations

import re
from io import StringIO
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from tests.scenarios.drawn import scenarios
from zenvoy.scenarios import (
    Scenario,
    ScenarioError,
    effective_json,
    effective_yaml,
    load,
)

MESSAGE = re.compile(r"(\S.*: )?\S.*  \((s\.yaml(, line \d+)?|--set .*)\)")

# The time that an example takes depends on the machine only.
NO_DEADLINE = settings(deadline=None)


def _written(folder: Path, text: str) -> Path:
    path = folder / "s.yaml"
    path.write_bytes(text.encode(errors="surrogatepass"))
    return path


def _refusal(folder: Path, text: str, *overrides: str) -> ScenarioError | None:
    """Return the error that loading `text` raises, if any, and check the form of its message."""
    path = _written(folder, text)
    try:
        load(path, overrides)
    except ScenarioError as error:
        refusal = error
    else:
        return None
    lines = str(refusal).replace(str(path), "s.yaml").split("\n")
    if refusal.more:
        assert lines.pop() == f"and {refusal.more} more"
    assert len(lines) == len(refusal.problems) > 0
    assert [line for line in lines if not MESSAGE.fullmatch(line)] == []
    return refusal


def _yaml(values: object) -> str:
    yaml = YAML(typ="safe", pure=True)
    stream = StringIO()
    yaml.dump(values, stream)
    return stream.getvalue()


VALID: dict[str, Any] = load(
    "paper/case-15",
    [
        "events.1={vehicle: 3, at_s: 20, duration_s: 1, deceleration_mps2: 1}",
        "events.2={type: trace, vehicle: 1, at_s: 0, points: [[0, 30], [10.5, 31]]}",
        "events.3={type: sine, vehicle: 1, at_s: 20, duration_s: 9, amplitude_mps: 1,"
        " frequency_hz: 0.1}",
    ],
).scenario.model_dump(mode="json")


def _paths(value: object, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    entries = value.items() if isinstance(value, dict) else enumerate(value)  # type: ignore[arg-type]
    found = []
    for step, child in entries:
        found.append((*path, step))
        if isinstance(child, dict | list):
            found += _paths(child, (*path, step))
    return found


def _copy_and_holder(path: tuple[Any, ...]) -> tuple[dict[str, Any], Any]:
    """Return a copy of VALID, and the container in it that has the value at `path`."""
    copy = YAML(typ="safe", pure=True).load(_yaml(VALID))
    holder = copy
    for step in path[:-1]:
        holder = holder[step]
    return copy, holder


paths = st.sampled_from(_paths(VALID))
junk = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.integers(min_value=10**300, max_value=10**320)
    | st.floats()
    | st.text(max_size=10)
    | st.sampled_from(["FM", "ring", "0.3", "yes", "2020-01-01", "<<"]),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=5,
)


@NO_DEADLINE
@given(scenarios())
def test_the_effective_yaml_is_read_back(folder: Path, scenario: Scenario) -> None:
    assert load(_written(folder, effective_yaml(scenario))).scenario == scenario


@NO_DEADLINE
@given(scenarios())
def test_the_effective_json_is_read_back(scenario: Scenario) -> None:
    again = Scenario.model_validate_json(effective_json(scenario))
    assert again == scenario
    assert effective_json(again) == effective_json(scenario)


@NO_DEADLINE
@given(paths, junk)
def test_any_value_anywhere_is_accepted_or_refused_as_a_scenario(
    folder: Path, path: tuple[Any, ...], value: object
) -> None:
    values, holder = _copy_and_holder(path)
    holder[path[-1]] = value
    _refusal(folder, _yaml(values))


def test_a_misspelt_short_key_is_recognised(folder: Path) -> None:
    error = _refusal(folder, "channel: {momo: true}")
    assert error is not None
    assert "did you mean 'mimo'?" in str(error)


@NO_DEADLINE
@given(paths.filter(lambda path: isinstance(path[-1], str)), st.data())
def test_a_misspelt_key_is_named(folder: Path, path: tuple[Any, ...], data: st.DataObject) -> None:
    values, holder = _copy_and_holder(path)
    key: str = path[-1]
    letter = st.sampled_from("abcdefghijklmnopqrstuvwxyz_")
    position = data.draw(st.integers(0, len(key)))
    misspelt = key[:position] + data.draw(letter) + key[position + data.draw(st.integers(0, 1)) :]
    if misspelt in holder:
        return
    holder[misspelt] = holder.pop(key)
    error = _refusal(folder, _yaml(values))
    assert error is not None
    name = ".".join(map(str, (*path[:-1], misspelt)))
    found = [problem.text for problem in error.problems if problem.key == name]
    assert len(found) == 1
    assert found[0].startswith("unknown key; ")
    assert "did you mean '" in found[0] or len(key) < 4


@NO_DEADLINE
@given(st.data())
def test_a_text_with_any_character_changed_is_accepted_or_refused(
    folder: Path, data: st.DataObject
) -> None:
    text = _yaml(VALID)
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text)))
        stop = start + data.draw(st.integers(0, 3))
        patch = data.draw(st.text("&*!|>%@`'\"[]{},:#-?\n\t 0a\0\ud800\x85", max_size=3))
        text = text[:start] + patch + text[stop:]
    _refusal(folder, text)


@NO_DEADLINE
@given(st.text(max_size=30))
def test_any_text_is_accepted_or_refused(folder: Path, text: str) -> None:
    _refusal(folder, text)


@NO_DEADLINE
@given(st.lists(st.text(max_size=12), max_size=3), paths, junk)
def test_any_setting_is_accepted_or_refused(
    folder: Path, keys: list[str], path: tuple[Any, ...], value: object
) -> None:
    named = ".".join(map(str, path))
    settings = [*keys, *(f"{key}={value}" for key in keys), f"{named}={value}", f"{named}.{value}"]
    _refusal(folder, "{}", *settings)
    for setting in settings:
        _refusal(folder, effective_yaml(Scenario()), setting)
