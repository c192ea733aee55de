"""Scenes of robots as they are written: each part with its keys, their ranges and their defaults."""

from .effects import HELD_BY_FRAMES, Effects
from .fault import Fault
from .link import Beam, DenavitHartenberg, Frame, Joint, Link, Mesh, Payload, Reduction
from .loop import BASE, ClosingJoint
from .part import Misplaced
from .scene import Erls, Scene, Undecided
from .sensor import Sensor
from .torque import Torque

__all__ = [
    "BASE",
    "HELD_BY_FRAMES",
    "Beam",
    "ClosingJoint",
    "DenavitHartenberg",
    "Effects",
    "Erls",
    "Fault",
    "Frame",
    "Joint",
    "Link",
    "Mesh",
    "Misplaced",
    "Payload",
    "Reduction",
    "Scene",
    "Sensor",
    "Torque",
    "Undecided",
]
