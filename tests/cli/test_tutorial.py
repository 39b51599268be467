"""The files and commands of docs/tutorial.md work as they are on the page, up to the picture."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path
from typing import Final

from tests.conftest import LIMIT_S, zenvoy
from tests.docs_blocks import named_blocks

PAGE: Final = Path(__file__).parents[2] / "docs" / "tutorial.md"
PNG: Final = b"\x89PNG"


def test_the_page_leads_from_an_empty_folder_to_a_picture(tmp_path: Path) -> None:
    commands: list[str] = []
    for language, name, body in named_blocks(PAGE.read_text("utf-8")):
        if language == "sh":
            commands += body.splitlines()
        elif name:
            (tmp_path / name).write_text(body)
    assert len(commands) == 8
    for line in commands:
        program, *arguments = shlex.split(line)
        if program == "zenvoy":
            outcome = zenvoy(tmp_path, *arguments)
            assert (outcome.code, outcome.err) == (0, ""), line
        else:
            assert program == "python"
            subprocess.run(
                [sys.executable, *arguments],
                cwd=tmp_path,
                check=True,
                timeout=LIMIT_S,
                env={"MPLBACKEND": "agg", "MPLCONFIGDIR": str(tmp_path)},
            )
    assert (tmp_path / "waves.png").read_bytes().startswith(PNG)
