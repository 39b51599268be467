"""On which other machine each vehicle runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import zenoh

from zenvoy.bus.topics import host_key, is_plain


def watch_hosts(
    session: zenoh.Session, run: str, driven: Mapping[str, Sequence[int]], hosts: dict[int, str]
) -> zenoh.Subscriber[None]:
    """Keep the machine of each vehicle in `hosts`, as long as the result is kept.

    driven: the vehicles of each process.
    """

    def note(sample: zenoh.Sample) -> None:
        *_, process, host = str(sample.key_expr).split("/")
        if sample.kind == zenoh.SampleKind.PUT and is_plain(host):
            hosts.update(dict.fromkeys(driven.get(process, ()), host))

    return session.liveliness().declare_subscriber(host_key(run), note, history=True)
