"""Mutations change metadata, attachments and messages of a log. All checksums of MCAP hold."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import replace
from random import Random
from typing import Final

from tests.log_surgery import rewritten
from tests.mutated_logs.bases import Base, Mutation
from tests.streamed_log import Logged
from zenvoy.bus.log_metadata import CHECKSUM, RESULT, RUN, sealed


def changed_metadata(base: Base, random: Random) -> tuple[str, dict[str, str]]:
    name = random.choice((RUN, RESULT))
    metadata = dict(base.log.metadata[name])
    key = random.choice([key for key in metadata if key != CHECKSUM])
    value = metadata[key]
    other = (
        value[::-1],
        "",
        "x",
        "-1",
        "1e400",
        "nan",
        "9" * 400,
        f"{value}1",
        "[/b]\n\x1b[2J",
    )
    if random.random() < 0.3:
        del metadata[key]
    else:
        metadata[key] = random.choice(other)
    return name, metadata


def other_metadata(base: Base, random: Random) -> bytes:
    name, metadata = changed_metadata(base, random)
    if metadata == base.log.metadata[name]:
        return base.content
    return rewritten(replace(base.log, metadata={**base.log.metadata, name: metadata}))


def other_metadata_sealed(base: Base, random: Random) -> bytes:
    name, metadata = changed_metadata(base, random)
    metadata.pop(CHECKSUM, None)
    changed = {**base.log.metadata, name: sealed(metadata)}
    return rewritten(replace(base.log, metadata=changed))


def other_scenario(base: Base, random: Random) -> bytes:
    """Replace the scenario by that of another log, or change bytes of it."""
    text = bytearray(base.log.attachments["effective.json"])
    if random.random() < 0.3:
        text = bytearray(random.choice(base.scenarios))
    digits = [i for i, byte in enumerate(text) if chr(byte).isdigit()]
    for _ in range(random.choice((1, 1, 3))):
        text[random.choice(digits)] = ord(random.choice("0123456789"))
    if random.random() < 0.2:
        del text[random.randrange(len(text)) :]
    changed = {**base.log.attachments, "effective.json": bytes(text)}
    return rewritten(replace(base.log, attachments=changed))


def with_changed_messages(
    base: Base, random: Random, change: Callable[[Logged], list[Logged]], share: float
) -> bytes:
    """Pass some messages, at least one, through a change. Messages with wall time stay."""
    data = [i for i, message in enumerate(base.log.messages) if message.topic != "/clock"]
    at = random.choice(data)

    def changed(number: int, message: Logged) -> list[Logged]:
        chosen = number == at or (message.topic != "/clock" and random.random() < share)
        return change(message) if chosen else [message]

    return rewritten(base.log, changed)


def drop_messages(base: Base, random: Random) -> bytes:
    return with_changed_messages(base, random, lambda _: [], random.choice((0, 0.5, 1)))


def double_messages(base: Base, random: Random) -> bytes:
    return with_changed_messages(base, random, lambda message: [message, message], 0.1)


def shuffle_messages(base: Base, random: Random) -> bytes:
    messages = list(base.log.messages)
    random.shuffle(messages)
    return rewritten(replace(base.log, messages=messages))


def drop_topic(base: Base, random: Random) -> bytes:
    gone = random.choice([channel.topic for channel in base.log.channels.values()])
    kept = [message for message in base.log.messages if message.topic != gone]
    return rewritten(replace(base.log, messages=kept))


def other_payload(base: Base, random: Random) -> bytes:
    def change(message: Logged) -> list[Logged]:
        data = bytearray(message.data)
        data[random.randrange(len(data))] ^= random.randrange(1, 256)
        return [message._replace(data=bytes(data))]

    return with_changed_messages(base, random, change, random.choice((0, 0, 0.2)))


def cut_payload(base: Base, random: Random) -> bytes:
    def change(message: Logged) -> list[Logged]:
        size = random.randrange(len(message.data))
        return [message._replace(data=message.data[:size])]

    return with_changed_messages(base, random, change, random.choice((0, 0, 0.2)))


def other_number_in_payload(base: Base, random: Random) -> bytes:
    """Replace eight bytes by a number that no run has: NaN, infinity, very large or small."""

    def change(message: Logged) -> list[Logged]:
        number = random.choice((float("nan"), float("inf"), -1e300, 1e8, 0.0, -1.0, 5e-324, 1e-300))
        size = len(message.data)
        at = size - 8 * random.randrange(1, max(2, size // 8))
        data = (message.data[:at] + struct.pack("<d", number) + message.data[at + 8 :])[:size]
        return [message._replace(data=data if data != message.data else b"")]

    return with_changed_messages(base, random, change, random.choice((0, 0, 0.2)))


CONTENTS: Final = {
    "metadata": Mutation(other_metadata),
    "metadata, sealed": Mutation(other_metadata_sealed, must_report=False),
    "effective.json": Mutation(other_scenario, must_report=False),
    "message dropped": Mutation(drop_messages),
    "message doubled": Mutation(double_messages),
    "messages without order": Mutation(shuffle_messages),
    "topic gone": Mutation(drop_topic, must_report=False),  # that of wall time is in no fingerprint
    "payload": Mutation(other_payload),
    "payload cut": Mutation(cut_payload),
    "other number in a payload": Mutation(other_number_in_payload),
}
