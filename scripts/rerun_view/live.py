"""Shows a running robot as it moves."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from ..bag import qos  # noqa: F401
from ..bag.cdr import Decoder
from ..bag.definitions import definition
from ..ros.context import tool_node
from ..ros.raw_topic import RawTopic
from . import robot
from .bag import JOINTS, LAYOUT, STATE, skeleton_of
from .joints import QUANTITIES, JointPlots

if TYPE_CHECKING:
    from rclpy.node import Node

NODE = "flexsim_node"
TOPICS = {
    "/joint_states": JOINTS,
    f"/{NODE}/elastic_state": STATE,
    f"/{NODE}/elastic_layout": LAYOUT,
}
START_TIMEOUT = 60.0
POLL_PERIOD = 1.0 / 30.0
