"""An example controller: a process of its own, `python -m flexsim.controller SCENE`."""

from .joint_pd import JointPd, Move

__all__ = ["JointPd", "Move"]
