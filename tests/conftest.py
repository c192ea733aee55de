"""What every test finds set."""

import os

from domains import DOMAINS

# Tests that start ROS nodes stay on this host, and two test runs at a time do not hear each other.
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
os.environ.setdefault("ROS_DOMAIN_ID", str(next(DOMAINS)))
