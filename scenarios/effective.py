"""A scenario with all its values, defaults included, as text."""

from __future__ import annotations

import json
import re
from io import StringIO

from ruamel.yaml import YAML
from ruamel.yaml.nodes import ScalarNode
from ruamel.yaml.representer import SafeRepresenter

from zenvoy.scenarios.schema import Scenario


class _Representer(SafeRepresenter):
    """Quotes every text but plain words: ruamel leaves some that YAML reads as something else."""

    def represent_str(self, data: str) -> ScalarNode:
        style = None if re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", data) else '"'
        return self.represent_scalar("tag:yaml.org,2002:str", data, style=style)


_Representer.add_representer(str, _Representer.represent_str)


def effective_yaml(scenario: Scenario) -> str:
    """YAML with every value in the order of the schema; loading it gives an equal scenario."""
    yaml = YAML(typ="safe", pure=True)
    yaml.Representer = _Representer
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 2**31  # no folded lines
    stream = StringIO()
    yaml.dump(scenario.model_dump(mode="json"), stream)
    return stream.getvalue()


def effective_json(scenario: Scenario) -> str:
    """ASCII JSON with every value, keys sorted: equal scenarios give equal text, byte for byte.

    Scenario.model_validate_json reads it back.
    """
    values = scenario.model_dump(mode="json")
    return json.dumps(values, indent=2, sort_keys=True) + "\n"
