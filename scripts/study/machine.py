"""What a study's times were taken on."""

from __future__ import annotations

import hashlib
import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

COMPUTES = ("flexsim", "numpy", "numba", "scipy")


def versions(*packages: Path) -> dict[str, str]:
    """What a study's results depend on: the programs' versions, and the sources of these packages."""
    found = {name: str(value) for name, value in machine().items() if name in ("python", *COMPUTES)}
    sources = hashlib.sha256()
    for package in packages:
        for path in sorted(package.rglob("*.py")):
            sources.update(path.relative_to(package).as_posix().encode() + path.read_bytes())
    return {**found, "sources": sources.hexdigest()[:12]}


def machine() -> dict[str, Any]:
    """Processor, cores, load, and the versions of what computes."""
    cpu = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                cpu = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    found: dict[str, Any] = {
        "cpu": cpu,
        "cores": len(os.sched_getaffinity(0)),
        "load": round(os.getloadavg()[0], 2),
        "python": platform.python_version(),
    }
    for name in COMPUTES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
