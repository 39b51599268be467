"""A vehicle in C++ drives in a fleet: `make external-cpp` compiles it and runs this test.

It needs g++, protoc and the headers of protobuf, and `make test` must pass on a machine without
them. `make test` does the same with a vehicle in Python.
"""

from __future__ import annotations

import os
from pathlib import Path

from tests.fleet.test_external_vehicle import drives_in_a_fleet


def test_a_vehicle_in_another_language_drives_in_a_fleet(tmp_path: Path) -> None:
    program = Path(os.environ["ZENVOY_VEHICLE_CPP"]).absolute()
    drives_in_a_fleet(tmp_path, tmp_path, str(program))
