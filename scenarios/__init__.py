"""What is run: the library of scenarios, and the schema that loads and validates them."""

from __future__ import annotations

from zenvoy.scenarios.effective import effective_json, effective_yaml
from zenvoy.scenarios.errors import (
    InvalidScenarioError,
    Place,
    Problem,
    ScenarioError,
    UnknownScenarioError,
    UnreadableScenarioError,
)
from zenvoy.scenarios.events import Brake, Sine, Trace
from zenvoy.scenarios.loader import Loaded, builtin, load
from zenvoy.scenarios.schema import (
    Channel,
    Control,
    Estimator,
    Fleet,
    Gains,
    Loss,
    Model,
    Road,
    Scenario,
    Sensors,
    Switch,
    TechnologyName,
)

__all__ = [
    "Brake",
    "Channel",
    "Control",
    "Estimator",
    "Fleet",
    "Gains",
    "InvalidScenarioError",
    "Loaded",
    "Loss",
    "Model",
    "Place",
    "Problem",
    "Road",
    "Scenario",
    "ScenarioError",
    "Sensors",
    "Sine",
    "Switch",
    "TechnologyName",
    "Trace",
    "UnknownScenarioError",
    "UnreadableScenarioError",
    "builtin",
    "effective_json",
    "effective_yaml",
    "load",
]
