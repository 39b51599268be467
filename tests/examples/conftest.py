"""The examples are no part of the installed package: users run them from the root."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2]))
