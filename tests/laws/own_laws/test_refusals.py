"""Wrong laws and wrong parameters are refused, and a law that fails in a run is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.idm import IDM
from zenvoy.analysis.log.load import load
from zenvoy.laws import builtin

ALLOWED = f"not one of {', '.join(builtin())}, or file:NAME such as fvdm:FVDM  (s.yaml, line 1)"


def refusal(folder: Path, control: str) -> str:
    (folder / "s.yaml").write_text(f"control: {{{control}}}")
    outcome = zenvoy(folder, "check", "s.yaml")
    assert outcome.code == 2
    return outcome.err.strip()


@pytest.mark.parametrize(
    ("control", "message"),
    [
        (
            'model: "none:here"',
            "control.model: 'none:here': there is no none.py beside it, and no installed package "
            "has a module none  (s.yaml, line 1)",
        ),
        ('model: "idm:smit"', "control.model: 'idm:smit': idm.py has no smit; allowed: smith"),
        (
            'model: "idm:idm"',
            "control.model: 'idm:idm': idm.py has a value that is not of type Law, idm;",
        ),
        ('model: "os:path"', "control.model: 'os:path': there is no os.py beside it"),
        (
            'model: "../out.py:x"',
            "control.model: '../out.py:x': its file is not beside the scenario; --allow-code",
        ),
        ('model: "bad:x"', "control.model: 'bad:x': bad.py cannot be run: SyntaxError"),
        (
            'model: "idm:smith", parameters: {headway: 1}',
            "control.parameters.headway: unknown key; did you mean 'headway_s'? allowed: "
            "headway_s, a, b, s0  (s.yaml, line 1)",
        ),
        (
            'model: "idm:smith", parameters: {a: fast}',
            "control.parameters.a: 'fast' is not a number  (s.yaml, line 1)",
        ),
        (
            'model: "idm:smith", parameters: {a: .inf}',
            "control.parameters.a: inf is not a finite number  (s.yaml, line 1)",
        ),
        ('model: "idm:smith", parameters: 3', "control.parameters: 3 is not a mapping"),
        ("model: FM, parameters: {a: 1}", "control.parameters: given, but FM has no parameters"),
        (
            "model: MBCM, parameters: {a: 1}",
            "control.parameters: given, but MBCM has its parameters in control.multi_node",
        ),
        ("model: PBMC", f"control.model: 'PBMC' is {ALLOWED}"),
        ("model: idm.py", f"control.model: 'idm.py' is {ALLOWED}"),
        ("model: idm.smith", f"control.model: 'idm.smith' is {ALLOWED}"),
    ],
)
def test_a_wrong_law_or_parameter_is_refused_with_a_message(
    laws: Path, control: str, message: str
) -> None:
    (laws.parent / "out.py").write_text(IDM)
    (laws / "bad.py").write_text("def x(:")
    assert refusal(laws, control).startswith(message)


def test_two_laws_of_the_same_name_are_refused(laws: Path) -> None:
    """The log could not tell them apart, and its columns would have the same names."""
    (laws / "other.py").write_text(IDM)
    outcome = refusal(laws, 'model: "idm:smith", schedule: [{at_s: 1, model: "other:smith"}]')
    assert outcome.startswith(
        "control.schedule.0.model: other:smith has the name of idm:smith, Smith; "
        "allowed: a name of its own for each law"
    )


def test_a_law_with_a_wrong_field_is_refused_before_the_run(laws: Path) -> None:
    text = IDM.replace('colour="#CC79A7"', 'columns=("gap",)')
    (laws / "wrong.py").write_text(text)
    assert refusal(laws, 'model: "wrong:smith"').startswith(
        "control.model: 'wrong:smith': wrong.py, smith: columns is ('gap',); allowed: "
    )


BROKEN = """
from zenvoy.laws import Column, Law, Output


def raises(seen, p):
    if seen.speed < 32.0:
        return 1.0 / 0.0
    return -1.0


def text(seen, p):
    return "fast"


def undeclared(seen, p):
    return seen.behind.p


def hangs(seen, p):
    while True:
        pass


def swallows(seen, p):
    while True:
        try:
            while True: pass
        except Exception:  # this law is the fault under test: it swallows interruptions
            pass


def two_lines(seen, p):
    raise ValueError("oh\\nno")


def bare(seen, p):
    return Output(0.0, state=0.0)


def unlogged(seen, p):
    return Output(0.0, state=(1.0,), logged=("a",))


raising, texting, undeclaring, hanging, swallowing, shouting = (
    Law(name=f.__name__, acceleration=f)
    for f in (raises, text, undeclared, hangs, swallows, two_lines)
)
baring, unlogging = (
    Law(name=f.__name__, acceleration=f, state=(0.0,), columns=(Column("x"),))
    for f in (bare, unlogged)
)
"""


@pytest.mark.parametrize("bus", ["in-process", "zenoh"])
@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("raising", "law raises raised ZeroDivisionError: float division by zero (bad.py, line 7)"),
        ("texting", "law text returned 'fast', which is no acceleration (bad.py, line 11)"),
        ("undeclaring", "law undeclared returned nan, which is no acceleration (bad.py, line 15)"),
        ("hanging", "law hangs raised TimeoutError: took longer than 2 s (bad.py, line 20)"),
        ("swallowing", "law swallows raised TimeoutError: took longer than 2 s (bad.py, line 27)"),
        ("shouting", "law two_lines raised ValueError: oh no (bad.py, line 33)"),
        ("baring", "law bare returned 0.0 as its state, not a tuple of 1 number (bad.py, line 36)"),
        (
            "unlogging",
            "law unlogged returned ('a',) to be logged, not a tuple of 1 number (bad.py, line 40)",
        ),
    ],
)
def test_a_law_that_fails_is_named_with_its_line(
    tmp_path: Path, law: str, message: str, bus: str
) -> None:
    (tmp_path / "bad.py").write_text(BROKEN)
    (tmp_path / "s.yaml").write_text(f"""
duration_s: 20
stall_limit_s: 2
fleet: {{size: 3, speed_mps: 33}}
control: {{model: "bad:{law}", desired_speed_mps: 33}}
""")
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--bus", bus, "--out", "out")
    assert outcome.code == 3
    first = outcome.err.splitlines()[0]
    assert first.startswith("vehicle-0")
    assert first.partition(" died: ")[2] == message
    assert load(tmp_path / "out" / "run.mcap").result["end"] != "complete"
