"""`python -m tests.parity sine|braking|limits|headways` prints a part of docs/validation.md."""

from __future__ import annotations

import argparse

from tests.parity.printed import PARTS


def main() -> None:
    """Print the tables of a part."""
    parser = argparse.ArgumentParser(prog="python -m tests.parity", description=__doc__)
    parser.add_argument("part", choices=PARTS)
    print("\n".join(PARTS[parser.parse_args().part]()))


if __name__ == "__main__":
    main()
