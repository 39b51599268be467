"""The files of a folder that holds a convoy's scenario."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from zenvoy.scenarios.convoys.convoy import Convoy
from zenvoy.scenarios.convoys.kept import LEADER, RECORDED, leader_csv, recorded_csv
from zenvoy.scenarios.schema.effective import as_yaml

SCENARIO: Final = "scenario.yaml"


def files_of(convoy: Convoy, values: Mapping[str, Any]) -> dict[str, str]:
    """Return texts by name of file: the leader's trace, all cars as recorded, and the scenario."""
    return {
        LEADER: leader_csv(convoy),
        RECORDED: recorded_csv(convoy),
        SCENARIO: as_yaml(values),
    }
