"""Work that every process of a run would repeat, done once before the fork."""

from __future__ import annotations

from collections import Counter

from zenvoy.bus.in_process import InProcessBus
from zenvoy.fleet.agents import agents_of
from zenvoy.laws import builtin
from zenvoy.laws.by_name import ESTIMATORS
from zenvoy.scenarios import Estimator, MultiNode, Scenario, roster
from zenvoy.vehicles.preparation import prepare


def rehearse(scenario: Scenario) -> None:
    """Compute the gains, and run a few cycles of a small fleet.

    The cycles make the interpreter specialise its bytecode. The forked processes then share it
    instead of each making a copy.
    """
    prepare(scenario)
    # Use the model that most of the fleet ends up with, and drop settings of single vehicles. Leave
    # out the user's own code: an error in it must be reported with its vehicle and time.
    models = Counter(settings.phases[-1].model for settings in roster(scenario))
    known = [model for model, _ in models.most_common() if model in builtin()] or ["FM"]
    control = scenario.control.model_copy(
        update={"model": known[0], "schedule": (), "multi_node": MultiNode(), "parameters": ()}
    )
    of_each = {"groups": (), "initial_gaps_m": None, "initial_speeds_mps": None}
    few = {"size": 2 * control.multi_node.neighbours + 1, **of_each}
    estimator = scenario.estimator
    changes = {
        "control": control,
        "estimator": estimator if estimator.kind in ESTIMATORS.taken() else Estimator(),
        "fleet": scenario.fleet.model_copy(update=few),
        "channel": scenario.channel.model_copy(update={"rules": (), "outages": ()}),
        "events": (),
        "faults": (),
        "duration_s": 64 * scenario.period_ns * 1e-9,
    }
    InProcessBus(agents_of(scenario.model_copy(update=changes)), lambda *_: None).run()
