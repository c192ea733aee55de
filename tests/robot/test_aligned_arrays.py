"""What a step works on begins with a cache line, and a copy holds the same."""

import numpy as np
from scenes import CONFIG

from flexsim_node import load_scene
from flexsim_node.compiled.aligned import LINE, aligned, zeros
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model


def test_arrays_of_a_step():
    """Those that hold a vector of eight numbers, of a robot with reduced links: its tapes are the longest."""
    reduced = {"reduction": {"modes": 2}, "links.link_2.beam.elements": 4, "links.link_3.beam.elements": 4}
    chain = build_model(load_scene(CONFIG / "anthropomorphic.yaml", reduced)).chain
    for tape in (chain, workspace(chain)):
        begins = {name: array.ctypes.data % LINE for name, array in tape.values._asdict().items()
                  if isinstance(array, np.ndarray) and array.size >= 8}  # fmt: skip
        assert len(begins) > 10
        assert {name for name, begin in begins.items() if begin} == set()


def test_a_copy():
    for given in (np.arange(12.0).reshape(3, 4), np.arange(3), np.array([True, False]), np.zeros((0, 4))):
        copy = aligned(given)
        assert (copy.dtype, copy.shape) == (given.dtype, given.shape)
        np.testing.assert_array_equal(copy, given)
    assert (zeros((2, 3)) == 0.0).all()
