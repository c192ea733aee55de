"""Bags of all kinds that people have, made by rosbags and mcap: one run, stored in many ways."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
MIXED = "cell_msgs/msg/Mixed"
STORE.register(
    get_types_from_msg(
        "string label\nstring[] parts\nstring<=8[<=3] tags\nfloat32[2] pair\n", "cell_msgs/msg/Tool"
    )
)
STORE.register(
    get_types_from_msg(
        "std_msgs/Header header\nbool on\nint8 small\nuint64 large\nuint16[] counts\n"
        "Tool[] tools\nTool[2] two\n",
        MIXED,
    )
)
JOINTS, PATH, TF = "sensor_msgs/msg/JointState", "nav_msgs/msg/Path", "tf2_msgs/msg/TFMessage"
ARRAY, TEXT, EMPTY = "std_msgs/msg/Float64MultiArray", "std_msgs/msg/String", "std_msgs/msg/Empty"
TOPICS = {
    "/joint_states": JOINTS, "/path": PATH, "/tf": TF, "/arm/commands": ARRAY, "/said": TEXT, "/stop": EMPTY,
    "/cell": MIXED,
}  # fmt: skip
T0 = 1_780_000_000_000_000_000
QOS = """- history: keep_last
  depth: 10
  reliability: reliable
  durability: volatile
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: automatic
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
"""


@dataclass
class Row:
    """A message: its topic, when it came, ns, and what it is."""

    topic: str
    time: int
    message: Any


def new(kind: str, *values: Any) -> Any:
    """Return a message of a type."""
    return STORE.types[kind](*values)


def header(time: int, frame: str = "base") -> Any:
    """Return a header stamped at a time, ns."""
    return new("std_msgs/msg/Header", new("builtin_interfaces/msg/Time", time // 10**9, time % 10**9), frame)


def joint_state(time: int, names: list[str], position: Any) -> Any:
    """Return a joint state."""
    q = np.array(position, np.float64)
    return new(JOINTS, header(time), list(names), q, 2 * q, 0.1 * q)


def run(count: int = 12, resets: int = 0, t0: int = T0, clock: int | None = None) -> list[Row]:
    """Return a run of all kinds of messages; its own clock begins anew so often.

    clock : ns, when the messages' own clock begins; that of receipt, if not given
    """
    rows: list[Row] = []
    point = STORE.types["geometry_msgs/msg/Point"]
    turn = new("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    offsets = 10.0 * np.arange(3)
    tool = STORE.types["cell_msgs/msg/Tool"]
    for part in range(resets + 1):
        for k in range(count):
            log = t0 + (part * count + k) * 10_000_000
            own = 10_000_000 * (k + 1) + (t0 if clock is None else clock)
            pose = new("geometry_msgs/msg/Pose", point(0.1 * k, 0.5, 0.0), turn)
            poses = [
                new("geometry_msgs/msg/PoseStamped", header(own, f"map{i % 3}"), deepcopy(pose))
                for i in range(k % 5)
            ]
            moved = new(
                "geometry_msgs/msg/Transform", new("geometry_msgs/msg/Vector3", 0.1 * k, 1.0, 2.0), turn
            )
            transforms = [
                new("geometry_msgs/msg/TransformStamped", header(own), f"link_{i}", deepcopy(moved))
                for i in range(3)
            ]
            tools = [
                tool(
                    f"t{i}",
                    [f"p{j}" * (i + 1) for j in range(k % 3)],
                    ["a"] * (k % 3),
                    np.array([k, i], np.float32),
                )
                for i in range(k % 4 + 2)
            ]
            layout = new("std_msgs/msg/MultiArrayLayout", [], 0)
            angles = np.sin(0.1 * (k + part + offsets))
            rows += [
                Row("/joint_states", log, joint_state(own, ["a", "b", "c"], angles)),
                Row("/joint_states", log + 1000, joint_state(own, ["finger"], [0.01 * k])),
                Row("/path", log + 2000, new(PATH, header(own), poses)),
                Row("/tf", log + 3000, new(TF, transforms)),
                Row("/arm/commands", log + 4000, new(ARRAY, layout, np.arange(2.0) + k)),
                Row("/said", log + 5000, new(TEXT, f"word {k}")),
                Row("/stop", log + 6000, new(EMPTY)),
                Row("/cell", log + 7000, new(MIXED, header(own), bool(k % 2), k - 3, 2**40 + k,
                    np.arange(k % 4, dtype=np.uint16), tools[2:], tools[:2])),
            ]  # fmt: skip
    return rows


def cdr(row: Row, little: bool = True) -> bytes:
    """Return a message as it goes over the wire."""
    return bytes(STORE.serialize_cdr(row.message, TOPICS[row.topic], little_endian=little))


def definition(kind: str) -> str:
    """Return a type's definition."""
    return str(STORE.generate_msgdef(kind, ros_version=2)[0])


