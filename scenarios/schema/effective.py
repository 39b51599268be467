"""Writes a scenario with all its values, defaults included, as text."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from io import StringIO
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.nodes import ScalarNode, SequenceNode
from ruamel.yaml.representer import SafeRepresenter

from zenvoy.scenarios.schema.scenario import Scenario


class _Representer(SafeRepresenter):
    """Quotes all text but plain words, because ruamel does not quote some text that YAML misreads.

    Each list of numbers takes one line, and keys stay in the order of the schema.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.sort_base_mapping_type_on_output = False

    def represent_str(self, data: str) -> ScalarNode:
        style = None if re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", data) else '"'
        return self.represent_scalar("tag:yaml.org,2002:str", data, style=style)

    def represent_list(self, data: list[Any]) -> SequenceNode:
        flow = bool(data) and all(isinstance(item, int | float) for item in data)
        tag = "tag:yaml.org,2002:seq"
        return self.represent_sequence(tag, data, flow_style=True if flow else None)


_Representer.add_representer(str, _Representer.represent_str)
_Representer.add_representer(list, _Representer.represent_list)


def effective_yaml(scenario: Scenario, *, ascii_only: bool = False) -> str:
    """Return YAML with every value in the order of the schema; loading it gives the scenario."""
    return as_yaml(scenario.model_dump(mode="json"), ascii_only=ascii_only)


def as_yaml(values: Mapping[str, Any], *, ascii_only: bool = False) -> str:
    """Return values of a scenario as YAML, in their order."""
    yaml = YAML(typ="safe", pure=True)
    yaml.Representer = _Representer
    yaml.default_flow_style = False
    yaml.allow_unicode = not ascii_only
    yaml.width = 2**31  # no folded lines
    stream = StringIO()
    yaml.dump(dict(values), stream)
    return stream.getvalue()


def effective_json(scenario: Scenario) -> str:
    """Return ASCII JSON with every value and sorted keys; equal scenarios give equal bytes.

    Scenario.model_validate_json reads it back.
    """
    values = scenario.model_dump(mode="json")
    return json.dumps(values, indent=2, sort_keys=True) + "\n"
