"""When commands take effect, as seen from the start of a cycle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from zenvoy.scenarios import Scenario


@dataclass(frozen=True)
class Timing:
    """The timing of a scenario in lock-step, in ns. Every vehicle decides at t_k + wait."""

    period_ns: int
    wait_ns: int
    effect_ns: int
    """The time from the start of a cycle to the effect of its commands."""
    keep_ns: int
    """The time for which vehicles remember the past."""
    age_limit_ns: int

    @classmethod
    def of(cls, scenario: Scenario) -> Timing:
        """Return the timing of a scenario."""
        age_ns, delay_ns = scenario.beacon_age_limit_ns, scenario.system_delay_ns
        return cls(
            period_ns=scenario.period_ns,
            wait_ns=scenario.v2v_wait_ns,
            effect_ns=scenario.v2v_wait_ns + delay_ns,
            keep_ns=age_ns + delay_ns + 4 * scenario.period_ns,
            age_limit_ns=age_ns,
        )

    @cached_property
    def lag(self) -> int:
        """The number of cycles after which a command is in force at the start of a cycle."""
        return max(1, -(-self.effect_ns // self.period_ns))

    @cached_property
    def starts_ns(self) -> tuple[int, ...]:
        """The times after t_k at which commands known at t_k take effect; the first is in force."""
        under_way = range(1, self.lag)
        return (0, *((i - self.lag) * self.period_ns + self.effect_ns for i in under_way))

    def starts_of(self, known: int) -> tuple[int, ...]:
        """Return the first of `starts_ns` and the last known - 1, for that many known commands."""
        return (0, *self.starts_ns[self.lag - known + 1 :])
