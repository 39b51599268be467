"""A scenario's own laws are found by name and checked. They run alike everywhere and are logged."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import zenvoy as api
from tests.conftest import zenvoy
from tests.idm import IDM
from tests.logs import write_log
from zenvoy.analysis.compare.pictures import Labelled, colours
from zenvoy.analysis.log.export import export
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.page.report import models
from zenvoy.analysis.theory.laws import Coupling
from zenvoy.analysis.theory.of_run import NoTheoryError, theory_of
from zenvoy.bus import messages_pb2 as pb
from zenvoy.studies.cell import Cell

# A law with every feature: both sides, a state, columns, a linear form, random numbers.
RICH = """
from dataclasses import dataclass

from zenvoy.laws import Column, Law, Linear, Needs, Output


@dataclass(frozen=True)
class Parameters:
    share: float = 0.5
    noise: float = 0.0


def balance(seen, p):
    k_d, k_v, k_c, _, v_des = seen.setpoint
    pull = k_d * (seen.ahead.p - p.share * seen.behind.p - (1.0 - p.share) * seen.setpoint.p_des)
    damp = k_v * (seen.ahead.v - p.share * seen.behind.v)
    (decisions,) = seen.state
    luck = seen.uniform(0)
    a = pull + damp + k_c * (v_des - seen.speed) + p.noise * (luck - 0.5)
    return Output(a, logged=(decisions, luck), state=(decisions + 1.0,))


def linear(p, setpoint, m):
    return Linear((1.0,), (p.share,), setpoint.k_d, setpoint.k_v, setpoint.k_c)


LAW = Law(
    name="Rich",
    acceleration=balance,
    parameters=Parameters,
    needs=Needs(behind=True),
    columns=(Column("decisions"), Column("luck")),
    state=(0.0,),
    linear=linear,
)
"""
MIXED = """
duration_s: 6
fleet:
  size: 6
  groups: [{name: odd, vehicles: "1,3", model: "rich:LAW", parameters: {noise: 0.5}}]
control:
  model: FM
  schedule: [{at_s: 2, model: "idm:smith", vehicles: "5-6", parameters: {headway_s: 0.9}}]
