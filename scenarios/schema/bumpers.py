"""Spacing from bumper to bumper, which may be given instead of that from front to front."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from pydantic import ConfigDict

from zenvoy.values.section import LARGEST


def _bumper_schema(front: str) -> dict[str, Any]:
    """Return the JSON schema of a spacing that is given instead of `front`."""
    words = f"Instead of `{front}`: from bumper to bumper, a vehicle length less."
    return {"type": "number", "exclusiveMinimum": 0, "maximum": LARGEST, "description": words}


def _bumper(front: str, bumper: str) -> Callable[[dict[str, Any]], None]:
    """Also allow the key `bumper`, which `zenvoy.scenarios.reading.spacing` turns into `front`."""

    def add(schema: dict[str, Any]) -> None:
        properties, added = schema["properties"], _bumper_schema(front)
        keys = list(properties)
        keys.insert(keys.index(front) + 1, bumper)
        schema["properties"] = {key: properties.get(key, added) for key in keys}

    return add


BUMPER_GAP: Final = ConfigDict(json_schema_extra=_bumper("gap_m", "bumper_gap_m"))
DESIRED_BUMPER_GAP: Final = ConfigDict(
    json_schema_extra=_bumper("desired_gap_m", "desired_bumper_gap_m")
)
