"""Loses more and more frames, and prints how the smallest gap changes: a study in ten lines.

python examples/from_python.py
"""

import zenvoy

print("frames lost, %   smallest gap, m   fallbacks to FM")
for percent in (0, 50, 90):
    scenario = zenvoy.scenario(
        "quickstart",
        duration_s=20,
        fleet={"size": 8},
        channel={"loss": {"p": percent / 100}},
    )
    run = zenvoy.run(scenario, engine="in-process", out=f"runs/lost-{percent}")
    print(f"{percent:15}{run.summary['smallest_gap_m']:18.2f}{run.summary['fallbacks']:18}")
