"""Where this package's compiled kernels are kept; imported before any of them is."""

from __future__ import annotations

from pathlib import Path

from flexsim_core.kept_kernels import keep_kernels


def one() -> None:
    """A function that could be kept where the kernels are."""


# kernels, their arrays and own code
keep_kernels(Path(__file__).parents[1], one, r"from \.+(compiled\.)?kernel import|NamedTuple|intrinsic")
