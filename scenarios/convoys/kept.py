"""The files that an import keeps of a convoy: the leader's trace, and all cars as recorded."""

from __future__ import annotations

import csv
from io import StringIO
from typing import Final

from zenvoy.scenarios.convoys.columns import CAR, Columns
from zenvoy.scenarios.convoys.convoy import Convoy
from zenvoy.values.wording import one_line

RECORDED: Final = "recorded.csv"
LEADER: Final = "leader.csv"
KEPT: Final = Columns(time="time_s", speed=f"speed.{CAR}", gap=f"gap.{CAR}", unit="m/s")
_SETTING: Final = "# driven by: "


def recorded_csv(convoy: Convoy) -> str:
    """Return speeds (m/s) and gaps from bumper to bumper (m) of all cars as text of a table."""
    text = StringIO()
    if convoy.setting:
        text.write(f"{_SETTING}{one_line(convoy.setting)}\n")
    writer = csv.writer(text, lineterminator="\n")
    speeds = [f"speed.{car}" for car in convoy.cars]
    writer.writerow(["time_s", *speeds, *(f"gap.{car}" for car in convoy.cars[1:])])
    for time_s, speed, gap in zip(convoy.time_s, convoy.speed, convoy.gap[:, 1:], strict=True):
        values = [*speed, *gap]
        writer.writerow([f"{time_s:.3f}", *(f"{value:.4f}" for value in values)])
    return text.getvalue()


def leader_csv(convoy: Convoy) -> str:
    """Return the leader's speed over time as text of a trace."""
    rows = zip(convoy.time_s, convoy.speed[:, 0], strict=True)
    return "time_s,speed_mps\n" + "".join(f"{at:.3f},{speed:.4f}\n" for at, speed in rows)


def kept_header(text: str) -> bool:
    """Return whether a text begins as `recorded_csv` does."""
    lines = [line for line in text.splitlines()[:2] if not line.startswith(_SETTING)]
    return bool(lines) and lines[0].startswith("time_s,speed.")


def setting_in(text: str) -> str:
    """Return how the cars of a kept table were driven, "" if it does not say."""
    first = text.partition("\n")[0]
    return first.removeprefix(_SETTING).strip() if first.startswith(_SETTING) else ""
