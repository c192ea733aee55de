"""Roll, pitch and yaw as URDF has them: Rz(yaw) Ry(pitch) Rx(roll)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def rotation(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """(3, 3) axes of roll, pitch, yaw (3,), rad."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def roll_pitch_yaw(turn: np.ndarray) -> np.ndarray:
    """(3,) angles of a rotation (3, 3), rad.

    Together they are exact also where x looks nearly along z and neither roll nor yaw alone is determined:
    the roll is what is left of the rotation without the yaw, whatever that is.
    """
    level = np.hypot(turn[0, 0], turn[1, 0])
    yaw = np.arctan2(turn[1, 0], turn[0, 0]) if level > 1e-14 else 0.0
    pitch = np.arctan2(-turn[2, 0], level)
    c, s = np.cos(yaw), np.sin(yaw)
    roll = np.arctan2(s * turn[0, 2] - c * turn[1, 2], c * turn[1, 1] - s * turn[0, 1])
    return np.array([roll, pitch, yaw])
