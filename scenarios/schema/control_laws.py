"""The laws that a scenario names, and the parameters that it gives them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from zenvoy.laws import Law, NoParameters, parameters_from

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Control


def parameters_of(control: Control, law: Law) -> Any:
    """Return the parameters of a law, of the law's own type."""
    section = getattr(control, law.section) if law.section else NoParameters()
    return parameters_from(law, section)
