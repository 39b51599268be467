"""Every command that reads logs runs on mutated logs. None may end in a traceback, or hang.

    python -m tests.mutated_logs [MUTANTS] [--seed SEED] [--draw PICTURES]

Mutants come from a few small logs on three levels: bytes of the file, records of MCAP, and messages
with valid checksums. Each goes through `info --verify`, `analyze`, `export` and `compare`. At most
PICTURES pictures are drawn, as `trial.py` says.

The module prints a table by kind of mutant, on SIGTERM that of the mutants so far. It exits with 1
if a mutant ends in a traceback, takes more than a minute, or is read without a report.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys

from tests.mutated_logs.trial import Outcome, tried


def _say(outcome: Outcome, wrong: list[str]) -> None:
    for text in wrong:
        print(text, file=sys.stderr, flush=True)
    if outcome.tried % 100 == 0:
        print(outcome.tried, "wrong:", len(outcome.wrong), file=sys.stderr, flush=True)


def main() -> int:
    """Run the module."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutated_logs")
    parser.add_argument("mutants", type=int, nargs="?", default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--draw", type=int, default=400, metavar="PICTURES")
    arguments = parser.parse_args()
    asked: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: asked.append(number))
    os.environ.setdefault("COLUMNS", "400")  # lines that are not wrapped take less time
    outcome = tried(
        arguments.mutants, arguments.seed, arguments.draw, say=_say, enough=lambda: bool(asked)
    )
    print(f"{outcome.tried} mutants")
    kinds = sorted(outcome.refused | outcome.reported | outcome.unnoticed)
    print(f"{'kind':<28}{'refused':>9}{'notes':>9}{'silent':>9}")
    for kind in kinds:
        counts = (outcome.refused[kind], outcome.reported[kind], outcome.unnoticed[kind])
        print(f"{kind:<28}" + "".join(f"{count:>9}" for count in counts))
    print(f"pictures: {outcome.drawn} drawn, {outcome.not_drawn} not drawn")
    print("slowest command: {:.1f} s, {}".format(*outcome.slowest))
    print(f"wrong: {len(outcome.wrong)}")
    for wrong in outcome.wrong[:50]:
        print(wrong)
    return bool(outcome.wrong)


if __name__ == "__main__":
    sys.exit(main())