def idl(kind: str, seen: set[str] | None = None) -> str:
    """Return a type's definition in ros2idl."""
    seen = set() if seen is None else seen
    if kind in seen:
        return ""
    seen.add(kind)
    words = {"float64": "double", "float32": "float", "bool": "boolean", "byte": "octet"}
    lines, others = [], []
    for name, (node, what) in STORE.get_msgdef(kind).fields:
        (inner, what), size = what if node in (3, 4) else ((node, what), None)
        if inner == 2:
            others.append(what)
        word = what.replace("/", "::") if inner == 2 else words.get(what[0], what[0])
        if node == 3:
            lines.append(f"      {word} {name}[{size}];")
        else:
            lines.append(f"      sequence<{word}> {name};" if node == 4 else f"      {word} {name};")
    package, folder, last = kind.split("/")
    text = "\n".join(["=" * 80, f"IDL: {kind}", f"module {package} {{", f"  module {folder} {{",
                      f"    struct {last} {{", *lines, "    };", "  };", "};", ""])  # fmt: skip
    return text + "".join(idl(other, seen) for other in others)


def by_mcap(
    path: Path, rows: list[Row], *, little: bool = True, schema: str = "ros2msg", **choices: Any
) -> Path:
    """Write an MCAP file with the choices that other writers make."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as stream:
        writer = McapWriter(stream, **choices)
        writer.start(profile="ros2", library="test")
        numbers = {}
        for topic in dict.fromkeys(row.topic for row in rows):
            kind = TOPICS[topic]
            text = idl(kind) if schema == "ros2idl" else "" if kind == EMPTY else definition(kind)
            number = writer.register_schema(kind, schema, text.encode())
            numbers[topic] = writer.register_channel(topic, "cdr", number, {"offered_qos_profiles": QOS})
        for k, row in enumerate(rows):
            writer.add_message(numbers[row.topic], row.time, cdr(row, little), row.time, k)
        writer.finish()
    return path


def by_rosbags(
    path: Path, rows: list[Row], plugin: StoragePlugin, mode: CompressionMode = CompressionMode.NONE,
    custom: dict[str, str] | None = None,
) -> Path:  # fmt: skip
    """Write a bag's folder as rosbag2 does."""
    writer = Writer(path, version=9, storage_plugin=plugin)
    if mode != CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        for key, value in (custom or {}).items():
            writer.set_custom_data(key, value)
        topics = dict.fromkeys(row.topic for row in rows)
        open_ = {t: writer.add_connection(t, TOPICS[t], typestore=STORE) for t in topics}
        for row in rows:
            writer.write(open_[row.topic], row.time, cdr(row))
    return path


def in_parts(path: Path, rows: list[Row]) -> Path:
    """Write a bag that is split into two files, without metadata.yaml."""
    half = len(rows) // 2
    by_mcap(path / "run_0.mcap", rows[:half])
    by_mcap(path / "run_1.mcap", rows[half:])
    return path


