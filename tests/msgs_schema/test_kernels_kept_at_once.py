"""Kernels that several processes keep at once: what an index leads to is what was saved under it."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest
from flexsim_core import kept_kernels
from numba.core.caching import IndexDataCacheFile

PROCESSES, ROUNDS = 8, 20
SAVE = """
import sys, time
from flexsim_core import kept_kernels
from numba.core.caching import IndexDataCacheFile
folder, name, begin = sys.argv[1], sys.argv[2], float(sys.argv[3])
time.sleep(max(0.0, begin - time.time()))
for k in range({rounds}):
    file = IndexDataCacheFile(folder, f"kernel_{{k}}", "as it is")
    file.save(name, f"code of {{name}}" * 1000)
    found = file.load(name)
    assert found is None or found == f"code of {{name}}" * 1000, found[:20]
"""


def test_no_process_gets_another_s_code(tmp_path: Path) -> None:
    """Eight processes save and load different signatures of the same functions at the same time."""
    assert kept_kernels.IndexDataCacheFile is IndexDataCacheFile
    begin = time.time() + 4.0
    words = [sys.executable, "-c", SAVE.format(rounds=ROUNDS), str(tmp_path)]
    started = [
        subprocess.Popen([*words, f"signature {n}", str(begin)], stderr=subprocess.PIPE, text=True)
        for n in range(PROCESSES)
    ]
    for process in started:
        _, errors = process.communicate(timeout=120)
        assert process.returncode == 0, errors
    for k in range(ROUNDS):
        file = IndexDataCacheFile(str(tmp_path), f"kernel_{k}", "as it is")
        for n in range(PROCESSES):
            assert file.load(f"signature {n}") == f"code of signature {n}" * 1000


def test_a_folder_that_can_t_be_written_is_still_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = IndexDataCacheFile(str(tmp_path), "kernel", "as it is")
    file.save("signature", "code")
    original = Path.open

    def refused(path: Path, *arguments: object, **more: object) -> object:
        if path.name == "kernels.lock":
            raise PermissionError(13, "Permission denied", str(path))
        return original(path, *arguments, **more)

    monkeypatch.setattr(Path, "open", refused)
    assert file.load("signature") == "code"
