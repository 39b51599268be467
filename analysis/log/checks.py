"""Checks what a log says about itself against what is in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from mcap.opcode import Opcode

from zenvoy.analysis.log.cycles import Cycles, Stretch, named, union
from zenvoy.analysis.log.records import Pass
from zenvoy.bus.log_format import EFFECTIVE
from zenvoy.bus.log_metadata import CHECKSUM, REPAIR, RESULT, RUN, checksum
from zenvoy.bus.topics import TRUTH
from zenvoy.scenarios import Scenario


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """The result of one check; `holds` is None where the log has nothing to check against."""

    name: str
    holds: bool | None
    says: str
    """A sentence without its full stop."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Content:
    """What one pass over a log found, besides its records."""

    cycles: Mapping[str, Cycles]
    """By topic; only topics with one message per cycle."""
    fingerprint: str
    metadata_faults: tuple[str, ...]
    """What had to be corrected in zenvoy.run and zenvoy.result before they could be used."""


def checks_of(log: Pass, scenario: Scenario, content: Content) -> tuple[Check, ...]:
    """Return all checks, in the order of the file."""
    return (
        Check(name="end", holds=log.whole, says="the file " + ("ends" if log.whole else "is cut")),
        *(Check(name="records", holds=False, says=fault) for fault in log.faults),
        _crc("data section", log.data_crc),
        _crc("summary", log.summary_crc),
        *_metadata(log, content.metadata_faults),
        *_effective(log, scenario),
        _statistics(log),
        *_cycles(content.cycles),
        *_result(log, content),
    )


def _crc(name: str, holds: bool | None) -> Check:
    says = "has no CRC" if holds is None else f"{'matches' if holds else 'does not match'} its CRC"
    return Check(name=f"CRC of the {name}", holds=holds, says=f"the {name} {says}")


def _metadata(log: Pass, faults: tuple[str, ...]) -> Iterator[Check]:
    for name in (RUN, RESULT, REPAIR):
        facts = log.metadata.get(name)
        if facts is None:
            continue
        stored = facts.get(CHECKSUM)
        holds = None if stored is None else stored == checksum(facts)
        says = "has no checksum" if holds is None else "matches its checksum"
        says = says if holds is not False else "does not match its checksum"
        yield Check(name=name, holds=holds, says=f"metadata {name} {says}")
    for fault in faults:
        yield Check(name="metadata", holds=False, says=fault)


def _effective(log: Pass, scenario: Scenario) -> Iterator[Check]:
    """Check that zenvoy.run and effective.json describe the same run."""
    expected = {
        "seed": scenario.seed,
        "cycles": scenario.cycles,
        "period_ns": scenario.period_ns,
        "vehicles": scenario.fleet.size,
    }
    run = log.metadata[RUN]
    wrong = [
        f"metadata {RUN} has {key} {run[key]}, {EFFECTIVE} {value}"
        for key, value in expected.items()
        if key in run and run[key] != str(value)
    ]
    for fault in wrong:
        yield Check(name="scenario", holds=False, says=fault)
    if not wrong:
        yield Check(name="scenario", holds=True, says=f"metadata {RUN} agrees with {EFFECTIVE}")


def _statistics(log: Pass) -> Check:
    statistics, name = log.statistics, "statistics"
    if statistics is None:
        return Check(name=name, holds=None, says="the file has no statistics")
    pairs = [
        ("chunks", statistics.chunk_count, log.found[Opcode.CHUNK]),
        ("attachments", statistics.attachment_count, log.found[Opcode.ATTACHMENT]),
        ("metadata records", statistics.metadata_count, log.found[Opcode.METADATA]),
        ("messages", statistics.message_count, log.counts.total()),
    ]
    topics, by_channel = log.topics, statistics.channel_message_counts
    for channel in sorted(by_channel.keys() | log.counts.keys()):
        of = f"messages of {topics.get(channel, f'channel {channel}')}"
        pairs.append((of, by_channel.get(channel, 0), log.counts[channel]))
    for what, expected, found in pairs:
        if expected != found:
            says = f"{what}: {found} in the file, but its statistics say {expected}"
            return Check(name=name, holds=False, says=says)
    says = f"the file has {statistics.message_count} messages, as its statistics say"
    return Check(name=name, holds=True, says=says)


def _cycles(by_topic: Mapping[str, Cycles]) -> Iterator[Check]:
    faults = [
        _stretches_fault(
            {topic: cycles.missing() for topic, cycles in by_topic.items()}, "missing"
        ),
        _stretches_fault(
            {topic: cycles.twice() for topic, cycles in by_topic.items()}, "there more than once"
        ),
    ]
    beyond = max(cycles.beyond for cycles in by_topic.values())
    if beyond:
        faults.append(f"cycle {beyond} is after the end of the run")
    if not all(cycles.ordered or cycles.twice() for cycles in by_topic.values()):
        faults.append("the cycles are not in order")
    for fault in filter(None, faults):
        yield Check(name="cycles", holds=False, says=fault)
    if not any(faults):
        says = "no topic has a missing, repeated or misplaced cycle"
        yield Check(name="cycles", holds=True, says=says)


def _stretches_fault(by_topic: Mapping[str, list[Stretch]], what: str) -> str:
    """Return a sentence on the cycles that are `what` in some topic; "" where there is none."""
    found = union(by_topic.values())
    if not found:
        return ""
    topics = [topic for topic, stretches in by_topic.items() if stretches]
    where = "" if len(topics) == len(by_topic) else f" in {', '.join(topics)}"
    one = len(found) == 1 and found[0][0] == found[0][1]
    return f"{named(found)} {'is' if one else 'are'} {what}{where}"


def _result(log: Pass, content: Content) -> Iterator[Check]:
    """Check that zenvoy.result describes these messages."""
    result = log.metadata.get(RESULT)
    if result is None:
        yield Check(name="fingerprint", holds=None, says="the log has no fingerprint")
        return
    # Old logs, which have no checksum here, wrote this before the last messages.
    if not log.whole and CHECKSUM not in result:
        yield Check(name="fingerprint", holds=None, says="the log is cut before its fingerprint")
        return
    last = content.cycles[TRUTH.log_name].last
    if result.get("cycles", "").isdecimal() and int(result["cycles"]) != last:
        says = f"metadata {RESULT} says {result['cycles']} cycles, {TRUTH.log_name} has {last}"
        yield Check(name="cycles", holds=False, says=says)
    logged = result.get("fingerprint")
    if logged is None:
        yield Check(name="fingerprint", holds=None, says=f"metadata {RESULT} has no fingerprint")
        return
    holds = logged == content.fingerprint
    says = f"the fingerprint {'matches' if holds else 'does not match'} the messages"
    yield Check(name="fingerprint", holds=holds, says=says)
