"""Tells who is missing in a run that other machines join."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from zenvoy.fleet.ends import Death
from zenvoy.fleet.guests import RunEndpoints, from_elsewhere
from zenvoy.fleet.muster import Muster
from zenvoy.fleet.progress import Arrival
from zenvoy.values.wording import spans


class Waiting:
    """Tells who is missing in a run, and how to join it, until the fleet is complete.

    realtime: the run goes on without a vehicle that is lost, so this tells who comes and goes.
    """

    def __init__(
        self, muster: Muster, console: Console, certs: Path | None, *, realtime: bool
    ) -> None:
        self._muster, self._console, self._certs = muster, console, certs
        self._realtime = realtime
        self._changed = self._complete = False

    def begin(self, endpoints: RunEndpoints) -> None:
        """Tell how to join."""
        missing = spans(self._muster.missing)
        option = "--router" if endpoints.router else "--connect"
        connect = " ".join(f"{option} {one}" for one in from_elsewhere(endpoints))
        certs = "" if self._certs is None else " --certs DIR"
        self._say(f"waiting for vehicles {missing}; to join, on any machine:")
        self._say(f"  zenvoy join --run {endpoints.run} {connect}{certs} --vehicles N-M")

    def note(self, arrival: Arrival) -> None:
        """Take note of an arrival; tell when the fleet is complete."""
        if not self._muster.note(arrival):
            return
        if self._complete and self._realtime:
            what = "is back" if arrival.there else "has gone; the run goes on"
            self._say(f"{arrival.process}{self._on_host(arrival.process)} {what}")
        elif not self._complete:
            self._changed = True
            self._complete = not self._muster.missing
            if self._complete:
                self._say("the fleet is complete")

    def tell(self) -> None:
        """Tell who is missing, if that has changed; call it when nobody has come for a while."""
        if self._changed and not self._complete:
            self._changed = False
            self._say(f"missing: vehicles {spans(self._muster.missing)}")

    def where(self, death: Death) -> str:
        """Return the machine of the process that has died, as the end of a line."""
        return self._on_host(death.name)

    def _on_host(self, process: str) -> str:
        host = self._muster.host_of(process)
        return f" (on {host})" if host else ""

    def _say(self, text: str) -> None:
        self._console.print(text, highlight=False, soft_wrap=True)
