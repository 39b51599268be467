"""`make diagrams` draws the Mermaid diagrams of docs/ with npm's Mermaid, in headless Chromium.

The pictures are kept in docs/diagrams/, so that a site is built without npm, a browser or internet.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Final

from docs.site.hooks import DIAGRAMS, ROOT, diagram_of

_LOOK: Final[dict[str, Any]] = {
    "theme": "neutral",
    "deterministicIds": True,
    "fontFamily": "sans-serif",
    "htmlLabels": False,
    "flowchart": {"htmlLabels": False},
}


def draw(source: str, picture: Path, mmdc: str, chromium: str) -> None:
    """Draw one diagram."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "diagram.mmd").write_text(source)
        (folder / "look.json").write_text(json.dumps(_LOOK))
        browser = {"executablePath": chromium, "args": ["--no-sandbox"]}
        (folder / "browser.json").write_text(json.dumps(browser))
        files = ("-p", "browser.json", "-c", "look.json", "-i", "diagram.mmd", "-o", picture)
        subprocess.run([mmdc, "-q", "-b", "transparent", *files], check=True, cwd=folder)


def main(mmdc: str) -> None:
    """Draw what is new, and delete pictures that no page shows."""
    chromium = shutil.which("chromium")
    if chromium is None:
        raise SystemExit("chromium: not found; it draws the diagrams")
    folder, shown = ROOT / "docs" / DIAGRAMS, set()
    folder.mkdir(exist_ok=True)
    for page in sorted(ROOT.glob("docs/*.md")):
        for source in re.findall(r"```mermaid\n(.*?)```\n", page.read_text(), re.DOTALL):
            picture = folder / diagram_of(source)
            shown.add(picture)
            if not picture.exists():
                draw(source, picture, str(Path(mmdc).resolve()), chromium)
    for old in set(folder.glob("*.svg")) - shown:
        old.unlink()


if __name__ == "__main__":
    main(sys.argv[1])
