"""`extends` names one scenario that exists and does not extend this one in turn."""

from __future__ import annotations

import pytest

from tests.scenarios.extends.conftest import Write, problems
from zenvoy.scenarios import UnknownScenarioError


@pytest.mark.parametrize(
    ("value", "what"),
    [
        ("3", "3 is not"),
        ("", "null is not"),
        ("[a, b]", "a list is not"),
        ("{a: b}", "a mapping is not"),
        ('""', "'' is not"),
    ],
)
def test_extends_must_name_one_scenario(write: Write, value: str, what: str) -> None:
    write({"s.yaml": f"seed: 1\nextends: {value}\n"})
    line = f"extends: {what} the name of a scenario: a file or a built-in one  (s.yaml, line 2)"
    assert problems() == [line]


def test_extends_with_a_tag_is_refused(write: Write) -> None:
    write({"s.yaml": "extends: !dice 3\n"})
    assert problems() == [
        "extends: the tag !dice is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
        "  (s.yaml, line 1)"
    ]


@pytest.mark.parametrize(("name", "hint"), [("paper/base", True), ("zzz", False), ("a\\0b", False)])
def test_a_missing_base_is_refused(packaged: Write, write: Write, name: str, hint: bool) -> None:
    packaged({"paper/bose.yaml": "{}", "q.yaml": "{}"})
    write({"s.yaml": f'seed: x\nextends: "{name}"\n'})
    shown = name.replace("\\0", "\\x00")
    near = "did you mean 'paper/bose'? " if hint else ""
    assert problems(kind=UnknownScenarioError) == [
        f"extends: '{shown}' is neither a file nor a built-in scenario; {near}built-in: "
        "paper/bose, q  (s.yaml, line 2)"
    ]


def test_circles_of_any_length_are_refused(write: Write) -> None:
    write({"s.yaml": "seed: 1\nextends: s.yaml\n"})
    allowed = "allowed: a scenario outside of it"
    assert problems() == [
        f"extends: 's.yaml' closes a cycle: s.yaml → s.yaml; {allowed}  (s.yaml, line 2)"
    ]
    write(
        {
            "s.yaml": "extends: sub/a.yaml\n",
            "sub/a.yaml": "extends: b.yaml\n",
            "sub/b.yaml": "seed: 1\nextends: ../sub/a.yaml\n",
        }
    )
    assert problems() == [
        "extends: '../sub/a.yaml' closes a cycle: sub/a.yaml → sub/b.yaml → sub/../sub/a.yaml; "
        f"{allowed}  (sub/b.yaml, line 2)"
    ]


def test_circles_in_the_package_are_refused(packaged: Write) -> None:
    packaged({"a.yaml": "extends: b\n", "b.yaml": "extends: a\n"})
    assert problems(name="a") == [
        "extends: 'a' closes a cycle: built-in a → built-in b → built-in a; "
        "allowed: a scenario outside of it  (built-in b, line 1)"
    ]


def test_a_misspelt_extends_is_recognised(write: Write) -> None:
    write({"s.yaml": "extend: quickstart\n"})
    (line,) = problems()
    assert line.startswith("extend: unknown key; did you mean 'extends'? allowed: extends, desc")
    write({"s.yaml": "fleet: {extends: quickstart}\n"})
    assert problems() == [
        "fleet.extends: unknown key; allowed: size, length_m, gap_m, bumper_gap_m, speed_mps, "
        "initial_gaps_m, initial_speeds_mps, reported_gaps, groups"
        "  (s.yaml, line 1)"
    ]


@pytest.mark.parametrize("key", ["extends", "extends.x"])
def test_extends_is_not_for_the_command_line(write: Write, key: str) -> None:
    write({"s.yaml": "seed: 1\n"})
    line = f"{key}: cannot be set; allowed in a file only  (--set {key}=quickstart)"
    assert problems(f"{key}=quickstart") == [line]
