"""The V2X technologies of the paper's Table I, as data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class Technology:
    """A column of Table I. `default_mbps` is the rate we use where the table gives a range."""

    name: str
    title: str
    band_ghz: tuple[float, float]
    bandwidth: str
    range_m: float
    bit_rate: str
    default_mbps: float
    delay_ms: tuple[float, float]
    broadcast: bool
    v2v: bool = True
    mimo: bool = True


TECHNOLOGIES: Final = {
    technology.name: technology
    for technology in (
        Technology(
            name="ieee80211p",
            title="IEEE 802.11p",
            band_ghz=(5.85, 5.925),
            bandwidth="10 MHz",
            range_m=1_000.0,
            bit_rate="3 to 27 Mbit/s",
            default_mbps=6.0,  # the default rate of the ITS-G5 control channel
            delay_ms=(10.0, 10.0),
            broadcast=True,
        ),
        Technology(
            name="ieee80211px",
            title="IEEE 802.11px",
            band_ghz=(5.85, 5.925),
            bandwidth="10 MHz",
            range_m=1_000.0,
            bit_rate="≥ 60 Mbit/s",
            default_mbps=60.0,
            delay_ms=(10.0, 10.0),
            broadcast=True,
        ),
        Technology(
            name="lte-a-pro",
            title="LTE-A Pro",
            band_ghz=(5.72, 5.75),
            bandwidth="≥ 640 MHz",
            range_m=30_000.0,
            bit_rate="≥ 3 Gbit/s",
            default_mbps=3_000.0,
            delay_ms=(20.0, 80.0),
            broadcast=True,
        ),
        Technology(
            name="5g-mmwave",
            title="5G mmWave",
            band_ghz=(57.05, 64.0),
            bandwidth="2.16 GHz",
            range_m=50.0,
            bit_rate="≥ 7 Gbit/s",
            default_mbps=7_000.0,
            delay_ms=(10.0, 10.0),
            broadcast=False,
        ),
    )
}
