"""Run the `zenvoy` command by `python -m zenvoy.cli`."""

from __future__ import annotations

from zenvoy.cli.entry import main

if __name__ == "__main__":
    main()
