"""What the figures on real convoys say, in sentences."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from zenvoy.studies.convoys.comparison import FITTED, Compared, held_errors
from zenvoy.studies.convoys.penetration import EQUIPPED, SHARES, stopping_share
from zenvoy.studies.convoys.tables import RECORDED, of_setting, shares_of, sources


def findings(found: Compared) -> list[str]:
    """Return a sentence or two for each question that the page answers."""
    return [*_growth(found), *_laws(found), _fit(found), *_shares(found)]


def _growth(found: Compared) -> Iterator[str]:
    """Say how the swing grows in the recordings, by setting."""
    real = sources(found, settled=True)[0]
    for setting in found.settings:
        growth = of_setting(found, real, setting)
        about = f"{growth.n} pairs of cars"
        if not np.isnan(growth.low):
            about = f"95 % interval {growth.low:.3f} to {growth.high:.3f}, {about}"
        yield (
            f"Recorded, {setting or 'not told who drove'}: the swing grows by a median factor of "
            f"{growth.median:.3f} from car to car ({about})."
        )


def _laws(found: Compared) -> Iterator[str]:
    """Say which laws damp the swing of the leaders, over all recordings, after they settled."""
    damping: list[str] = []
    growing: list[str] = []
    for source in sources(found, settled=True):
        if source.name == RECORDED:
            continue
        ratios = [
            float(one.speed[:, -1].std() / one.speed[:, 0].std()) for one in source.motions.values()
        ]
        count = sum(ratio <= 1.0 for ratio in ratios)
        told = f"{source.name} ({count} of {len(ratios)})"
        (damping if 2 * count > len(ratios) else growing).append(told)
    if damping:
        yield (
            "Settled, the last vehicle swings less than the leader in most recordings under "
            f"{', '.join(damping)}."
        )
    if growing:
        yield f"It does so in half of them or fewer under {', '.join(growing)}."


def _fit(found: Compared) -> str:
    """Say which law fits best, and how far."""
    told = []
    for law in FITTED:
        some = [one for (of, _), one in found.fits.items() if of == law]
        own = float(np.median([fit.rms_gap_m for one in some for fit in one.fits]))
        held = [error for one in some for error in held_errors(one)]
        out = f", {np.median(held):.1f} m held out" if held else ""
        told.append(f"{law} {own:.1f} m{out}")
    spread = np.median([p.gap.std() for one in found.fits.values() for p in one.pairs])
    return (
        f"{found.best} fits cars of today best. Median errors of the gap: {'; '.join(told)}. A "
        f"constant gap has {spread:.1f} m."
    )


def _shares(found: Compared) -> Iterator[str]:
    """Say from which share on the growth stops."""
    for settled in (False, True):
        stops = []
        for convoy in found.convoys:
            growth = shares_of(found, convoy.name, settled=settled, all_beacon=True)
            stops.append(stopping_share(growth))
        count = len(stops)
        already = sum(one == 0.0 for one in stops)
        never = sum(one is None for one in stops)
        between = sorted(100.0 * one for one in stops if one)
        begun = "Settled" if settled else "Begun as recorded"
        text = (
            f"{begun}, the swing of cars of today does not grow in {already} of {count} recordings "
            f"even without {EQUIPPED}, and grows in {never} with any share of it"
        )
        if between:
            text += f"; in {len(between)} it stops from {_listed(between)} on"
        yield f"{text}. (Shares of {', '.join(f'{100 * share:.0f}' for share in SHARES)} %.)"


def _listed(percent: list[float]) -> str:
    return ", ".join(f"{one:.0f} %" for one in percent)
