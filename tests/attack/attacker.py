"""The attacker's process: it receives all messages, and sends mutants in each cycle."""

from __future__ import annotations

import signal
from collections.abc import Sequence
from typing import Final

import zenoh

from tests.attack.bundler import Bundler
from tests.attack.messages import Seen, streams
from tests.attack.mutator import Mutator
from tests.attack.turns import Turns
from zenvoy.bus.session import open_session
from zenvoy.bus.vehicle_processes import VehicleProcess

FIRST_CYCLE: Final = 12


def attack(
    run: str,
    size: int,
    shared: Sequence[VehicleProcess],
    links: tuple[str, list[str]],
    per_cycle: int,
    realtime: bool,
    turns: Turns,
) -> None:
    """Send `per_cycle` mutants in each cycle from FIRST_CYCLE on.

    `links` are the endpoint to listen on and those to connect to. The attacker always reads its
    messages, since a reader that does not read stops a run in lock-step.
    """
    listen, connect = links
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGTERM,))
    with open_session([listen], connect, realtime=realtime) as session:
        topics = streams(run, size)
        mutator, bundler = Mutator(run, size, seed=1), Bundler(run, shared, seed=1)
        while turns.next() < 2:
            turns.done()  # a subscriber that comes before the real reader would be taken for it
        heard = session.declare_subscriber(
            f"zenvoy/{run}/**", zenoh.handlers.RingChannel(1_000), allowed_origin=_OTHERS
        )
        drop = zenoh.CongestionControl.DROP if realtime else zenoh.CongestionControl.BLOCK
        while True:
            turns.done()
            cycle = turns.next()
            while (sample := heard.try_recv()) is not None:
                key, payload = str(sample.key_expr), sample.payload.to_bytes()
                of = topics.get(key)
                if of is not None and sample.attachment is None:
                    mutator.see(Seen(*of, payload, of[0].decode(payload).cycle))
                for seen in bundler.seen(key, payload):
                    mutator.see(seen)
            if cycle < FIRST_CYCLE:
                continue
            for mutant in mutator.mutants(per_cycle):
                key, made, attachment = bundler.bundled(mutant)
                if made is None:
                    session.delete(key, congestion_control=drop)
                else:
                    session.put(key, made, attachment=attachment, congestion_control=drop)


_OTHERS: Final = zenoh.Locality.REMOTE
