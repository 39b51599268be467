"""`python -m zenvoy.cli` is the `zenvoy` command."""

from __future__ import annotations

from zenvoy.cli.entry import main

if __name__ == "__main__":
    main()
