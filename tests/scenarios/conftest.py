"""Fixtures that write scenarios into a folder of their own, the current one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.refusals import refusal_of

Refusal = Callable[..., str]
Here = Callable[[str, str], Path]
Write = Callable[[str], Path]


@pytest.fixture
def refusal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Refusal:
    """Return a function that writes a text to s.yaml and returns the message of its refusal."""
    monkeypatch.chdir(tmp_path)

    def refuse(text: str | bytes, *settings: str, **options: Any) -> str:
        Path("s.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
        return refusal_of("s.yaml", *settings, **options)

    return refuse


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    """Return a function that writes a text to s.yaml, and returns its path."""
    monkeypatch.chdir(tmp_path)

    def write_it(text: str) -> Path:
        Path("s.yaml").write_bytes(text.encode())
        return Path("s.yaml")

    return write_it


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Here:
    """Return a function that writes s.yaml and drive.csv into the current folder."""
    monkeypatch.chdir(tmp_path)

    def write(text: str, csv: str) -> Path:
        Path("s.yaml").write_text(text)
        Path("drive.csv").write_bytes(csv.encode())
        return Path("s.yaml")

    return write
