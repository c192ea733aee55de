"""Read a recorded bag as arrays: `python examples/read_a_bag.py run` after `flexsim record -o run`."""

import sys

import numpy as np
from flexsim.bag import Bag

bag = Bag(sys.argv[1] if len(sys.argv) > 1 else "run")
print(f"{bag.count} messages over {bag.duration:.2f} s")
for name, topic in sorted(bag.topics.items()):
    print(f"  {name:<32} {topic.type:<40} {topic.count:6d}")

time, position = bag.array("/joint_states", "position")
_, velocity = bag.array("/joint_states", "velocity")
print("joint   from/rad   to/rad   fastest/(rad/s)")
for k in range(position.shape[1]):
    print(f"{k + 1:5d} {position[0, k]:10.4f} {position[-1, k]:8.4f} {np.abs(velocity[:, k]).max():16.4f}")
print(f"period between states: {1e3 * np.median(np.diff(time)):.2f} ms")
