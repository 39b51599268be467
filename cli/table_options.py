"""Options that name the units of a table."""

from __future__ import annotations

from typing import Annotated

import typer

SpeedUnitOption = Annotated[
    str | None,
    typer.Option(help="Unit of the speeds: m/s, km/h, mph, knots [default: from the header]."),
]
TimeUnitOption = Annotated[
    str | None,
    typer.Option(help="Unit of the times: s, ms, us, ns, min [default: from the header, or s]."),
]