channel: {outages: [{from_s: 3, until_s: 5}], loss: {p: 0.1}}
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2}]
"""


@pytest.fixture
def laws(tmp_path: Path) -> Path:
    (tmp_path / "idm.py").write_text(IDM)
    (tmp_path / "rich.py").write_text(RICH)
    (tmp_path / "mixed.yaml").write_text(MIXED)
    return tmp_path


@pytest.fixture
def mixed(laws: Path) -> Run:
    return load(write_log(laws / "run.mcap", MIXED))


@pytest.mark.parametrize("per_process", [1, 3])
def test_processes_and_one_process_give_the_same_bits(
    laws: Path, mixed: Run, per_process: int
) -> None:
    outcome = zenvoy(
        laws, "run", "mixed.yaml", "--out", "out", "--vehicles-per-process", str(per_process)
    )
    assert outcome.code == 0, outcome.err
    assert load(laws / "out" / "run.mcap").fingerprint == mixed.fingerprint is not None


def test_log_and_report_name_the_laws_without_their_code(laws: Path, mixed: Run) -> None:
    (laws / "idm.py").unlink()
    (laws / "rich.py").unlink()
    run = load(mixed.log)
    own = {law.name: law for mode, law in run.laws.items() if mode >= pb.MODE_OWN}
    assert set(own) == {"IDM", "Rich"}
    assert own["IDM"].colour == "#CC79A7"
    assert own["IDM"].reference.startswith("idm:smith#")
    assert set(run.estimate["mode"][-1, 4:]) == {own["IDM"].mode}
    assert models(run.scenario) == (
        "rich:LAW (2 vehicles); FM (2 vehicles); FM, idm:smith from 2 s (2 vehicles)"
    )
    texts = [event.text for event in run.events if event.kind == pb.EVENT_MODEL]
    assert texts == ["idm:smith: 5-6"]
    outcome = zenvoy(laws, "analyze", "run.mcap")
    assert outcome.code == 0, outcome.err
    printed = zenvoy(laws, "info", "run.mcap").out
    assert all(f"│ {law.name} " in printed and law.reference in printed for law in own.values())


def test_logged_values_are_named_columns(mixed: Run, tmp_path: Path) -> None:
    decisions, luck = (mixed.estimate[f"Rich.{name}"] for name in ("decisions", "luck"))
    assert np.isnan(decisions[:, [1, 3, 4, 5]]).all()
    rich = mixed.laws[int(mixed.estimate["mode"][0, 0])].mode if mixed.cycles else 0
    acts = mixed.estimate["mode"][:, 0] == rich
    assert not np.isnan(decisions[acts, 0]).any()
    assert np.isnan(decisions[~acts, 0]).all()  # in the outage it falls back to FM
    assert 0 < np.count_nonzero(~acts) < len(acts)
    assert len(np.unique(luck[acts, 0])) == np.count_nonzero(acts)
    (file,) = [path for path in export(mixed, tmp_path / "csv", "csv") if "estimate" in path.name]
    head = file.read_text().splitlines()[0].replace('"', "").split(",")
    assert head[-2:] == ["Rich.decisions", "Rich.luck"]
    assert "IDM" in file.read_text()


def test_a_law_that_takes_over_starts_afresh(mixed: Run) -> None:
    """Its state counts the decisions since it took over, and starts again after the outage."""
    counted = mixed.estimate["Rich.decisions"][:, 0]
    starts = np.flatnonzero(counted == 0.0)
    assert len(starts) >= 2
    for start in starts:
        end = start + 5
        assert counted[start:end].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_random_numbers_depend_on_the_seed_alone(laws: Path, mixed: Run) -> None:
    again = load(write_log(laws / "again.mcap", MIXED))
    other = load(write_log(laws / "other.mcap", f"seed: 2\n{MIXED}"))
    assert again.fingerprint == mixed.fingerprint
    assert not np.array_equal(
        other.estimate["Rich.luck"][:5, 0], mixed.estimate["Rich.luck"][:5, 0]
    )


def test_theory_takes_a_law_from_the_log(laws: Path) -> None:
    text = """
    duration_s: 3
    fleet: {size: 5}
    control: {model: "rich:LAW", parameters: {share: 0.25}}
    """
    run = load(write_log(laws / "one.mcap", text))
    members = theory_of(run, 1.0, 3.0).members
    assert {member.coupling for member in members} == {Coupling((1.0,), (0.25,))}
    idm = load(
        write_log(
            laws / "two.mcap", text.replace("rich:LAW", "idm:smith").replace("share: 0.25", "s0: 3")
        )
    )
    with pytest.raises(NoTheoryError, match="vehicle 1 ran IDM"):
        theory_of(idm, 1.0, 3.0)


def test_a_changed_source_is_another_law(laws: Path) -> None:
    shown = zenvoy(laws, "show", "mixed.yaml").out
    assert "idm:smith#" in shown
    (laws / "shown.yaml").write_text(shown)
    assert zenvoy(laws, "check", "shown.yaml").code == 0
    changed = IDM.replace("1.4", "1.5") + "\nopen('ran', 'w').close()\n"
    (laws / "idm.py").write_text(changed)
    outcome = zenvoy(laws, "check", "shown.yaml")
    assert outcome.code == 2
    assert "its source has changed" in outcome.err
    assert not (laws / "ran").exists()  # it is not run to find that out


BROKEN = """
from zenvoy.laws import Law


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


