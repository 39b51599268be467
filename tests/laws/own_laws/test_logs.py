"""A log has all that its reader needs of the laws: names, colours, columns and linear forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import zenvoy
from tests.logs import write_log
from zenvoy.analysis.compare.pictures import Labelled, colours
from zenvoy.analysis.log.export import export
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.page.report import models
from zenvoy.analysis.theory.laws import Coupling
from zenvoy.analysis.theory.of_run import NoTheoryError, theory_of
from zenvoy.bus import messages_pb2 as pb


def test_log_and_report_name_the_laws_without_their_code(laws: Path, mixed: Run) -> None:
    (laws / "idm.py").unlink()
    (laws / "rich.py").unlink()
    run = load(mixed.log)
    own = {law.name: law for mode, law in run.laws.items() if mode >= pb.MODE_OWN}
    assert set(own) == {"Smith", "Rich"}
    assert own["Smith"].colour == "#CC79A7"
    assert own["Smith"].reference.startswith("idm:smith#")
    assert set(run.estimate["mode"][-1, 4:]) == {own["Smith"].mode}
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
    assert "Smith" in file.read_text()


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
    with pytest.raises(NoTheoryError, match="vehicle 1 ran Smith"):
        theory_of(idm, 1.0, 3.0)


def test_a_comparison_has_the_colours_of_the_laws(laws: Path) -> None:
    text = "{duration_s: 2, fleet: {size: 3}, control: {model: %s}}"
    runs = [
        Labelled(name, load(write_log(laws / f"{number}.mcap", text % model)))
        for number, (name, model) in enumerate([("a", '"idm:smith"'), ("b", "BCM")])
    ]
    assert colours(runs) == ["#CC79A7", "#D55E00"]
