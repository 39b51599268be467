"""Laws are sent to a process on another machine, with the modules beside them."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from tests.idm import IDM
from zenvoy.laws.by_name import LAWS, resolve
from zenvoy.laws.carried import Carried, carried
from zenvoy.laws.errors import UnknownLawError


def test_a_law_needs_none_of_its_files_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "idm.py").write_text("from headway import HEADWAY_S\n" + IDM)
    (tmp_path / "headway.py").write_text("HEADWAY_S = 1.2\n")
    reference = resolve("idm:smith", tmp_path)
    packed = pickle.dumps(carried(reference, LAWS))
    for file in tmp_path.glob("*.py"):
        file.unlink()
    script = f"""if True:
        import pickle, sys
        from zenvoy.laws import law_of
        pickle.loads(sys.stdin.buffer.read()).load()
        print(law_of({reference!r}).name)
    """
    done = subprocess.run(
        [sys.executable, "-c", script], input=packed, capture_output=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, b"Smith\n"), done.stderr


def test_another_source_is_refused(tmp_path: Path) -> None:
    (tmp_path / "idm.py").write_text(IDM)
    law = carried(resolve("idm:smith", tmp_path), LAWS)
    assert law is not None
    other = Carried(reference="idm:smith#000000000000", group=law.group, sources=law.sources)
    with pytest.raises(UnknownLawError, match="idm:smith on the worker: its source has changed"):
        other.load()


def test_a_module_that_is_not_installed_there_is_named() -> None:
    law = Carried(reference="elsewhere.laws:smith#000000000000", group=LAWS.group, sources=None)
    with pytest.raises(UnknownLawError, match=r"elsewhere\.laws:smith on the worker: "):
        law.load()


def test_laws_of_zenvoy_are_not_carried() -> None:
    assert carried("FM", LAWS) is None
