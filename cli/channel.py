"""`zenvoy channel`: draw what the channel of a scenario does, without a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.console import Console

from zenvoy.analysis.chapters.v2v import v2v_section
from zenvoy.analysis.measures.traffic import DrawnTraffic
from zenvoy.analysis.page.html import Page
from zenvoy.analysis.page.report import made_by
from zenvoy.bus.clock import stamp
from zenvoy.channel.rehearsal import rehearse
from zenvoy.cli import exits
from zenvoy.cli.analyze import OutError, folder_for, write_page
from zenvoy.cli.sections import print_section
from zenvoy.scenarios import Loaded, effective_yaml


def channel(loaded: Loaded, out: Path | None, console: Console, errors: Console) -> int:
    """Print and draw what happens to the frames of a fleet; return the exit code."""
    try:
        folder = folder_for(Path("runs") / f"{stamp()}-channel" if out is None else out)
    except OutError as error:
        errors.print(str(error))
        return exits.BAD_INPUT
    section = v2v_section(_drawn(loaded))

    def print_result() -> None:
        console.print(_lead(loaded))
        print_section(console, section)

    page = Page(
        title=f"Channel of {loaded.name}, seed {loaded.scenario.seed}",
        lead=_lead(loaded),
        sections=(section,),
        folded=(("The scenario with all its values", effective_yaml(loaded.scenario)),),
        made=(made_by(f"zenvoy channel {loaded.name}"),),
    )
    return write_page(page, "channel.html", folder, console, errors, print_result)


def _drawn(loaded: Loaded) -> DrawnTraffic:
    scenario = loaded.scenario
    tables = list(rehearse(scenario))
    busy = [table.pop("busy_ratio").reshape(-1, scenario.fleet.size) for table in tables]
    columns = [name for name, column in tables[0].items() if column.ndim]
    frames = {name: np.concatenate([table[name] for table in tables]) for name in columns}
    rows = [len(table["source"]) for table in tables]
    frames["cycle"] = np.repeat(np.arange(len(tables), dtype=np.uint32), rows)
    ratio = np.concatenate(busy).astype(np.float64)
    return DrawnTraffic(scenario=scenario, frames=frames, busy_ratio=ratio)


def _lead(loaded: Loaded) -> str:
    scenario = loaded.scenario
    length_m = scenario.ring_length_m
    gaps_m, speed_mps = scenario.fleet.gaps_at_start_m, scenario.fleet.speeds_at_start_mps[0]
    apart = f"{min(gaps_m):g} m"
    if max(gaps_m) > min(gaps_m):
        apart = f"{min(gaps_m):g} to {max(gaps_m):g} m"
    road = "on the open road" if length_m is None else f"on a ring of {length_m:g} m"
    return (
        f"{scenario.fleet.size} vehicles {road} drive on at {speed_mps:g} m/s, {apart} apart, "
        f"for {scenario.duration_s:g} s. No controller acts: "
        f"only the channel and the beacons are simulated."
    )