raising, texting, undeclaring, hanging = (
    Law(name=f.__name__, acceleration=f) for f in (raises, text, undeclared, hangs)
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
        ("model: PBMC", "control.model: 'PBMC' is not one of FM, BCM, MBCM, PBCM, CACC"),
    ],
)
def test_a_wrong_law_or_parameter_is_refused_with_a_message(
    laws: Path, control: str, message: str
) -> None:
    (laws.parent / "out.py").write_text(IDM)
    (laws / "bad.py").write_text("def x(:")
    assert refusal(laws, control).startswith(message)


def test_code_is_found_beside_the_scenario_from_any_working_folder(laws: Path) -> None:
    folder = laws / "deep"
    folder.mkdir()
    shutil.copy(laws / "idm.py", folder)
    (folder / "s.yaml").write_text('control: {model: "idm:smith"}')
    assert zenvoy(laws, "check", "deep/s.yaml").code == 0
    assert zenvoy(laws, "check", "quickstart", "--set", "control.model=idm:smith").code == 0


def test_code_from_elsewhere_runs_only_with_permission(laws: Path) -> None:
    (laws.parent / "away.py").write_text(IDM)
    (laws / "s.yaml").write_text('control: {model: "../away.py:smith"}')
    assert zenvoy(laws, "check", "s.yaml").code == 2
    assert zenvoy(laws, "check", "s.yaml", "--allow-code").code == 0
    with pytest.raises(api.ScenarioError, match="is not beside the scenario"):
        api.scenario(laws / "s.yaml")
    found = api.scenario(laws / "s.yaml", allow_code=True).scenario.control.model
    assert found.startswith("../away.py:smith#")


def test_a_study_notices_a_changed_source(laws: Path) -> None:
    cell = Cell(scenario=str(laws / "mixed.yaml"), seed=1)
    before = cell.key()
    assert cell.key() == before
    (laws / "idm.py").write_text(IDM.replace("1.4", "1.5"))
    assert cell.key() != before


def test_a_comparison_has_the_colours_of_the_laws(laws: Path) -> None:
    text = "{duration_s: 2, fleet: {size: 3}, control: {model: %s}}"
    runs = [
        Labelled(name, load(write_log(laws / f"{number}.mcap", text % model)))
        for number, (name, model) in enumerate([("a", '"idm:smith"'), ("b", "BCM")])
    ]
    assert colours(runs) == ["#CC79A7", "#D55E00"]


