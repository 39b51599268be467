"""Laws are named as in a scenario, and each bad comparison is refused before anything is run."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.idm import IDM
from tests.studies.comparison.conftest import compare, table, write_scenario
from zenvoy.analysis.measures.statistics import Mean
from zenvoy.scenarios import ScenarioError
from zenvoy.studies.comparison.law_choice import law_choice
from zenvoy.studies.comparison.laws import Base, laws_of
from zenvoy.studies.comparison.table import with_interval


@pytest.mark.parametrize(
    ("text", "reference", "given"),
    [
        (" PBCM ", "PBCM", {}),
        ("mylaws:smith", "mylaws:smith", {}),
        ("./a b/idm.py:IDM", "./a b/idm.py:IDM", {}),
        ("IDM:{time_gap_s: 1.5, s0: 2}", "IDM", {"time_gap_s": 1.5, "s0": 2}),
        ("IDM {time_gap_s: 1.5}", "IDM", {"time_gap_s": 1.5}),
        ("a.py:b.c:{w: [1, 2], n: x}", "a.py:b.c", {"w": [1, 2], "n": "x"}),
        ("FM:{}", "FM", {}),
    ],
)
def test_a_law_is_a_reference_with_or_without_parameters(
    text: str, reference: str, given: dict[str, object]
) -> None:
    choice = law_choice(text)
    assert (choice.reference, choice.given) == (reference, given)


def test_parameters_go_where_the_law_has_them() -> None:
    settings = law_choice("CACC:{c1: 0.6, control.gains.k_v: 0.8}").settings("PBCM")
    assert settings == {
        "control.model": "CACC",
        "control.parameters": {},
        "control.platoon.c1": 0.6,
        "control.gains.k_v": 0.8,
    }
    own = law_choice("a:b:{h: 1}").settings("PBCM")
    assert own == {"control.model": "a:b", "control.parameters": {"h": 1}}
    assert law_choice("a:b").settings("a:b#123456") == {"control.model": "a:b"}
    assert law_choice("a:b").settings("a:c#123456")["control.parameters"] == {}


def test_laws_get_the_shortest_names_by_which_they_differ(tmp_path: Path) -> None:
    write_scenario(tmp_path)
    (tmp_path / "other.py").write_text(IDM)
    base = Base(scenario=str(tmp_path / "s.yaml"))

    def labels(*texts: str) -> list[str]:
        return [law.label for law in laws_of(base, texts)]

    assert labels("FM", "mylaws:smith:{headway_s: 1}") == ["FM", "Smith"]
    assert labels("mylaws:smith", "mylaws:smith:{headway_s: 1}") == [
        "Smith",
        "Smith {headway_s: 1}",
    ]
    assert labels("mylaws:smith", "other:smith") == ["mylaws:smith", "other:smith"]
    named = laws_of(base, ["FM", "other:smith"], ["theirs", "mine"])
    assert [law.label for law in named] == ["theirs", "mine"]


def test_colours_are_those_of_the_records_and_differ(tmp_path: Path) -> None:
    write_scenario(tmp_path)
    texts = ["PBCM", "mylaws:smith", *(f"mylaws:smith:{{headway_s: {n}}}" for n in (1, 2, 3))]
    colours = [law.colour for law in laws_of(Base(scenario=str(tmp_path / "s.yaml")), texts)]
    assert colours[:2] == ["#0072B2", "#CC79A7"]
    assert len(set(colours)) == 5


def test_a_law_that_arrays_do_not_run_runs_in_process_with_the_same_figures(
    tmp_path: Path,
) -> None:
    write_scenario(tmp_path)
    branch = IDM.replace("    free = v", "    if v < 0.0:\n        return 0.0\n    free = v")
    (tmp_path / "branching.py").write_text(branch)
    outcome = compare(tmp_path, "--seeds", "2", laws=("mylaws:smith", "branching:smith"))
    assert (outcome.code, outcome.err) == (0, ""), outcome
    assert outcome.out.startswith("branching:smith runs in process, not on arrays: control.model: ")
    rows = table(tmp_path)
    differ = {"cell", "law"}
    left = [{key: value for key, value in row.items() if key not in differ} for row in rows]
    # the first one keeps the parameters that the scenario gives it, and the second has defaults
    assert left[:2] != left[2:]
    again = compare(
        tmp_path, "--seeds", "2", laws=("mylaws:smith", "branching:smith:{headway_s: 1.6}")
    )
    assert again.code == 0
    rows = table(tmp_path)
    left = [{key: value for key, value in row.items() if key not in differ} for row in rows]
    assert left[:2] == left[2:]


def test_gaps_are_compared_as_the_scenario_has_them(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(
        "duration_s: 2\nroad: {type: open}\nfleet: {size: 4, bumper_gap_m: 12}\n"
        "control: {desired_bumper_gap_m: 12}\n"
    )
    outcome = compare(tmp_path, "--seeds", "1", laws=("FM", "CACC"))
    assert outcome.code == 0, outcome
    assert "smallest gap of the run, bumper to bumper, m" in " ".join(outcome.out.split())
    assert all(11.0 < row["smallest_bumper_gap_m"] <= 12.0 for row in table(tmp_path))
    assert "smallest_gap_m" not in table(tmp_path)[0]


def test_laws_in_force_elsewhere_are_named(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(
        "extends: quickstart\n"
        "duration_s: 2\n"
        "fleet: {size: 6, groups: [{name: humans, vehicles: 3, model: FM}]}\n"
        "control: {schedule: [{at_s: 1, model: BCM}]}\n"
        "events: []\n"
    )
    outcome = compare(tmp_path, "--seeds", "1", laws=("FM", "PBCM"))
    assert outcome.code == 0
    lines = outcome.out.splitlines()
    assert lines[0].startswith("control.schedule changes laws from 1 s on; ")
    assert lines[1] == "groups keep laws of their own: humans"


def test_a_file_is_also_found_from_the_current_folder(tmp_path: Path) -> None:
    (tmp_path / "scenarios").mkdir()
    write_scenario(tmp_path / "scenarios")
    (tmp_path / "here.py").write_text(IDM)
    arguments = ("--law", "./here.py:smith", "--seeds", "1", "--out", "out")
    refused = zenvoy(tmp_path, "compare-laws", "scenarios/s.yaml", *arguments)
    assert refused.code == 2
    assert "its file is not beside the scenario; --allow-code runs it  (--law ./here" in refused.err
    allowed = zenvoy(tmp_path, "compare-laws", "scenarios/s.yaml", *arguments, "--allow-code")
    assert (allowed.code, allowed.err) == (0, ""), allowed
    assert "--allow-code" in (tmp_path / "out" / "README.md").read_text()


def test_a_run_that_fails_leaves_the_others(tmp_path: Path) -> None:
    write_scenario(tmp_path)
    raising = IDM.replace("    free = v", "    raise RuntimeError('no idea')\n    free = v")
    (tmp_path / "raising.py").write_text(raising)
    outcome = compare(tmp_path, "--seeds", "2", laws=("FM", "raising:smith"))
    assert outcome.code == 1
    assert outcome.err == "2 of 4 runs failed; see out/README.md\n"
    assert "law Smith raised RuntimeError: no idea" in (tmp_path / "out" / "README.md").read_text()
    assert [row["failure"] is None for row in table(tmp_path)] == [True, True, False, False]


BAD = {
    ("--law", "NOPE"): "control.model: 'NOPE' is not one of FM, BCM, ",
    ("--law", "nope:x"): "control.model: 'nope:x': there is no nope.py beside it, and no ",
    ("--law", "mylaws:nope"): "mylaws.py has no nope; allowed: smith  (--law mylaws:nope)",
    ("--law", "FM", "--law", "FM"): "--law FM: is given twice; allowed: once",
    ("--law", "{a: 1}"): "names no law; allowed: NAME, module:NAME, file.py:NAME, and NAME:{",
    ("--law", "FM:{a"): "not valid YAML: ",
    ("--law", "CACC:{c1: 2}"): "control.platoon.c1: 2 is not in [0, 1)  (--law CACC:{c1: 2})",
    ("--law", "CACC:{c1:2}"): "c1:2: a space is missing after the colon; write c1: 2  (--law ",
    ("--law", "FM:{k_v: 1}"): "control.parameters: given, but FM has no parameters  (--law FM:",
    ("--law", "mylaws:smith:{headway: 1}"): "headway: unknown key; did you mean 'headway_s'?",
    ("--law", "FM", "--measure", "gaps"): "unknown name 'gaps'; allowed: smallest_gap_m, ",
    ("--law", "FM", "--label", "a", "--label", "b"): "--label: 2 for 1 laws; give one per law",
    ("--law", "FM", "--label", " "): "--label ' ': each law needs a name of its own",
    ("--law", "FM", "--seeds", "0"): "--seeds 0: is not at least 1",
    ("--law", "FM", "--seeds", "1000000"): "1,000,000 runs; allowed: at most 100,000  (--law)",
    ("--law", "FM", "--set", "control.model=BCM"): "control.model: is what a comparison varies; ",
    ("--law", "CACC:{c1: 0.6}", "--set", "control.platoon.c1=0.7"): "settings: control.platoon.c1 "
    "is an axis of the study too  (--set)",
    ("--law", "FM", "--set", "fleet.sise=3"): "fleet.sise: unknown key; did you mean 'size'?",
    ("--law", "FM", "--duration-s", "-3"): "duration_s: -3.0 is not in (0, 1e9]  (--duration-s -3",
    ("--law", "FM", "--set", "clock=realtime"): "clock: realtime; a study runs as fast as it can; ",
    (): "zenvoy compare-laws: missing option '--law'; see zenvoy compare-laws --help",
}


@pytest.mark.parametrize("arguments", BAD, ids=" ".join)
def test_a_bad_comparison_is_refused_in_one_line(
    tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    write_scenario(tmp_path)
    outcome = compare(tmp_path, *arguments, laws=())
    assert outcome.code == 2, outcome
    assert outcome.err.count("\n") == 1, outcome.err
    assert BAD[arguments] in outcome.err
    assert not (tmp_path / "out").exists()


def test_problems_of_all_laws_are_reported_at_once(tmp_path: Path) -> None:
    write_scenario(tmp_path)
    with pytest.raises(ScenarioError) as refused:
        laws_of(Base(scenario=str(tmp_path / "s.yaml")), ["FM", "NOPE", "CACC:{c1: 2}"])
    places = [str(problem.place) for problem in refused.value.problems]
    assert places == ["--law CACC:{c1: 2}", "--law NOPE"]


@pytest.mark.parametrize(
    ("mean", "half", "n", "text"),
    [
        (36.7013, 0.0234, 30, "36.701 ± 0.023"),
        (-0.25, 0.1, 30, "−0.25 ± 0.10"),
        (1234.5, 321.0, 30, "1234 ± 321"),
        (2.0, 0.0, 30, "2"),
        (2.5, float("nan"), 1, "2.5 (1 seed)"),
        (2.5, 0.5, 7, "2.50 ± 0.50 (7 seeds)"),
    ],
)
def test_a_mean_has_the_digits_that_its_interval_allows(
    mean: float, half: float, n: int, text: str
) -> None:
    found = Mean(mean=mean, low=mean - half, high=mean + half, n=n)
    assert with_interval(found, 30) == text
