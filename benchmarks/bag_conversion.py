"""How fast a long bag becomes a rerun recording: `python benchmarks/bag_conversion.py [--json]`.

The bag is what a busy day records: 1 kHz joint states of seven joints, 1 kHz elastic states of 60
nodes, a diagnostic message a second, and 10 Hz temperature fields of 20,000 values.  It is written
here as a recorder does, the motion being that of a swinging arm with noise in the last digits,
as a simulation has it.  Then `flexsim view --save` converts it, in a process of its own.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import struct
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from flexsim.bag import BagWriter, qos

JOINTS, NODES, LINKS = 7, 60, 6
RATE, FIELD_RATE = 1000, 10
ACROSS, UP, DEPTH = 20, 50, 20  # 20,000 nodes of the leaf
COMMAND = [sys.executable, "-c", "from flexsim.cli import main; main()"]
PACKAGES = ("numpy", "rerun-sdk", "mcap", "zstandard")
SECOND = 10**9


class Cdr:
    """Builds little-endian CDR."""

    def __init__(self) -> None:
        self.data = bytearray(b"\0\1\0\0")

    def align(self, size: int) -> None:
        self.data += bytes((4 - len(self.data)) % size)

    def number(self, code: str, value: float) -> Cdr:
        self.align(struct.calcsize(code))
        self.data += struct.pack("<" + code, value)
        return self

    def text(self, words: str) -> Cdr:
        coded = words.encode() + b"\0"
        self.number("I", len(coded))
        self.data += coded
        return self

    def texts(self, words: list[str]) -> Cdr:
        self.number("I", len(words))
        for word in words:
            self.text(word)
        return self

    def array(self, values: np.ndarray) -> Cdr:
        self.number("I", values.size)
        self.align(values.dtype.itemsize)
        self.data += values.tobytes()
        return self

    def header(self, time: int, frame: str) -> Cdr:
        return self.number("i", time // SECOND).number("I", time % SECOND).text(frame)


def joint_state(time: int, q: np.ndarray, v: np.ndarray) -> bytes:
    names = [f"joint_{k + 1}" for k in range(JOINTS)]
    message = Cdr().header(time, "base").texts(names)
    return bytes(message.array(q).array(v).array(0.1 * q).data)


def elastic_state(time: int, displacement: np.ndarray, position: np.ndarray, rigid: np.ndarray) -> bytes:
    message = Cdr().header(time, "base").array(displacement).array(position).array(rigid)
    return bytes(message.text("ok").data)


def elastic_layout() -> bytes:
    each = NODES // LINKS
    first = np.array([n for n in range(NODES) if (n + 1) % each], dtype=np.uint32)
    message = Cdr().header(0, "base").texts([f"link_{k}" for k in range(LINKS)])
    message.texts([f"link_{n // each}/{n % each}" for n in range(NODES)])
    message.array(np.arange(NODES, dtype=np.uint32) // each)
    message.array(np.stack([first, first + 1], axis=1).ravel().astype(np.uint32))
    return bytes(message.array(np.full(len(first), 0.03)).array(np.full(len(first), 0.02)).data)


def leaf_mesh() -> bytes:
    x, y, z = (np.linspace(-0.5, 0.5, n) for n in (ACROSS, UP, DEPTH))
    grid = np.stack(np.meshgrid(x, y, 0.06 * (z + 0.5), indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange(grid.shape[0], dtype=np.uint32).reshape(ACROSS, UP, DEPTH)
    corner = [index[a:, b:, c:][: ACROSS - 1, : UP - 1, : DEPTH - 1] for c in (0, 1)
              for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]  # fmt: skip
    cells = np.stack(corner, axis=-1).reshape(-1, 8)
    message = Cdr().header(0, "leaf").array(grid.ravel()).array(cells.ravel())
    return bytes(message.array(np.zeros(len(cells), np.uint32)).texts(["steel"]).data)


def diagnostics(time: int) -> bytes:
    message = Cdr().header(time, "").number("I", 1).number("B", 0).text("flexsim_node: real time")
    values = {
        "real-time factor": "1.000000",
        "overruns": str(time // SECOND // 60),
        "step time p50, µs": "41.2",
        "step time worst, µs": f"{80 + time // SECOND % 40}.0",
    }
    message.text("realtime, running").text("arm").number("I", len(values))
    for pair in values.items():
        message.text(pair[0]).text(pair[1])
    return bytes(message.data)


def write(path: Path, minutes: float) -> int:
    """Write the bag; returns its messages' bytes."""
    random = np.random.default_rng(0)
    total = 0
    arm = np.linspace(0.0, 1.5, NODES)
    with BagWriter(path) as bag:
        latched = [qos.offered(durability="transient_local", depth=1)]
        layouts = bag.add_topic("/flexsim_node/elastic_layout", "flexsim_msgs/msg/ElasticLayout", latched)
        meshes = bag.add_topic("/door/mesh", "flexsim_msgs/msg/LeafMesh", latched)
        joints = bag.add_topic("/joint_states", "sensor_msgs/msg/JointState")
        states = bag.add_topic("/flexsim_node/elastic_state", "flexsim_msgs/msg/ElasticState")
        fields = bag.add_topic("/door/temperature_field", "flexsim_msgs/msg/TemperatureField")
        health = bag.add_topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
        start = 1_700_000_000 * SECOND
        bag.write(layouts, elastic_layout(), start)
        bag.write(meshes, leaf_mesh(), start)
        depth = np.tile(np.linspace(1.0, 0.0, DEPTH), ACROSS * UP)
        for k in range(round(60 * minutes * RATE)):
            t = k / RATE
            now, stamp = start + k * SECOND // RATE, max(1, k * SECOND // RATE)
            q = np.sin(1.1 * t + np.arange(JOINTS)) + 1e-12 * random.standard_normal(JOINTS)
            turn = np.array([np.cos(q[0]), np.sin(q[0]), 0.3 * np.sin(q[1])])
            rigid = arm[:, None] * turn
            swing = 0.01 * np.exp(-0.1 * (t % 10.0)) * np.sin(2 * np.pi * 6.0 * t)
            bent = (swing * (arm / 1.5) ** 2)[:, None] * np.array([0.3, -0.2, 1.0])
            bent = bent + 1e-9 * random.standard_normal(bent.shape)
            turned = np.hstack([bent, 0.5 * bent])
            for channel, data in (
                (joints, joint_state(stamp, q, 1.1 * q)),
                (states, elastic_state(stamp, turned, rigid + bent, rigid)),
            ):
                bag.write(channel, data, now)
                total += len(data)
            if k % (RATE // FIELD_RATE) == 0:
                warm = (
                    20.0
                    + 900.0 * depth * (1.0 - np.exp(-t / 900.0))
                    + 0.01 * random.standard_normal(depth.size)
                )
                data = bytes(Cdr().header(stamp, "leaf").array(warm).data)
                bag.write(fields, data, now)
                total += len(data)
            if k % RATE == 0:
                bag.write(health, diagnostics(stamp), now)
    return total


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--folder", type=Path, help="where to write; else a temporary folder")
    parser.add_argument("--keep", action="store_true", help="leave the bag there, and use the one that is")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=given.folder) as temporary:
        folder = given.folder if given.keep else Path(temporary)
        bag = folder / f"bag_{given.minutes:g}min"
        begun = time.monotonic()
        total = 0 if bag.exists() else write(bag, given.minutes)
        written = time.monotonic() - begun
        rrd = Path(temporary) / "bag.rrd"
        begun = time.monotonic()
        words = [*COMMAND, "view", str(bag), "--save", str(rrd), "--json"]
        done = subprocess.run(words, capture_output=True, text=True)
        converted = time.monotonic() - begun
        if done.returncode:
            sys.exit(done.stderr)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        found: dict[str, Any] = {
            "minutes": given.minutes,
            "message_bytes": total,
            "bag_bytes": sum(f.stat().st_size for f in bag.iterdir()),
            "write_time": written,
            "conversion_time": converted,
            "conversion_time_an_hour": converted * 60.0 / given.minutes,
            "conversion_cpu": used.ru_utime + used.ru_stime,
            "conversion_memory_bytes": 1024 * used.ru_maxrss,
            "recording_bytes": rrd.stat().st_size,
            "rows": json.loads(done.stdout)["rows"],
            "cores": os.cpu_count(),
            "machine": platform.machine(),
            "python": platform.python_version(),
            "packages": {name: version(name) for name in PACKAGES},
        }
    if given.json:
        print(json.dumps(found, indent=2))
        return
    for key, value in found.items():
        print(f"{key:26} {value:.3f}" if isinstance(value, float) else f"{key:26} {value}")


if __name__ == "__main__":
    main()
