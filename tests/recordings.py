"""Small tables have the forms in which others publish speeds. All figures are invented."""

from __future__ import annotations

from typing import Final

# OpenACC: five lines of metadata with commas at their ends, then 10 Hz of all cars side by side.
OPENACC: Final = """\
Date,8,10,2019
Vehicle_order,CAR_TARGET,CAR_B,
Number_of_vehicles,2
ACC,1
Distance_setting,S
Time,Speed1,E1,N1,Lon1,Lat1,Alt1,Speed2,E2,N2,Lon2,Lat2,Alt2,IVS1
780.0,8.25,-125.5,68.0,16.25,46.5,245.5,,,,,,,
780.1,8.5,-125.0,68.75,16.25,46.5,245.5,8.0,-133.0,52.25,16.25,46.5,245.5,13.5
780.2,8.625,-124.5,69.5,16.25,46.5,245.5,,,,,,,13.5
780.30000000000001,8.75,-124.0,70.25,16.25,46.5,245.5,-0.02,-132.5,53.0,16.25,46.5,245.5,13.5
"""

# SUMO's FCD output through its xml2csv.py: a row per time and vehicle, and one per empty time.
FCD: Final = """\
timestep_time;vehicle_id;vehicle_x;vehicle_y;vehicle_angle;vehicle_type;vehicle_speed;vehicle_pos
0.00;;;;;;;
0.10;f.0;5.10;-1.60;90.00;car;27.50;5.10
0.10;f.1;0.10;-1.60;90.00;car;26.00;0.10
0.20;f.0;7.85;-1.60;90.00;car;27.25;7.85
0.20;f.1;2.70;-1.60;90.00;car;26.00;2.70
"""

# Vectors of Plexe (OMNeT++), a row per time and node.
PLEXE: Final = """\
run,nodeId,time,controllerAcceleration,speed
0,0,0.1,0.5,27.75
0,1,0.1,0.25,27.5
0,0,0.2,0.5,27.875
0,1,0.2,0.25,27.625
"""

# The EPA's dynamometer schedules: a title, tabs, units behind a comma.
EPA: Final = """\
Some Dynamometer Driving Schedule
Test Time, secs\tTarget Speed, mph
0\t0.0
1\t3.0
2\t5.9
"""

# A spreadsheet with decimal commas, and with its units in a separate row.
SPREADSHEET: Final = """\
"Fahrt";"Versuch 3"
Datum;12.03.2024

Time;Speed;Note
[ms];[km/h];
0;36,0;"los; jetzt"
500;39,6;
1000;43,2;
"""

# A data logger's table: dates, knots, a comment between rows.
LOGGER: Final = """\
# logged by a GPS receiver
timestamp,speed_kn
2024-03-12T23:59:59.500Z,10
# fix lost
2024-03-13T00:00:00.750+00:00,20
"""

# numpy.savetxt with a header, whose clock counts from 1970.
SAVETXT: Final = """\
# time_s,speed_mps
1710288000.125,3.0
1710288000.225,3.5
"""
