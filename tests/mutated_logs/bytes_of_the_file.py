"""Mutations change arbitrary bytes of a log."""

from __future__ import annotations

from random import Random
from typing import Final

from tests.mutated_logs.bases import Base, Mutation


def place(content: bytes, random: Random) -> int:
    return random.randrange(len(content))


def flip_bit(base: Base, random: Random) -> bytes:
    at = place(base.content, random)
    changed = base.content[at] ^ 1 << random.randrange(8)
    return base.content[:at] + bytes([changed]) + base.content[at + 1 :]


def overwrite_bytes(base: Base, random: Random) -> bytes:
    at, size = place(base.content, random), random.choice((1, 2, 8, 100))
    noise = random.randbytes(size)
    return (base.content[:at] + noise + base.content[at + size :])[: len(base.content)]


def cut_off(base: Base, random: Random) -> bytes:
    return base.content[: place(base.content, random)]


def remove_bytes(base: Base, random: Random) -> bytes:
    at, size = place(base.content, random), random.choice((1, 8, 1_000))
    return base.content[:at] + base.content[at + size :]


def insert_bytes(base: Base, random: Random) -> bytes:
    at = random.choice((place(base.content, random), len(base.content)))
    return base.content[:at] + random.randbytes(9) + base.content[at:]


def zero_bytes(base: Base, random: Random) -> bytes:
    at, size = place(base.content, random), random.choice((4, 100, 4_000))
    return (base.content[:at] + bytes(size) + base.content[at + size :])[: len(base.content)]


BYTES: Final = {
    "flipped bit": Mutation(flip_bit),
    "other bytes": Mutation(overwrite_bytes),
    "cut": Mutation(cut_off),
    "bytes gone": Mutation(remove_bytes),
    "bytes more": Mutation(insert_bytes),
    "zeros": Mutation(zero_bytes),
}
