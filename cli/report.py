"""Prints summaries, technologies, metadata and checks as rich tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from rich.console import Console
from rich.table import Table

from zenvoy.analysis.log.checks import Check
from zenvoy.analysis.log.facts import Facts
from zenvoy.analysis.measures.metrics import meaningful_r2
from zenvoy.analysis.measures.spacing import Spacing
from zenvoy.bus.log_metadata import CHECKSUM
from zenvoy.scenarios import Technology

_LATENESS: Final = {
    "cycle": "cycles",
    "sense": "senses",
    "decision": "decisions",
    "command": "commands (below 0: in time)",
    "delivery": "deliveries (real - drawn)",
}
_UNKNOWN: Final = "–"


def print_summary(console: Console, summary: dict[str, Any], spacing: Spacing) -> None:
    """Print the summary of a run, one line per figure, with gaps as `spacing` shows them."""
    title = f"{summary['scenario']}, seed {summary['seed']}"
    table = Table(title=title, show_header=False)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in _lines(summary, spacing):
        table.add_row(name, value)
    console.print(table)


def _lines(summary: dict[str, Any], spacing: Spacing) -> list[tuple[str, str]]:
    missing = "not valid" if summary["end"] else "not logged"
    lines = [
        ("end", summary["end"] or "not logged"),
        ("fingerprint", summary["fingerprint"] or missing),
        (
            "cycles",
            f"{summary['cycles']}: {summary['simulated_s']:g} s simulated in "
            f"{summary['wall_s']:.1f} s, {summary['real_time_factor']:.1f} × real time",
        ),
    ]
    if "held_up" in summary:
        lines.append(("pace", summary["held_up"]))
    if "distance_m" in summary:
        lines += _distance_lines(summary, spacing)
    lines += [
        ("collisions", str(summary["collisions"])),
        ("fallbacks to FM", str(summary["fallbacks"])),
        ("frames", _frames(summary["frames"])),
    ]
    return lines + _real_time_lines(summary.get("real_time"))


def _real_time_lines(found: dict[str, Any] | None) -> list[tuple[str, str]]:
    """Return how well a run in real time kept to the clock; no lines for lock-step."""
    if found is None:
        return []
    lines = []
    for name, lateness in found["lateness_ms"].items():
        if lateness is not None:
            text = "p50 {p50:.2f}, p99 {p99:.2f}, max {max:.2f} ms".format(**lateness)
            lines.append((f"lateness, {_LATENESS[name]}", text))
    error, drift = found["clock_error_ms"], found["clock_drift_ppm"]
    if error is not None:
        text = "known to p50 ± {p50:.2f}, p99 ± {p99:.2f}, max ± {max:.2f} ms".format(**error)
        if drift is not None:
            text += f", drift {drift[0]:.0f} to {drift[1]:.0f} ppm"
        lines.append(("clocks of other machines", text))
    missed, due = found["frames_that_missed_their_decision"], found["frames_due"]
    return [
        *lines,
        ("commands", f"{found['commands_late']} late, {found['commands_missing']} missing"),
        ("frames that missed their decision", f"{missed} of {due}"),
        ("overruns, drift", f"{found['overruns']}, {found['drift_ms']:.2f} ms"),
    ]


def _distance_lines(summary: dict[str, Any], spacing: Spacing) -> list[tuple[str, str]]:
    lines = [("gaps", spacing.words)] if spacing.words else []
    lines.append(("smallest gap", f"{spacing.shown(float(summary['smallest_gap_m'])):.2f} m"))
    for span, distance in summary["distance_m"].items():
        if distance is not None:
            low_m, high_m = (spacing.shown(float(distance[key])) for key in ("min", "max"))
            text = f"{low_m:.2f} / {high_m:.2f} m"
            lines.append((f"MinDistance / MaxDistance, {span.replace('_', ' ')}", text))
    spread = summary["speed_spread_at_100_s_mps"]
    if spread is not None:
        lines.append(("spread of speed at 100 s", f"{spread:.3f} m/s"))
    for quantity, unit in (("speed", "m/s"), ("gap", "m")):
        for kind, value in (summary[quantity] or {}).items():
            if value is not None:
                lines.append((f"{kind} {quantity}", _fit(value, unit)))
    return lines


def _fit(fit: dict[str, float], unit: str) -> str:
    """Return RMSE and R², or why R² would mean nothing."""
    rmse, r2 = f"RMSE {fit['rmse']:.3f} {unit}", meaningful_r2(fit["r2"])
    if r2 is None:
        return f"{rmse}; no R²: the truth varies by {fit['spread']:.3f} {unit} only"
    return f"{rmse}, R² {r2:.3f}"


def _frames(frames: dict[str, Any]) -> str:
    text = f"{frames['sent']} sent, {frames['delivered']} delivered"
    text += f" ({frames['late']} late), {frames['lost']} lost"
    if frames["corrupted"]:
        text += f", {frames['corrupted']} damaged"
    if frames["collided"]:
        text += f", {frames['collided']} collided"
    if frames["second_copies"]:
        text += f", {frames['second_copies']} second copies"
    if frames["latency_mean_ms"] is not None:
        text += f"; latency {frames['latency_mean_ms']:.2f} ms mean, "
        text += f"{frames['latency_p95_ms']:.2f} ms 95th percentile"
    return text


def print_technologies(console: Console, technologies: Sequence[Technology], title: str) -> None:
    """Print a column per technology, as in Table I of the paper."""
    table = Table(title=title)
    table.add_column("")
    for technology in technologies:
        name = technology.title or technology.name
        table.add_column(f"{name}\n({technology.name})", overflow="fold")
    for label, values in _technology_rows(technologies):
        table.add_row(label, *values)
    console.print(table)


def _technology_rows(columns: Sequence[Technology]) -> list[tuple[str, list[str]]]:
    return [
        ("band", [_span(c.band_ghz, "GHz") for c in columns]),
        ("bandwidth", [c.bandwidth or _UNKNOWN for c in columns]),
        ("range", [_metres(c.range_m) for c in columns]),
        ("bit rate", [c.bit_rate or _UNKNOWN for c in columns]),
        ("bit rate used here", [f"{c.bit_rate_mbps:g} Mbit/s" for c in columns]),
        ("delay", [_span(c.delay_ms, "ms") for c in columns]),
        ("broadcast", [_yes(c.broadcast) for c in columns]),
        ("carrier sense", [_yes(c.csma) for c in columns]),
        ("V2V", [_yes(c.v2v) for c in columns]),
        ("MIMO", [_yes(c.mimo) for c in columns]),
    ]


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def _metres(value: float) -> str:
    return f"{value / 1000:g} km" if value >= 1000 else f"{value:g} m"


def _span(bounds: tuple[float, float] | None, unit: str) -> str:
    if bounds is None:
        return _UNKNOWN
    low, high = bounds
    return f"{low:g} {unit}" if low == high else f"{low:g} to {high:g} {unit}"


def print_facts(console: Console, facts: Facts) -> None:
    """Print the metadata of a log, its laws, its result and its topics."""
    sections = {"run": facts.run, "laws": facts.laws}
    sections |= {"repair": facts.repair, "result": facts.result}
    for title, records in sections.items():
        if not records:  # a cut log has no result
            continue
        table = Table(title=title, show_header=False)
        table.add_column(no_wrap=True)
        table.add_column(overflow="fold")
        for name, value in records.items():
            if name != CHECKSUM:
                table.add_row(name, value)
        console.print(table)
    table = Table(title="topics")
    table.add_column("topic")
    table.add_column("messages", justify="right")
    for topic, count in facts.counts.items():
        table.add_row(topic, str(count))
    console.print(table)


def print_checks(console: Console, checks: Sequence[Check]) -> None:
    """Print each check of a log, and whether the log passes it."""
    answers = {True: "passed", False: "FAILED", None: "not possible"}
    table = Table(title="checks")
    for column in ("check", "", "result"):
        table.add_column(column, overflow="fold")
    for check in checks:
        table.add_row(check.name, answers[check.holds], check.says)
    console.print(table)
