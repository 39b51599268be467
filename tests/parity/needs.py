"""The mark of tests that need SUMO."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

import pytest

needs_libsumo: Final = pytest.mark.skipif(
    find_spec("libsumo") is None, reason="libsumo is not installed (extra dev)"
)
