"""Signals hit the processes of a run at any moment, and the run must end as documented.

`make chaos` runs 500 cases at random moments, and compares their ends with those in docs/ends.md.
tests/fleet/test_chaos.py runs a sample.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import pytest

from tests.chaos.cases import Case, random_cases
from tests.chaos.found import Found, table
from tests.chaos.trial import try_case


def main() -> int:
    """Run cases and print the table. Return 1 if any end is wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.chaos", description=__doc__)
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    cases = random_cases(options.runs, options.seed)
    with tempfile.TemporaryDirectory(prefix="chaos-") as name:
        folders = [Path(name) / str(number) for number in range(len(cases))]
        with ThreadPoolExecutor(options.jobs) as pool:
            results = list(pool.map(partial(_try_and_print, len(cases)), cases, folders))
    print(table(results))
    wrong = [one for one in results if one.wrong]
    for one in wrong:
        print(f"{one.case}: {'; '.join(one.wrong)}")
    print(f"{len(results)} runs, {len(wrong)} wrong")
    return bool(wrong)


def _try_and_print(count: int, case: Case, folder: Path) -> Found:
    try:
        found = try_case(case, folder)
    except pytest.fail.Exception as error:  # a wait has timed out
        found = Found(case, [str(error)])
    print(
        f"{int(folder.name) + 1} of {count}: {case}: {found.wrong or 'as documented'}", flush=True
    )
    return found


if __name__ == "__main__":
    sys.exit(main())
