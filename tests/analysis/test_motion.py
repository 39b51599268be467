"""A `Motion` agrees with a step function of single times, integrated by brute force."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from zenvoy.vehicles.motion import Motion

UNIT_NS = 10_000_000  # every time in these tests is a multiple of 10 ms
UNIT_S = 0.01
FOREVER = 10**15


class Lesson(NamedTuple):
    """Arguments of `learn`, in units of time."""

    start: int
    end: int
    reading: float
    plan_from: tuple[int, ...]
    plan: tuple[float, ...]


def taught(lessons: Sequence[Lesson], keep_ns: int = FOREVER) -> Motion:
    motion = Motion(keep_ns)
    for start, end, reading, plan_from, plan in lessons:
        from_ns = [t * UNIT_NS for t in plan_from]
        motion.learn(start * UNIT_NS, end * UNIT_NS, reading, from_ns, plan)
    return motion


def value_at(lessons: Sequence[Lesson], t: int) -> float:
    """Return the acceleration at `t` by definition: that of the newest lesson that covers `t`."""
    if not lessons:
        return 0.0
    begun = [lesson for lesson in lessons if lesson.start <= t]
    if not begun:  # before all lessons: as at the start of the first
        first = min(lesson.start for lesson in lessons)
        return value_at(lessons, first)
    newest = begun[-1]
    value = newest.reading
    for planned_from, planned in zip(newest.plan_from, newest.plan, strict=True):
        if max(planned_from, newest.end) <= t:
            value = planned
    return value


def brute(lessons: Sequence[Lesson], t0: int, t1: int) -> tuple[float, float]:
    dp = dv = 0.0
    for t in range(t0, t1):
        a = value_at(lessons, t)
        dp += dv * UNIT_S + 0.5 * a * UNIT_S**2
        dv += a * UNIT_S
    return dp, dv


accelerations = st.floats(-5.0, 5.0)


@st.composite
def lesson_lists(draw: st.DrawFn) -> list[Lesson]:
    """Draw readings in order of time, with gaps and overlaps, and plans from before or after."""
    lessons, start = [], draw(st.integers(-20, 20))
    for _ in range(draw(st.integers(0, 6))):
        start += draw(st.integers(0, 15))
        end = start + draw(st.integers(1, 10))
        plan = draw(st.lists(st.tuples(st.integers(-5, 20), accelerations), max_size=4))
        plan.sort(key=lambda entry: entry[0])
        lessons.append(
            Lesson(
                start,
                end,
                draw(accelerations),
                tuple(end + offset for offset, _ in plan),
                tuple(a for _, a in plan),
            )
        )
    return lessons


spans = st.tuples(st.integers(-40, 120), st.integers(0, 80)).map(lambda s: (s[0], s[0] + s[1]))


@settings(deadline=None, max_examples=150)
@given(lesson_lists(), spans)
def test_a_motion_integrates_what_it_learns(lessons: list[Lesson], span: tuple[int, int]) -> None:
    t0, t1 = span
    motion = taught(lessons)
    dp, dv = brute(lessons, t0, t1)
    assert motion.over(t0 * UNIT_NS, t1 * UNIT_NS) == pytest.approx((dp, dv), abs=1e-9)
    if t1 > t0:
        mean = motion.mean(t0 * UNIT_NS, t1 * UNIT_NS)
        assert mean == pytest.approx(dv / ((t1 - t0) * UNIT_S), abs=1e-9)


@settings(deadline=None, max_examples=100)
@given(lesson_lists(), st.integers(-40, 120))
def test_steps_from_a_time_have_all_later_values(lessons: list[Lesson], t: int) -> None:
    times, values = taught(lessons).steps_from(t * UNIT_NS)
    assert times[0] == t * UNIT_NS
    assert times == sorted(times)
    assert len(times) == len(values)
    last = max([t, *(moment for lesson in lessons for moment in (lesson.end, *lesson.plan_from))])
    for moment in range(t, last + 3):
        in_force = [a for at, a in zip(times, values, strict=True) if at <= moment * UNIT_NS][-1]
        assert in_force == value_at(lessons, moment)


@settings(deadline=None, max_examples=100)
@given(lesson_lists().filter(bool), st.integers(0, 30), spans)
def test_a_motion_forgets_only_what_is_older_than_it_keeps(
    lessons: list[Lesson], keep: int, span: tuple[int, int]
) -> None:
    oldest = max(lesson.end for lesson in lessons) - keep
    t0, t1 = (max(t, oldest) * UNIT_NS for t in span)
    pruned, whole = taught(lessons, keep * UNIT_NS), taught(lessons)
    assert pruned.over(t0, t1) == whole.over(t0, t1)
    assert pruned.steps_from(t0) == whole.steps_from(t0)


def test_a_motion_does_not_grow() -> None:
    motion = Motion(keep_ns=50 * UNIT_NS)
    for k in range(10_000):
        motion.learn(10 * k * UNIT_NS, 10 * (k + 1) * UNIT_NS, float(k % 3), (), ())
    times, _ = motion.steps_from(0)
    assert len(times) <= 8
    assert motion.mean(99_960 * UNIT_NS, 99_970 * UNIT_NS) == 9_996 % 3


def test_the_mean_over_a_reading_is_the_reading() -> None:
    motion = Motion(FOREVER)
    motion.learn(0, 100, 0.1, (50,), (3.0,))
    assert motion.mean(0, 100) == 0.1


def test_a_plan_bridges_a_gap_until_a_later_lesson_replaces_it() -> None:
    s = 1_000_000_000
    motion = Motion(FOREVER)
    motion.learn(0, s, 1.0, (s, 3 * s), (2.0, -1.0))
    assert motion.mean(s, 2 * s) == pytest.approx(2.0)
    motion.learn(2 * s, 3 * s, 0.5, (), ())
    assert motion.mean(s, 2 * s) == pytest.approx(2.0)  # no reading covers it: as planned
    assert motion.mean(3 * s, 9 * s) == pytest.approx(0.5)  # the plan is gone


def test_a_motion_is_empty_at_first_and_after_forget() -> None:
    motion = Motion(FOREVER)
    for a in (2.0, -4.0):
        assert motion.over(0, 10**9) == (0.0, 0.0)
        assert motion.mean(0, 10**9) == 0.0
        assert motion.steps_from(7) == ([7], [0.0])
        motion.learn(0, 10**9, a, (), ())
        assert motion.over(0, 10**9) == pytest.approx((a / 2.0, a))
        assert motion.steps_from(0) == ([0], [a])
        motion.forget()
