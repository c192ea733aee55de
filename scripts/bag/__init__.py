"""Bags: MCAP files in rosbag2's layout, written raw and read as NumPy arrays.

>>> from flexsim.bag import Bag
>>> t, position = Bag("run").array("/joint_states", "position")     # doctest: +SKIP
"""

from .errors import BagDamaged, BagError
from .reader import Bag, Topic
from .writer import BagWriter

__all__ = ["Bag", "BagDamaged", "BagError", "BagWriter", "Topic"]
