"""The page on real convoys: texts, tables and pictures, and the files that go with it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from zenvoy.analysis.page.drawing import picture_files
from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.page.section import Picture, Sheet
from zenvoy.analysis.paper.reproduction import markdown
from zenvoy.studies.convoys.comparison import Compared
from zenvoy.studies.convoys.findings import findings
from zenvoy.studies.convoys.penetration import EQUIPPED
from zenvoy.studies.convoys.pictures import pictures
from zenvoy.studies.convoys.tables import (
    fits_sheet,
    gaps_sheet,
    growth_sheet,
    recordings_sheet,
    shares_sheet,
)

_SOURCE = (
    "The OpenACC database is a work of the Joint Research Centre of the European Commission "
    "(Makridis, Mattas, Anesiadou and Ciuffo 2021; DOI 10.2905/JRC.KMH3D00; CC BY 4.0). This page "
    "has figures and pictures made of its recordings, but no recording."
)


def write_page(found: Compared, out: Path, command: str) -> list[Path]:
    """Write `out`.md, and its pictures and tables to the folder `out`; return the files.

    Raises OSError.
    """
    drawn = pictures(found)
    sheets = {
        "recordings": recordings_sheet(found),
        "begun": growth_sheet(found, settled=False),
        "settled": growth_sheet(found, settled=True),
        "gaps": gaps_sheet(found),
        "fits": fits_sheet(found),
        **{
            f"shares {settled} {beacon}": shares_sheet(found, settled=settled, all_beacon=beacon)
            for settled in (False, True)
            for beacon in (True, False)
        },
    }
    out.mkdir(parents=True, exist_ok=True)
    files = {f"{sheet.name}.csv": csv_bytes(sheet) for sheet in sheets.values()}
    written = write_whole(out, {**files, **picture_files(drawn)})
    text = "\n".join(_lines(found, drawn, sheets, out.name, command))
    return [*written, *write_whole(out.parent, {f"{out.name}.md": text.encode()})]


def _lines(
    found: Compared, drawn: Sequence[Picture], sheets: dict[str, Sheet], folder: str, command: str
) -> list[str]:
    run, growth, shares = ([*_shown(one, folder), ""] for one in drawn)
    return [
        "# Real convoys",
        "",
        f"Written by `{command}` of Zenvoy {version('zenvoy')}. {_SOURCE}",
        "",
        *(f"- {line}" for line in findings(found)),
        "",
        markdown(sheets["recordings"]),
        "## Laws behind the same leaders",
        "",
        "Each law, with its default parameters, drives all followers behind the recorded "
        "leader. Laws with a constant gap keep the mean gap of the recording, and those with a "
        "desired speed that of the leader. Sensors have no errors, and no frame is lost. The "
        "convoy begins as recorded, with each vehicle out of its law's equilibrium, or it has "
        "settled: the leader first keeps the speed with which it begins for 120 s. Only what "
        "follows a settled start is the answer to the leader alone.",
        "",
        *run,
        *growth,
        markdown(sheets["settled"]),
        markdown(sheets["begun"]),
        markdown(sheets["gaps"]),
        "## Laws that fit cars of today",
        "",
        "`zenvoy calibrate` fits a law to each car, behind the recorded car ahead of it. The free "
        "speed of IDM is at least 1.2 times the highest speed of the recording.",
        "",
        markdown(sheets["fits"]),
        f"## A share of vehicles with {EQUIPPED}",
        "",
        f"Cars of today are those of each recording, under {found.best} as fitted to each. A share "
        f"of them, drawn by seed, gets {EQUIPPED} with Zenvoy's default gains instead. First, all "
        "vehicles send beacons, and the convoy begins as recorded.",
        "",
        *shares,
        markdown(sheets["shares False True"]),
        "The same after a settled start:",
        "",
        markdown(sheets["shares True True"]),
        f"If only equipped vehicles send beacons, {EQUIPPED} falls back to FM wherever the vehicle "
        "behind is not equipped. Begun as recorded:",
        "",
        markdown(sheets["shares False False"]),
        "And after a settled start:",
        "",
        markdown(sheets["shares True False"]),
    ]


def _shown(picture: Picture, folder: str) -> list[str]:
    """Return the lines that show the PNG of a picture above its caption."""
    return [f"![{picture.name}]({folder}/{picture.name}.png)", "", f"*{picture.caption}*"]
