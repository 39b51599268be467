"""Published tables of speeds are read as they are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests import recordings as forms
from zenvoy.scenarios.reading.columns import Choice, RecordingError
from zenvoy.scenarios.reading.recordings import Recording, recording
from zenvoy.scenarios.schema.units import SPEEDS, split_header

MPH, KNOT = 0.44704, 1852 / 3600


@pytest.mark.parametrize(
    ("text", "choice", "points"),
    [
        (
            forms.OPENACC,
            Choice(column="Speed1", unit="m/s"),
            [(780.0, 8.25), (780.1, 8.5), (780.2, 8.625), (780.3, 8.75)],
        ),
        (
            forms.OPENACC,
            Choice(column="Speed1", unit="m/s", time="from-first"),
            [(0.0, 8.25), (0.1, 8.5), (0.2, 8.625), (0.3, 8.75)],
        ),
        (
            forms.OPENACC,
            Choice(column="Speed2", unit="m/s", time="from-first"),
            [(0.0, 8.0), (0.2, 0.0)],  # from its own first point
        ),
        (
            forms.FCD,
            Choice(unit="m/s", where={"vehicle_id": "f.0"}),
            [(0.1, 27.5), (0.2, 27.25)],
        ),
        (
            forms.PLEXE,
            Choice(unit="m/s", where={"nodeId": "1"}),
            [(0.1, 27.5), (0.2, 27.625)],
        ),
        (forms.EPA, Choice(), [(0.0, 0.0), (1.0, 3 * MPH), (2.0, 5.9 * MPH)]),
        (forms.EPA, Choice(column="Target Speed"), [(0.0, 0.0), (1.0, 3 * MPH), (2.0, 5.9 * MPH)]),
        (forms.SPREADSHEET, Choice(), [(0.0, 10.0), (0.5, 11.0), (1.0, 12.0)]),
        (forms.LOGGER, Choice(), [(0.0, 10 * KNOT), (1.25, 20 * KNOT)]),
        (forms.SAVETXT, Choice(time="from-first"), [(0.0, 3.0), (0.1, 3.5)]),
        ("cycSecs,cycMps,cycGrade\n0,0,0\n1,1.5,0\n", Choice(), [(0.0, 0.0), (1.0, 1.5)]),
        ("t;v [kph]\n0;36\n2;18\n", Choice(), [(0.0, 10.0), (2.0, 5.0)]),
        ("seconds,mph\n0,10\n1,20\n", Choice(), [(0.0, 10 * MPH), (1.0, 20 * MPH)]),
        # The scenario takes precedence over the file.
        ("time_s,speed_kmh\n0,10\n1,20\n", Choice(unit="knots"), [(0, 10 * KNOT), (1, 20 * KNOT)]),
    ],
)
def test_published_forms_are_read_as_they_are(
    text: str, choice: Choice, points: list[tuple[float, float]]
) -> None:
    read = recording(text, choice)
    assert np.array(read.points) == pytest.approx(np.array(points), abs=1e-9)
    again = recording("\ufeff" + text.replace("\n", "\r\n"), choice)
    assert again.points == read.points


def test_skipped_rows_are_counted() -> None:
    read = recording(forms.OPENACC, Choice(column="Speed2", unit="m/s"))
    assert (read.missing, read.raised, read.others) == (2, 1, 0)
    assert read.longest_gap_s == pytest.approx(0.2)  # a row without a speed is between the two
    assert (read.grid.header_line, read.grid.delimiter) == (6, ",")
    read = recording(forms.FCD, Choice(unit="m/s", where={"vehicle_id": "f.1"}))
    assert (read.missing, read.raised, read.others, read.longest_gap_s) == (0, 0, 3, 0.0)
    read = recording(forms.LOGGER, Choice())
    assert (read.time_unit, read.unit, read.from_first) == ("date", "knots", True)
    assert read.lines == (3, 5)


@pytest.mark.parametrize(
    ("text", "choice", "problems"),
    [
        (
            forms.OPENACC,
            Choice(),
            [
                (
                    6,
                    "column",
                    "not given, and no column is called a speed; allowed: one of Speed1, Speed2",
                )
            ],
        ),
        (
            forms.OPENACC,
            Choice(column="speed3", time_column="Lon1"),
            [(6, "column", "'speed3' is not a column; allowed: one of Speed1, Speed2")],
        ),
        (
            forms.OPENACC,
            Choice(column="Speed1"),
            [
                (
                    6,
                    "unit",
                    "not given, and 'Speed1' names no unit; allowed: one of m/s, km/h, mph, knots",
                )
            ],
        ),
        (
            "time,speed_mps,velocity_kmh\n0,1,2\n",
            Choice(),
            [
                (
                    1,
                    "column",
                    "not given, and 2 columns are called a speed; allowed: one of speed_mps",
                )
            ],
        ),
        (
            "time,x,x\n0,1,2\n",
            Choice(column="x"),
            [(1, "column", "'x' is the name of 2 columns; allowed: one of time, x, x")],
        ),
        (
            forms.FCD,
            Choice(unit="m/s", where={"vehicle": "f.0"}),
            [
                (
                    1,
                    "where",
                    "'vehicle' is not a column; allowed: one of timestep_time, vehicle_id, "
                    "vehicle_x, vehicle_y, vehicle_angle, vehicle_type, vehicle_speed, vehicle_pos",
                )
            ],
        ),
        (
            forms.FCD,
            Choice(unit="m/s", where={"vehicle_id": "f.7"}),
            [(1, "where", "no row has these values")],
        ),
        (
            "time_s;speed_mps\n0;1,5\n1;1.5\n",
            Choice(),
            [(3, "", "speed_mps: '1.5' has '.' where others have ','")],
        ),
        (
            'time_s,speed_mps\n0,"1,5"\n1,"1,000.5"\n',
            Choice(),
            [
                (2, "", "speed_mps: '1,5' is not a number"),
                (3, "", "speed_mps: '1,000.5' is not a number"),
            ],
        ),
        (
            forms.LOGGER,
            Choice(time="as-given"),
            [(3, "time", "as-given, but the times are dates; allowed: from-first")],
        ),
        (
            "time,speed_mps\n2024-03-12T10:00:00Z,1\n2024-03-12T10:00:01,2\n5,3\n",
            Choice(),
            [
                (3, "", "'2024-03-12 10:00:01' and the first time are not dates of one kind"),
                (4, "", "'5' and the first time are not dates of one kind"),
            ],
        ),
        (
            "v,speed_mps\n0,1\n",
            Choice(column="v", time_column="v", unit="m/s"),
            [(1, "column", "'v' is also the column of times")],
        ),
        (
            "root:secret,of:somebody\nnext,line\n",  # the text of other files is not shown
            Choice(),
            [(None, "", "no line names a time and a speed, as the header time_s,speed_mps does")],
        ),
        ("time,speed_mps\n", Choice(), [(1, "", "there is no row below the header")]),
    ],
)
def test_unreadable_rows_are_reported_with_their_line(
    text: str, choice: Choice, problems: list[tuple[int | None, str, str]]
) -> None:
    with pytest.raises(RecordingError) as caught:
        recording(text, choice)
    assert list(caught.value.problems) == problems


@pytest.mark.parametrize(
    ("cell", "name", "unit"),
    [
        ("speed_mps", "speed", "m/s"),
        ("Speed [km/h]", "speed", "km/h"),
        ("Speed (KPH)", "speed", "km/h"),
        ("v, knots", "v", "knots"),
        ("cycMps", "cyc", "m/s"),
        ("vehicle_speed", "vehicle_speed", None),
        ("Speed1", "speed1", None),
        ("speed (gps)", "speed (gps)", None),
        ("speed_m_s", "speed", "m/s"),
        ("km/h", "", "km/h"),
        ("ramps", "ramps", None),
    ],
)
def test_units_are_read_from_headers(cell: str, name: str, unit: str | None) -> None:
    assert split_header(cell, SPEEDS) == (name, unit)


tables = st.lists(
    st.lists(
        st.sampled_from(["time", "speed_mps", "0", "1,5", "2.5", "nan", "", "x", '"', "-1"]),
        min_size=1,
        max_size=4,
    ),
    max_size=8,
)


@given(tables, st.sampled_from([",", ";", "\t"]), st.sampled_from([None, "from-first", "as-given"]))
def test_any_table_is_read_or_refused(
    rows: list[list[str]], delimiter: str, time: str | None
) -> None:
    text = "\n".join(delimiter.join(row) for row in rows)
    try:
        read = recording(text, Choice(time=time))
    except RecordingError:
        return
    assert isinstance(read, Recording)
    assert len(read.points) == len(read.lines)
    assert all(speed >= 0.0 or speed < -0.5 for _, speed in read.points)
