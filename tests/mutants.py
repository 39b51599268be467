"""Randomly changed scenarios load and run, or are refused in clear lines.

`make mutants` (or `python -m tests.mutants 10000`) prints their fates. An accepted mutant runs in
process for 2 s, for at most 200 cycles, and with at most 60 vehicles.
"""

from __future__ import annotations

import random
import sys
import time
import warnings
from collections import Counter
from io import StringIO
from pathlib import Path
from typing import Any, Final

import numpy as np
from ruamel.yaml import YAML

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.topics import TRUTH, Topic
from zenvoy.fleet.agents import agents_of
from zenvoy.scenarios import Scenario, ScenarioError, load
from zenvoy.scenarios.reading.library import packaged

_HANGS_S: Final = 60.0
_VALUES: Final[tuple[Any, ...]] = (
    *(0, 1, -1, 2, 3, 0.5, 1e-9, 1e9, 1e-300, 1e308, 5e-324, 99, 10_000, True, None, "", "all"),
    *("5%", "not all", "x", "1-3", [], {}, [1], [[0, 1], [1, 2]], "PBCM", "CACC", "ukf", "csma"),
)
_LETTERS: Final = ":{}[]-,&*!#|>'\"%@`\t \n0123456789.eE~<xnaif\u2028é\x00"


def text_mutant(text: str, draw: random.Random) -> str:
    """Return the text with a few characters or lines inserted, deleted, doubled or swapped."""
    for _ in range(draw.randint(1, 4)):
        at, end = sorted(draw.randint(0, len(text)) for _ in range(2))
        end = min(end, at + draw.randint(0, 12))
        match draw.randrange(4):
            case 0:
                text = text[:at] + draw.choice(_LETTERS) + text[at:]
            case 1:
                text = text[:at] + text[end:]
            case 2:
                text = text[:end] + text[at:end] + text[end:]
            case _:
                lines = text.splitlines(keepends=True)
                draw.shuffle(lines)
                text = "".join(lines) if draw.random() < 0.2 else text[:at] + "7" + text[end:]
    return text


def tree_mutant(values: Any, draw: random.Random) -> Any:
    """Replace, delete or multiply some values anywhere in a scenario with all its values."""
    for _ in range(draw.randint(1, 3)):
        holder = values
        while True:
            steps = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
            if not steps:
                break
            step = draw.choice(steps)
            deeper = isinstance(holder[step], dict | list) and holder[step]
            if deeper and draw.random() < 0.9:
                holder = holder[step]
                continue
            value = holder[step]
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if draw.random() < 0.1:
                del holder[step]
            elif number and draw.random() < 0.6:
                factor = draw.choice((0, 0.1, 0.5, 0.99, 1.01, 2, 10, 1e3, 1e-3, 1e-9))
                holder[step] = type(value)(value * factor)
            else:
                holder[step] = draw.choice(_VALUES)
            break
    return values


def mutant(number: int) -> str:
    """Return the text of a mutant, which depends on its number only."""
    draw = random.Random(number)
    name = draw.choice(list(packaged()))
    if draw.random() < 0.4:
        return text_mutant(packaged()[name].read_text(), draw)
    values = load(name).scenario.model_dump(mode="json")
    for event in values["events"]:  # the points of a drive cycle are all of one kind
        if "points" in event:
            event["points"] = event["points"][:5]
    stream = StringIO()
    YAML(typ="safe", pure=True).dump(tree_mutant(values, draw), stream)
    return stream.getvalue()


def run(scenario: Scenario) -> bool:
    """Run 2 s of a scenario, and return whether the truth has no NaN."""
    cycles = max(1, min(200, round(2e9) // scenario.period_ns))
    changes = {"duration_s": cycles * scenario.period_ns * 1e-9, "clock": "lock-step", "speed": 1.0}
    scenario = scenario.model_copy(update=changes)
    sound = True

    def log(topic: Topic[Any], _time_ns: int, payload: bytes) -> None:
        nonlocal sound
        if topic is TRUTH:
            truth = pb.FleetTruth.FromString(payload)
            for column in (truth.position, truth.speed, truth.acceleration):
                sound = sound and bool(np.isfinite(np.array(column)).all())

    InProcessBus(agents_of(scenario), log).run()
    return sound


def fate(number: int, folder: Path) -> str:
    """Return the fate of a mutant: "refused", "ran", or what is wrong."""
    path = folder / "mutant.yaml"
    path.write_bytes(mutant(number).encode())
    began = time.monotonic()
    try:
        scenario = load(path).scenario
        if scenario.fleet.size > 60:
            return "accepted, too large to run"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            sound = run(scenario)
    except ScenarioError as error:
        lines = str(error).splitlines()
        return "refused" if 0 < len(lines) <= 21 else "refused in too many lines"
    except Exception as error:  # noqa: BLE001 - any error but ScenarioError is a finding
        return f"traceback: {type(error).__name__}: {error}"[:200]
    if time.monotonic() - began > _HANGS_S:
        return "slow"
    return "ran" if sound else "truth is not finite"


def main(count: int, first: int, folder: Path) -> Counter[str]:
    """Return the fates of mutants, and print the numbers of those that are wrong."""
    fates: Counter[str] = Counter()
    for number in range(first, first + count):
        found = fate(number, folder)
        fates[found] += 1
        if found not in {"refused", "ran", "accepted, too large to run"}:
            print(number, found, flush=True)
    return fates


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        asked = [int(argument) for argument in sys.argv[1:]] or [10_000]
        fates = main(asked[0], asked[1] if len(asked) > 1 else 0, Path(name))
    for what, times in fates.most_common():
        print(f"{times:6d}  {what}")
