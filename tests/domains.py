"""ROS domains in which no two tests hear each other."""

from __future__ import annotations

import itertools
import os
import random
from collections.abc import Iterator

from flexsim.trial.processes import TRIALS, is_free


def domains() -> Iterator[int]:
    """Domains where nobody is: a share for each worker of pytest-xdist, and none of a trial's."""
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    share = list(range(1 + worker, TRIALS.start, workers))
    random.SystemRandom().shuffle(share)
    return (domain for domain in itertools.cycle(share) if is_free(domain))


DOMAINS = domains()
