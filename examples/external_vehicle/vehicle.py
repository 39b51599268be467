"""A vehicle without Zenvoy: it follows by its own radar (FM), in real time. README.md says more."""

import json
import sys
import time
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue

import messages_pb2 as pb
import zenoh

LINK = ("gap", "speed", "gap_std", "speed_std", "predicted_gap", "predicted_speed")
NOTHING = pb.LinkEstimate(**dict.fromkeys(LINK, float("nan")), measured_ns=-1)
SPEEDS = dict.fromkeys(("speed", "speed_std", "predicted_speed"), float("nan"))
UNKNOWN = {"ahead": NOTHING, "behind": NOTHING, "age_ns": -1, **SPEEDS}  # it estimates nothing
READS, GONE = {"sense": pb.Sense, "receive": pb.Receive}, "the world is gone"


def follow(sense, control):
    """Return mode and acceleration (m/s²) by FM, from the gap ahead, its rate and the own speed."""
    if not sense.HasField("ahead"):
        return {"mode": pb.MODE_CONSTANT_SPEED}
    gains, limit = control["gains"], control["acceleration_limit_mps2"]
    a = gains["k_d"] * (sense.ahead.gap - control["desired_gap_m"])
    a += gains["k_v"] * sense.ahead.speed
    a += gains["k_c"] * (control["desired_speed_mps"] - sense.speed)
    return {"mode": pb.MODE_FM, "acceleration": max(-limit, min(limit, a))}


def drive(came, beacons, commands, scenario):
    """Send a beacon on each sense and a command at t_k + v2v_wait, until the world is gone."""
    control, speed, period_ns = scenario["control"], scenario["speed"], scenario["period_ms"] * 1e6
    wait_ns, delay_ns = (round(control[key] * 1e6) for key in ("v2v_wait_ms", "system_delay_ms"))
    due_ns, sense, message, start_ns, timing = None, None, None, 0, pb.Timing()
    while message != GONE:
        try:
            left_s = None if due_ns is None else max(0, due_ns - time.monotonic_ns()) * 1e-9
            came_ns, message = came.get(timeout=left_s)
        except Empty:
            came_ns, message = time.monotonic_ns(), None
        if due_ns is not None and came_ns >= due_ns:  # all earlier messages are read
            at_ns, due_ns = sense.time_ns + wait_ns, None
            timing.decided_ns = round((time.monotonic_ns() - start_ns) * speed)
            if timing.decided_ns - at_ns < period_ns:  # else this process was stopped
                own = {"cycle": sense.cycle, "vehicle": sense.vehicle, "time_ns": at_ns, **UNKNOWN}
                own |= {"effective_ns": at_ns + delay_ns, "timing": timing}
                commands.put(pb.Command(**own, **follow(sense, control)).SerializeToString())
            timing = pb.Timing()
        if isinstance(message, pb.Receive) and sense is not None:  # FM does not use them
            timing.source.extend(message.source)
            timing.arrived_ns.extend(message.arrived_ns)
            timing.came_ns.extend([round((came_ns - start_ns) * speed)] * len(message.source))
        if isinstance(message, pb.Sense):
            sense, start_ns = message, message.wall_start_ns
            timing.sensed_ns = round((came_ns - start_ns) * speed)
            if timing.sensed_ns - sense.time_ns < period_ns:  # else newer senses are waiting
                due_ns = start_ns + round((sense.time_ns + wait_ns) / speed)
                own = {of.name: x for of, x in sense.ListFields() if of.name != "wall_start_ns"}
                plan = pb.Beacon(planned_acceleration=[sense.acceleration], sequence=sense.cycle)
                plan.planned_from_ns.append(sense.time_ns)
                beacons.put(pb.Beacon(**own).SerializeToString() + plan.SerializeToString())


def matched(asker):
    """Return a publisher or querier once it has a reader; earlier messages would be lost."""
    with asker.declare_matching_listener(zenoh.handlers.FifoChannel(16)) as changes:
        while not asker.matching_status.matching:
            changes.recv()
        return asker


def main(vehicle, met):
    config, came, run = zenoh.Config(), SimpleQueue(), f"zenvoy/{met['run']}"
    config.insert_json5("connect/endpoints", json.dumps([met["world"][0], met["channel"][0]]))
    config.insert_json5("listen/endpoints", "[]")
    config.insert_json5("scouting", "{multicast: {enabled: false}, gossip: {enabled: false}}")

    def hear(kind, sample):
        came.put((time.monotonic_ns(), kind.FromString(sample.payload.to_bytes())))

    def note(sample):
        if sample.kind == zenoh.SampleKind.DELETE:
            came.put((time.monotonic_ns(), GONE))

    with zenoh.open(config) as session:
        querier = matched(session.declare_querier(f"{run}/scenario"))
        (told,) = querier.get()
        scenario, alive = json.loads(told.ok.payload.to_bytes()), session.liveliness()
        sub, own = session.declare_subscriber, f"{run}/vehicle/{vehicle}"
        kept = [sub(f"{own}/{key}", partial(hear, kind)) for key, kind in READS.items()]
        kept += [alive.declare_subscriber(f"{run}/alive/world", note, history=True)]
        writers = [matched(session.declare_publisher(f"{own}/{x}")) for x in ("beacon", "command")]
        width = max(2, len(str(scenario["fleet"]["size"])))
        kept += [alive.declare_token(f"{run}/alive/vehicle-{vehicle:0{width}}")]  # ready
        drive(came, *writers, scenario)


if __name__ == "__main__":
    main(int(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text()))
