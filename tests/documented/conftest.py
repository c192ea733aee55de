"""The ways to run processes and robots are those of the other tests."""

import sys
from pathlib import Path

for folder in ("scripts", "ros"):
    sys.path.insert(0, str(Path(__file__).parents[1] / folder))
