"""What every test finds set, and which tests share a process."""

import os

import pytest
from domains import DOMAINS

# Tests that start ROS nodes stay on this host, and two test runs at a time do not hear each other.
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
os.environ.setdefault("ROS_DOMAIN_ID", str(next(DOMAINS)))

# Files that need the same kernels stay together: two processes that begin with them side by side would both
# compile them.
SAME_KERNELS = {
    "test_co_moving_loops": "co_moving",
    "test_co_moving_motion": "co_moving",
    "test_co_moving_sensors": "co_moving",
    "test_loops": "loops",
    "test_loops_at_rest": "loops",
    "test_springs_in_loops": "loops",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Keep each file's tests, and those of files with the same kernels, in one process of pytest-xdist."""
    for item in items:
        item.add_marker(pytest.mark.xdist_group(SAME_KERNELS.get(item.path.stem, item.path.stem)))
