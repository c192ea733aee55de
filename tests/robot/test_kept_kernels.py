"""Where kernels can't be kept on disk the programs go on without."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

# Files of more than a kilobyte can't be written, as on a full disk; a torn index lies in the way.
FULL = """
import resource
from pathlib import Path
from numba import njit
import PACKAGE.compiled
from kernels import twice
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
assert twice(3.0) == 6.0
for path in Path("__pycache__").glob("*.nbi"):
    raise AssertionError(f"{path} was kept")
"""
TORN = """
from pathlib import Path
import PACKAGE.compiled
from kernels import twice
assert twice(3.0) == 6.0
(index,) = Path("__pycache__").glob("*.nbi")
index.write_bytes(index.read_bytes()[:7])
from importlib import reload
import kernels
assert reload(kernels).twice(3.0) == 6.0
assert len(index.read_bytes()) > 7
index.write_bytes(b"")
assert reload(kernels).twice(3.0) == 6.0
assert index.read_bytes()
"""
NOWHERE = """
import os, tempfile
import PACKAGE.compiled
from flexsim_core import kept_kernels as kept
from numba import config
source = "def f():\\n    return 1\\n"
space = {}
exec(compile(source, "/proc/none/here.py", "exec"), space)
assert not config.CACHE_DIR
kept.find_room(space["f"])
assert os.stat(config.CACHE_DIR).st_mode & 0o077 == 0
print(config.CACHE_DIR)
"""


@pytest.mark.parametrize("package", ["flexsim_node", "thermal_node"])
@pytest.mark.parametrize("script", [FULL, TORN, NOWHERE])
def test_a_bad_disk_costs_a_compilation(tmp_path: Path, script: str, package: str) -> None:
    (tmp_path / "kernels.py").write_text(
        "from numba import njit\n\n\n@njit(cache=True)\ndef twice(x):\n    return 2.0 * x\n"
    )
    environment = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
    words = [sys.executable, "-c", script.replace("PACKAGE", package)]
    path = os.pathsep.join([str(Path(__file__).parents[2]), environment.get("PYTHONPATH", ""), str(tmp_path)])
    done = subprocess.run(
        words,
        cwd=tmp_path,
        env=environment | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    if script is NOWHERE:
        assert not Path(done.stdout.strip()).exists()  # it goes with its process


def test_copies_within_a_kernel_have_names_of_their_own(monkeypatch):
    """LLVM's loader takes whatever has a function's name: a copy that lost arguments is not to be found."""
    from llvmlite.binding import Linkage
    from numba import njit

    from flexsim_node.compiled import kernel

    optimize, names = kernel.optimize_shared, []

    def watched(library):
        functions = library._final_module.functions
        names.extend(f.name for f in functions if f.linkage == Linkage.internal)
        optimize(library)

    monkeypatch.setattr(kernel, "optimize_shared", watched)

    @njit
    def added(x, y):
        return x + y

    @njit
    def twice(x):
        return added(x, x)

    assert twice(2.0) == 4.0
    (called,) = added.overloads.values()
    assert called.fndesc.mangled_name not in names
    assert any(name.startswith(f"{called.fndesc.mangled_name}.") for name in names)
