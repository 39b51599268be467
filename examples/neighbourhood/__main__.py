"""Compares filters of the whole neighbourhood with one filter for each link, on Zenvoy's ring.

    python -m examples.neighbourhood --bursts 10

It prints means and 95 % intervals over the seeds. docs/beyond-the-paper.md discusses them.
"""

from __future__ import annotations

import argparse
from typing import Final

import zenvoy
from examples.neighbourhood.hosts import Variant
from examples.neighbourhood.ring import run
from zenvoy.analysis.measures.statistics import mean_of
from zenvoy.scenarios import Scenario

VARIANTS: Final = {
    "one filter per link, PBCM without fallback": Variant(coupled=False, holds=True),
    "one filter per link": Variant(coupled=False),
    "chain of 2 links each way": Variant(reach=2),
    "chain of 3 links each way": Variant(reach=3),
    "chain of 2, speeds of beacons": Variant(reach=2, speeds=True),
    "one filter per link, shared": Variant(coupled=False, shared=True),
    "chain of 2, shared": Variant(reach=2, shared=True),
    "chain of 1 link each way": Variant(),
    "chain of 2, σ 0.5 m/s² more if unheard": Variant(reach=2, unheard_std=0.5),
    "one filter per link, σ 0.1, 0.2 more if unheard": Variant(
        coupled=False, acceleration_std=0.1, unheard_std=0.2
    ),
    "chain of 2, σ 0.1, 0.2 more if unheard": Variant(
        reach=2, acceleration_std=0.1, unheard_std=0.2
    ),
    "chain of 2, speeds of beacons, shared": Variant(reach=2, speeds=True, shared=True),
    "one filter per link, shared, σ 0.1, 0.2 more if unheard": Variant(
        coupled=False, shared=True, acceleration_std=0.1, unheard_std=0.2
    ),
    "chain of 2, shared, σ 0.1, 0.2 more if unheard": Variant(
        reach=2, shared=True, acceleration_std=0.1, unheard_std=0.2
    ),
}
"""Variants by name. If the name does not say otherwise, an unheard vehicle keeps its speed."""

SHARE_LOST: Final = 0.3

HEAD: Final = (
    "| estimates | RMS error of all gaps, m | MinDistance below 37.5 m by, m | smallest gap, m"
    " | collisions | force error, m/s² | unbalanced, m/s² |\n|---|---:|---:|---:|---:|---:|---:|"
)


def scenarios(bursts: int, seeds: int, duration_s: float) -> list[Scenario]:
    """Return case 15 under control from the start, where nobody brakes, for each seed.

    bursts: mean number of frames that a link loses in a row; 0: none is lost.
    """
    loss = {"p": 0.0, "r": 1.0}
    if bursts:
        loss = {"p": SHARE_LOST / (1.0 - SHARE_LOST) / bursts, "r": 1.0 / bursts}
    return [
        zenvoy.scenario(
            "paper/case-15",
            seed=seed,
            duration_s=duration_s,
            control={"schedule": []},
            events=[],
            channel={"loss": {"gilbert_elliott": loss}},
        ).scenario
        for seed in range(1, seeds + 1)
    ]


def row(name: str, runs: list[Scenario], variant: Variant) -> str:
    """Return the row of a variant in the table."""
    found = run(runs, variant)
    below = runs[0].control.desired_gap_m - found.min_distance_at_the_end_m
    columns = [
        mean_of(found.gap_error_rms_m.tolist()).text(3),
        mean_of(below.tolist()).text(2),
        mean_of(found.smallest_gap_m.tolist()).text(1),
        mean_of(found.collisions.tolist()).text(1),
        mean_of(found.force_error_mps2.tolist()).text(4),
        mean_of(found.unbalanced_mps2.tolist()).text(4),
    ]
    return " | ".join((f"| {name}", *columns)) + " |"


def main() -> None:
    """Print the table for one length of bursts."""
    parser = argparse.ArgumentParser(prog="python -m examples.neighbourhood")
    parser.add_argument("--bursts", type=int, default=10, help="mean frames lost in a row; 0: none")
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--duration", type=float, default=200.0, help="of each run, s")
    parser.add_argument("--only", default="", help="run variants whose name contains this text")
    options = parser.parse_args()
    runs = scenarios(options.bursts, options.seeds, options.duration)
    print(HEAD, flush=True)
    for name, variant in VARIANTS.items():
        if options.only in name:
            print(row(name, runs, variant), flush=True)


if __name__ == "__main__":
    main()
