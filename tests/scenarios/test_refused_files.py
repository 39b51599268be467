"""Wrong files and names are refused, each with the whole message."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.scenarios.conftest import Refusal
from zenvoy.scenarios import (
    UnknownScenarioError,
    UnreadableScenarioError,
    load,
)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "seed: 1\nseed: 2\n",
            "seed: given twice, first in s.yaml, line 1; allowed: once  (s.yaml, line 2)",
        ),
        (
            "fleet:\n  size: 4\n  gap_m: 9\n  size: 4\n",
            "fleet.size: given twice, first in s.yaml, line 2; allowed: once  (s.yaml, line 4)",
        ),
        ("? [a]\n: 1\n", "a key is a list or a mapping; allowed: text  (s.yaml, line 1)"),
        (
            "seed: !dice 6",
            "seed: the tag !dice is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
            "  (s.yaml, line 1)",
        ),
        (
            "fleet: !!set {size, gap_m}",
            "fleet: the tag !!set is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
            "  (s.yaml, line 1)",
        ),
        ("seed: !!int six", "seed: 'six' is not a whole number below 1e308  (s.yaml, line 1)"),
        ("seed: !!float six", "seed: 'six' is not a number  (s.yaml, line 1)"),
        (
            "%YAML 1.1\n---\ndescription: yes",
            "description: 'yes' is not one of true, false  (s.yaml, line 3)",
        ),
        (
            f"seed: 0x1{'0' * 300}",
            f"seed: '0x1{'0' * 55}… is not a whole number below 1e308  (s.yaml, line 1)",
        ),
        (
            f"seed: {'9' * 5000}",
            f"seed: '{'9' * 58}… is not a whole number below 1e308  (s.yaml, line 1)",
        ),
        (
            'description: "\\ud800"',
            "description: '\\ud800' is not text; half a surrogate pair is not a character"
            "  (s.yaml, line 1)",
        ),
        (
            '"\\ud800": 1',
            "'\\ud800' is not text; half a surrogate pair is not a character  (s.yaml, line 1)",
        ),
        ("[1, 2]", "a list is not a mapping; the top level must be one  (s.yaml)"),
        ("hello", "text is not a mapping; the top level must be one  (s.yaml)"),
        ("", "empty; allowed: a mapping ({} for the defaults alone)  (s.yaml)"),
        ("# nothing\n", "empty; allowed: a mapping ({} for the defaults alone)  (s.yaml)"),
    ],
)
def test_forbidden_yaml_is_refused(refusal: Refusal, text: str, line: str) -> None:
    assert refusal(text) == line


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "seed: 1\nfleet: [1\n",
            "not valid YAML: while parsing a flow sequence, expected ',' or ']', but got "
            "'<stream end>'  (s.yaml, line 3)",
        ),
        (
            "seed: 1\n\tx: 3\n",
            "not valid YAML: while scanning for the next token, found character '\\t' that cannot "
            "start any token  (s.yaml, line 2)",
        ),
        ("seed: *s", "not valid YAML: found undefined alias 's'  (s.yaml, line 1)"),
        (
            "seed: 1\n---\nseed: 2\n",
            "not valid YAML: expected a single document in the stream, but found another document"
            "  (s.yaml, line 2)",
        ),
        (
            "seed: 1\na: \x07",
            "not valid YAML: U+0007 is not a printable character  (s.yaml, line 2)",
        ),
        (b"seed: 1\n# \xff\n", "not UTF-8: byte 0xff  (s.yaml, line 2)"),
        ("a: &a\n  b: *a", "more than the limit of 50 levels  (s.yaml, line 2)"),
        ("[" * 5000, "more than the limit of 50 levels  (s.yaml)"),
        (
            "a: &a [0,0,0,0,0,0,0,0,0,0]\n"
            + "".join(
                f"{b}: &{b} [{','.join([f'*{a}'] * 10)}]\n"
                for a, b in zip("abcde", "bcdef", strict=True)
            ),
            "more than the limit of 200000 values  (s.yaml, line 1)",
        ),
    ],
)
def test_unreadable_files_are_refused(refusal: Refusal, text: str | bytes, line: str) -> None:
    assert refusal(text, kind=UnreadableScenarioError) == line


def test_a_file_without_read_permission_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def denied(path: str, _flags: int) -> int:
        raise PermissionError(13, "Permission denied", path)

    path = tmp_path / "s.yaml"
    path.write_text("seed: 1\n")
    monkeypatch.setattr(os, "open", denied)
    with pytest.raises(UnreadableScenarioError) as caught:
        load(path)
    assert str(caught.value) == f"cannot be read: Permission denied  ({path})"


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("paper/case15", "did you mean 'paper/case-15'? "),
        ("quikstart", "did you mean 'quickstart'? "),
        ("zzz", ""),
        ("a\0b", ""),
        ("x" * 50, ""),
    ],
)
def test_unknown_names_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, hint: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UnknownScenarioError) as caught:
        load(name)
    message = str(caught.value)
    start = f"{name!r} is neither a file nor a built-in scenario; {hint}built-in: "
    assert message.startswith(start)
    assert {"paper/case-15", "quickstart"} <= set(message.removeprefix(start).split(", "))