MCAP, SQLITE = StoragePlugin.MCAP, StoragePlugin.SQLITE3
FILE, MESSAGE = CompressionMode.FILE, CompressionMode.MESSAGE
# How a run can be stored; each takes a path without ending, and returns what is to be opened.
KINDS: dict[str, Callable[[Path, list[Row]], Path]] = {
    "mcap, zstd": lambda p, r: by_mcap(p.with_suffix(".mcap"), r),
    "mcap, lz4": lambda p, r: by_mcap(p.with_suffix(".mcap"), r, compression=CompressionType.LZ4),
    "mcap, plain": lambda p, r: by_mcap(p.with_suffix(".mcap"), r, compression=CompressionType.NONE),
    "mcap, unchunked": lambda p, r: by_mcap(p.with_suffix(".mcap"), r, use_chunking=False),
    "mcap, no index": lambda p, r: by_mcap(p.with_suffix(".mcap"), r, index_types=IndexType.NONE),
    "mcap, no statistics": lambda p, r: by_mcap(p.with_suffix(".mcap"), r, use_statistics=False),
    "mcap, no summary": lambda p, r: by_mcap(
        p.with_suffix(".mcap"), r, use_summary_offsets=False, repeat_channels=False, repeat_schemas=False,
        use_statistics=False, index_types=IndexType.NONE,
    ),
    "mcap, a message a chunk": lambda p, r: by_mcap(p.with_suffix(".mcap"), r, chunk_size=1),
    "mcap, big-endian": lambda p, r: by_mcap(p.with_suffix(".mcap"), r, little=False),
    "mcap, ros2idl": lambda p, r: by_mcap(p.with_suffix(".mcap"), r, schema="ros2idl"),
    "mcap, two files": in_parts,
    "rosbag2, mcap": lambda p, r: by_rosbags(p, r, MCAP),
    "rosbag2, mcap by file": lambda p, r: by_rosbags(p, r, MCAP, FILE),
    "rosbag2, mcap by message": lambda p, r: by_rosbags(p, r, MCAP, MESSAGE),
    "rosbag2, sqlite3": lambda p, r: by_rosbags(p, r, SQLITE),
    "rosbag2, sqlite3 by file": lambda p, r: by_rosbags(p, r, SQLITE, FILE),
    "rosbag2, sqlite3 by message": lambda p, r: by_rosbags(p, r, SQLITE, MESSAGE),
}  # fmt: skip


def copied(row: Row) -> Row:
    """Return a row whose message is its own."""
    return Row(row.topic, row.time, deepcopy(row.message))


def leaves(message: Any) -> list[tuple[Any, Any]]:
    """Return all places of a message that hold a value: (owner, name of its field or number in it)."""
    if not dataclasses.is_dataclass(message):
        return []
    found: list[tuple[Any, Any]] = []
    for f in dataclasses.fields(message):
        if f.name == "structure_needs_at_least_one_member" or f.name.startswith("__"):
            continue
        value = getattr(message, f.name)
        if dataclasses.is_dataclass(value):
            found += leaves(value)
        elif isinstance(value, np.ndarray) or (
            isinstance(value, list) and (not value or isinstance(value[0], str))
        ):
            found += [(value, i) for i in range(len(value))]
        elif isinstance(value, list):
            found += [leaf for one in value for leaf in leaves(one)]
        else:
            found.append((message, f.name))
    return found


def other(value: Any, random: np.random.Generator) -> Any:
    """Return a value that differs, as little as can be or by much."""
    if isinstance(value, str):
        return value + "x" if not value or random.random() < 0.5 else "#" + value[1:]
    if isinstance(value, (bool, np.bool_)):
        return not value
    if isinstance(value, (float, np.floating)):
        ends = [np.nextafter(value, np.inf), -value if value else -0.0, np.nan, value + 1.0]
        return type(value)(ends[random.integers(len(ends))])
    return type(value)(value + 1 if int(value) < 100 else value - 1)
