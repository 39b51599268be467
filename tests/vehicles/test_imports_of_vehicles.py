"""A vehicle's process imports nothing that only reports or the channel need."""

from __future__ import annotations

import subprocess
import sys
from typing import Final

HEAVY: Final = ("matplotlib", "pandas", "pyarrow", "jinja2")

WITH_STUB: Final = """
import sys, types
class Filter: pass
stub = types.ModuleType("filterpy.kalman")
stub.KalmanFilter = stub.ExtendedKalmanFilter = stub.UnscentedKalmanFilter = Filter
stub.MerweScaledSigmaPoints = Filter
sys.modules |= {"filterpy": types.ModuleType("filterpy"), "filterpy.kalman": stub}
"""


def imported(code: str) -> set[str]:
    ran = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules, sep='\\n')"],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    return {name.partition(".")[0] for name in ran.stdout.split()}


def test_a_fleet_draws_no_picture() -> None:
    assert imported("import zenvoy.fleet.run, zenvoy.vehicles.process").isdisjoint(HEAVY)


def test_only_filterpy_imports_scipys_functions() -> None:
    """filterpy imports them, and the vehicle's own code does not."""
    code = f"{WITH_STUB}\nimport zenvoy.vehicles.process"
    found = imported(f"{code}\nassert 'scipy.special' not in sys.modules")
    assert "zenvoy" in found
    assert found.isdisjoint(HEAVY)


def test_scenarios_and_the_channel_import_scipys_functions_late() -> None:
    imported("import sys, zenvoy.channel.process; assert 'scipy.special' not in sys.modules")


def test_filters_come_without_filterpys_statistics_until_somebody_uses_them() -> None:
    """scipy.stats takes as long to import as the filters. All of filterpy is there all the same."""
    imported(
        """
import sys
from zenvoy.vehicles.filterpy_kalman import KalmanFilter
assert "filterpy.stats" not in sys.modules and "scipy.stats" not in sys.modules
import filterpy, numpy
kalman = KalmanFilter(dim_x=1, dim_z=1)
kalman.predict()
kalman.update(numpy.array([3.0]))
likelihood = kalman.log_likelihood
import scipy.stats
assert filterpy.stats.gaussian is sys.modules["filterpy.stats"].gaussian
assert likelihood == scipy.stats.norm(0.0, kalman.S[0, 0] ** 0.5).logpdf(3.0), likelihood
from filterpy.stats import multivariate_gaussian
"""
    )
