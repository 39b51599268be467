"""A scenario that is split at random into files that extend each other is the same scenario."""

from __future__ import annotations

from io import StringIO
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from zenvoy.scenarios import (
    Brake,
    Control,
    Fleet,
    Gains,
    Scenario,
    Switch,
    builtin,
    effective_yaml,
    load,
)

Values = dict[str, Any]

WHOLES = [load(name).scenario for name, _ in builtin()[:3]] + [
    Scenario(
        fleet=Fleet(size=5),
        control=Control(model="FM", schedule=(Switch(at_s=3, model="BCM"),), gains=Gains(k_d=0.3)),
        events=(Brake(vehicle=5, at_s=1, duration_s=1, deceleration_mps2=1),),
    )
]
junk = st.none() | st.integers(-3, 3) | st.text(max_size=3) | st.lists(st.integers(), max_size=2)


@st.composite
def split(draw: st.DrawFn, whole: Values) -> tuple[Values, Values]:
    """Split a scenario into a base and its extension. Some values are in both."""
    base: Values = {}
    extension: Values = {}
    for key, value in whole.items():
        where = draw(st.sampled_from(["base", "extension", "both"]))
        if where != "both":
            (base if where == "base" else extension)[key] = value
        elif isinstance(value, dict):
            base[key], extension[key] = draw(split(value))
        else:
            base[key], extension[key] = draw(junk), value
    return base, extension


def _yaml(values: Values) -> str:
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False  # within braces, the reader of YAML refuses its own `?x`
    stream = StringIO()
    yaml.dump(values, stream)
    return stream.getvalue()


@settings(deadline=None)
@given(st.sampled_from(WHOLES), st.data())
def test_a_scenario_split_at_random_loads_equal_to_the_whole(
    folder: Path, whole: Scenario, data: st.DataObject
) -> None:
    base, extension = data.draw(split(whole.model_dump(mode="json")))
    root, middle = data.draw(split(base))
    texts = {
        "root": _yaml(root),
        "middle": _yaml({"extends": "root.yaml", **middle}),
        "s": _yaml({**extension, "extends": "middle.yaml"}),
    }
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text)
    assert load(folder / "s.yaml").scenario == whole
    assert load(folder / "s.yaml", ["seed=5"]).scenario == whole.model_copy(update={"seed": 5})
    (folder / "again.yaml").write_text(effective_yaml(load(folder / "s.yaml").scenario))
    assert load(folder / "again.yaml").scenario == whole