def test_a_law_that_new_writes_runs_and_passes_its_test(tmp_path: Path) -> None:
    assert zenvoy(tmp_path, "new", "law", "gap_keeper").code == 0
    outcome = zenvoy(tmp_path, "check", "gap_keeper.yaml", "--strict")
    assert (outcome.code, outcome.err) == (0, "")
    tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_gap_keeper.py"]
    found = subprocess.run(tests, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "4 passed" in found.stdout, found.stdout
    again = zenvoy(tmp_path, "new", "law", "gap_keeper")
    assert (again.code, again.err) == (2, "gap_keeper.py: exists already\n")
    wrong = zenvoy(tmp_path, "new", "law", "gap keeper")
    assert wrong.code == 2
    assert "is not the name of a Python module" in wrong.err


ESTIMATOR = """
from dataclasses import dataclass

import numpy as np

from zenvoy.laws import Estimator


@dataclass(frozen=True)
class Parameters:
    gain: float = 0.5
    fails_after: int = 1_000_000


class Constant:
    \"\"\"A filter with a constant gain.\"\"\"

    def __init__(self, model, z, R, own):
        self.model, self.x, self.own, self.steps = model, z, own, 0

    def step(self, inputs, z, R):
        self.steps += 1
        for a in inputs:
            self.x = self.model.F @ self.x + self.model.B[:, 0] * a
        if self.steps > self.own.fails_after:
            self.x = self.x * np.nan
        self.x = self.x + self.own.gain * (z - self.x)
        return self.x, R


constant = Estimator(name="constant", start=Constant, parameters=Parameters)
"""


def with_estimator(parameters: str) -> str:
    return f"""
duration_s: 4
fleet: {{size: 4}}
estimator: {{kind: "mine:constant", parameters: {{{parameters}}}}}
"""


def test_an_own_estimator_gives_the_same_bits_everywhere(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(ESTIMATOR)
    run = load(write_log(tmp_path / "s.mcap", with_estimator("gain: 1.0")))
    # With a gain of 1 the estimate is the reading.
    np.testing.assert_allclose(run.estimate["speed"][1:], run.radar["speed"][1:40], atol=1e-12)
    half = load(write_log(tmp_path / "h.mcap", with_estimator("gain: 0.25")))
    assert half.fingerprint != run.fingerprint
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--out", "out")
    assert outcome.code == 0, outcome.err
    assert load(tmp_path / "out" / "run.mcap").fingerprint == run.fingerprint


def test_an_estimator_that_fails_is_named(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(ESTIMATOR)
    (tmp_path / "s.yaml").write_text(with_estimator("fails_after: 10"))
    for bus in ("in-process", "zenoh"):
        outcome = zenvoy(tmp_path, "run", "s.yaml", "--bus", bus, "--out", bus)
        assert outcome.code == 3
        first = outcome.err.splitlines()[0]
        assert "died: estimator constant raised ValueError: returned a state [nan" in first


@pytest.mark.parametrize(
    ("estimator", "message"),
    [
        (
            'kind: "mine:other"',
            "estimator.kind: 'mine:other': mine.py has no other; allowed: constant  (s.yaml, ",
        ),
        (
            'kind: "idm:smith"',
            "estimator.kind: 'idm:smith': idm.py has a value that is not of type Estim",
        ),
        ("kind: kf", "estimator.kind: 'kf' is not one of kalman, ekf, ukf"),
        (
            "kind: ekf, parameters: {gain: 1}",
            "estimator.parameters: given, but the built-in estimators have none",
        ),
        (
            'kind: "mine:constant", parameters: {gain: high}',
            "estimator.parameters.gain: 'high' is not a number",
        ),
    ],
)
def test_a_wrong_estimator_is_refused_with_a_message(
    laws: Path, estimator: str, message: str
) -> None:
    (laws / "mine.py").write_text(ESTIMATOR)
    (laws / "s.yaml").write_text(f"estimator: {{{estimator}}}")
    outcome = zenvoy(laws, "check", "s.yaml")
    assert outcome.code == 2
    assert outcome.err.startswith(message)


def test_a_law_of_an_installed_package_is_found_by_its_entry_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    site, scenarios = tmp_path / "site", tmp_path / "scenarios"
    facts = site / "smith_laws-1.2.dist-info"
    for folder in (site / "smith_laws", facts, scenarios):
        folder.mkdir(parents=True)
    (site / "smith_laws" / "__init__.py").write_text(IDM)
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: smith-laws\nVersion: 1.2\n")
    (facts / "top_level.txt").write_text("smith_laws\n")
    (facts / "entry_points.txt").write_text("[zenvoy.laws]\nSmith = smith_laws:smith\n")
    monkeypatch.setenv("PYTHONPATH", str(site))
    (scenarios / "s.yaml").write_text(
        "duration_s: 2\nfleet: {size: 3}\ncontrol: {model: Smith, parameters: {a: 1.0}}\n"
    )
    prints = set()
    for bus in ("in-process", "zenoh"):
        outcome = zenvoy(scenarios, "run", "s.yaml", "--bus", bus, "--out", bus)
        assert outcome.code == 0, outcome.err
        run = load(scenarios / bus / "run.mcap")
        prints.add(run.fingerprint)
        law = run.laws[pb.MODE_OWN]
        assert (law.name, law.version) == ("IDM", "smith-laws 1.2")
        assert law.reference.startswith("smith_laws:smith#")
    assert len(prints) == 1
    monkeypatch.delenv("PYTHONPATH")
    outcome = zenvoy(scenarios, "check", "s.yaml")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("control.model: 'Smith' is not one of FM, BCM, MBCM, PBCM, CACC")
