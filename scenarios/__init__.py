"""Scenarios: the built-in library, the schema, and the code that reads and validates them."""

from __future__ import annotations

from zenvoy.links.loss.four_state import FourState
from zenvoy.links.loss.gilbert_elliott import GilbertElliott
from zenvoy.links.loss.path_loss import PathLoss
from zenvoy.scenarios.errors import (
    InvalidScenarioError,
    Place,
    Problem,
    ScenarioError,
    UnknownScenarioError,
    UnreadableScenarioError,
)
from zenvoy.scenarios.reading.loader import Loaded, builtin, load
from zenvoy.scenarios.reading.recordings import Recording
from zenvoy.scenarios.reading.spelling import COMMAND_LINE, PYTHON, Spelling
from zenvoy.scenarios.reading.trace_files import read_trace
from zenvoy.scenarios.schema.attendance import Attendance, attendance
from zenvoy.scenarios.schema.channel import (
    Channel,
    Latency,
    Loss,
    Medium,
    Outage,
    Rule,
    Scope,
    SenderOffset,
)
from zenvoy.scenarios.schema.control import Control, GainChanges, MultiNode, Platoon, Switch
from zenvoy.scenarios.schema.control_laws import key_of, modes, name_of, parameters_of
from zenvoy.scenarios.schema.courses import Course, Targets
from zenvoy.scenarios.schema.effective import effective_json, effective_yaml
from zenvoy.scenarios.schema.events import Brake, Sine, Trace
from zenvoy.scenarios.schema.fault import NEVER_NS, Fault, reading_of
from zenvoy.scenarios.schema.faults import ActuatorStuck, all_faults, faults_of
from zenvoy.scenarios.schema.faults_of_processes import (
    ProcessFrozen,
    ProcessKilled,
    ProcessSlowed,
)
from zenvoy.scenarios.schema.faults_of_sensors import (
    READINGS,
    SensorBiased,
    SensorBlind,
    SensorDrifting,
    SensorFrozen,
    SensorJumping,
)
from zenvoy.scenarios.schema.faults_of_transmitters import (
    TransmitterBabbling,
    TransmitterLying,
    TransmitterRepeating,
    TransmitterSilent,
)
from zenvoy.scenarios.schema.fleet import Fleet, Gains, Group, Vehicle
from zenvoy.scenarios.schema.inputs import Model
from zenvoy.scenarios.schema.own_laws import own_laws, setpoint_at
from zenvoy.scenarios.schema.roster import Limits, Phase, Settings, group_members, roster
from zenvoy.scenarios.schema.scenario import Beacons, Estimator, Road, Scenario, Sensors
from zenvoy.scenarios.schema.sets import members
from zenvoy.scenarios.schema.technologies import technologies
from zenvoy.scenarios.schema.technology import Technology
from zenvoy.scenarios.schema.trace_options import READERS as TRACE_OPTIONS

__all__ = [
    "COMMAND_LINE",
    "NEVER_NS",
    "PYTHON",
    "READINGS",
    "TRACE_OPTIONS",
    "ActuatorStuck",
    "Attendance",
    "Beacons",
    "Brake",
    "Channel",
    "Control",
    "Course",
    "Estimator",
    "Fault",
    "Fleet",
    "FourState",
    "GainChanges",
    "Gains",
    "GilbertElliott",
    "Group",
    "InvalidScenarioError",
    "Latency",
    "Limits",
    "Loaded",
    "Loss",
    "Medium",
    "Model",
    "MultiNode",
    "Outage",
    "PathLoss",
    "Phase",
    "Place",
    "Platoon",
    "Problem",
    "ProcessFrozen",
    "ProcessKilled",
    "ProcessSlowed",
    "Recording",
    "Road",
    "Rule",
    "Scenario",
    "ScenarioError",
    "Scope",
    "SenderOffset",
    "SensorBiased",
    "SensorBlind",
    "SensorDrifting",
    "SensorFrozen",
    "SensorJumping",
    "Sensors",
    "Settings",
    "Sine",
    "Spelling",
    "Switch",
    "Targets",
    "Technology",
    "Trace",
    "TransmitterBabbling",
    "TransmitterLying",
    "TransmitterRepeating",
    "TransmitterSilent",
    "UnknownScenarioError",
    "UnreadableScenarioError",
    "Vehicle",
    "all_faults",
    "attendance",
    "builtin",
    "effective_json",
    "effective_yaml",
    "faults_of",
    "group_members",
    "key_of",
    "load",
    "members",
    "modes",
    "name_of",
    "own_laws",
    "parameters_of",
    "read_trace",
    "reading_of",
    "roster",
    "setpoint_at",
    "technologies",
]
