"""Whatever a bag's bytes are: no crash, no hang, bounded memory, nothing imported or written elsewhere."""

from __future__ import annotations

import json
import resource
import shutil
import struct
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import mcap.reader  # noqa: F401, imported by recover where it writes
import numpy as np
import pytest
from bag_kinds import EMPTY, JOINTS, KINDS, QOS, by_mcap, run
from flexsim.bag import Bag, BagError
from flexsim.bag.mend import mend
from flexsim.bag.scenes import scenes_in
from flexsim.comparison.bags import compare_bags
from flexsim.health.examination import examine
from flexsim.signals.written import Signals
from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer
from processes import flexsim_here

pytestmark = pytest.mark.filterwarnings("ignore::flexsim.bag.BagDamaged", "ignore::UserWarning")
# Of a file of a few kilobytes; a machine that has other work is slow, a hang is not.
SECONDS, MEGABYTES = 60.0, 700


def used(path: Path, output: Path) -> None:
    """Do with a bag all that the verbs do; only what is told in words may come of it."""
    try:
        bag = Bag(path)
    except BagError:
        bag = None
    if bag is not None:
        for work in (
            examine,
            scenes_in,
            lambda b: list(b.by_time([*b.topics])),
            lambda b: compare_bags(b, b),
        ):
            try:
                work(bag)
            except BagError:
                continue
        for topic in bag.topics:
            try:
                list(Signals(bag, topic).rows())
            except BagError:
                continue
    with suppress(BagError):
        mend(path, output)


def spoilt(data: bytes, random: np.random.Generator) -> bytes:
    """Return bytes of which some are others, or are gone, or say absurd lengths."""
    found = bytearray(data)
    how = int(random.integers(6))
    if how == 0:
        return bytes(found[: int(random.integers(len(found)))])
    if how == 1:
        for _ in range(int(random.integers(1, 20))):
            found[int(random.integers(len(found)))] ^= 1 << int(random.integers(8))
    elif how == 2:
        absurd = [2**64 - 1, 2**63, 2**40, 2**32 - 1, 2**31, 0][int(random.integers(6))]
        at = int(random.integers(max(1, len(found) - 8)))
        found[at : at + 8] = struct.pack("<Q", absurd)
    elif how == 3:
        a, b = sorted(random.integers(len(found), size=2).tolist())
        del found[a : min(b, a + 200)]
    elif how == 4:
        a, b = sorted(random.integers(len(found), size=2).tolist())
        found[a:a] = found[a:b]
    else:
        a = int(random.integers(len(found)))
        found[a : a + 64] = random.integers(256, size=64, dtype=np.uint8).tobytes()
    return bytes(found)


def check(folder: Path, count: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    sound = folder / "sound"
    paths = {}
    for number, (kind, made) in enumerate(KINDS.items()):
        (sound / f"{number}").mkdir(parents=True)
        paths[kind] = made(sound / f"{number}" / "run", run(3))
        used(paths[kind], folder / f"warm_{number}")  # what is imported for a sound bag is imported
        shutil.rmtree(folder / f"warm_{number}", ignore_errors=True)
    modules, before = set(sys.modules), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for number in range(count):
        kind = [*KINDS][number % len(KINDS)]
        there = folder / "spoilt"
        shutil.copytree(paths[kind].parent, there)
        files = sorted(f for f in there.rglob("*") if f.is_file())
        file = files[int(random.integers(len(files)))]
        file.write_bytes(spoilt(file.read_bytes(), random))
        kept = {f: f.read_bytes() for f in files}
        begun = time.monotonic()
        try:
            used(there / paths[kind].name, folder / "mended")
        except Exception as problem:
            kept_file = folder / f"{number}"
            shutil.copytree(there, kept_file)
            raise AssertionError(f"{kind}, {file.name}, number {number}, {kept_file}") from problem
        assert time.monotonic() - begun < SECONDS, (kind, number)
        assert {f: f.read_bytes() for f in sorted(there.rglob("*")) if f.is_file()} == kept
        assert {f.name for f in folder.iterdir()} <= {"sound", "spoilt", "mended"}
        shutil.rmtree(there)
        shutil.rmtree(folder / "mended", ignore_errors=True)
    new = {
        name for name in set(sys.modules) - modules if name.partition(".")[0] not in ("encodings", "flexsim")
    }
    assert not new
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    assert grown < MEGABYTES, f"{grown:.0f} MB"


def test_spoilt_bags(tmp_path: Path) -> None:
    check(tmp_path, 85, 1)


@pytest.mark.nightly
def test_ten_thousand_spoilt_bags(tmp_path: Path) -> None:
    check(tmp_path, 10_000, 2)


def by_hand(path: Path, topic: str, kind: str, schema: str, data: bytes, encoding: str = "ros2msg") -> Path:
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        number = writer.register_schema(kind, encoding, schema.encode())
        channel = writer.register_channel(topic, "cdr", number, {"offered_qos_profiles": QOS})
        for k in range(3):
            writer.add_message(channel, k, data, k)
        writer.finish()
    return path


ABSURD = (0, 8, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)


@pytest.mark.parametrize("opcode", [Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX])
@pytest.mark.parametrize("at", [0, 8])
def test_an_index_that_points_nowhere(opcode: int, at: int, tmp_path: Path) -> None:
    """Where the end's index is absurd, what it should have named is found in the file itself."""
    path = tmp_path / "run.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        writer.add_attachment(5, 7, "notes.txt", "text/plain", b"spare gripper")
        writer.add_metadata("cell", {"operator": "night shift"})
        writer.finish()
    whole = path.read_bytes()
    footer = len(whole) - 8 - 20
    place, _, _ = struct.unpack_from("<QQI", whole, footer)
    while whole[place] != opcode:
        place += 9 + struct.unpack_from("<Q", whole, place + 1)[0]
    for absurd in ABSURD:
        spoilt = bytearray(whole)
        struct.pack_into("<Q", spoilt, place + 9 + at, absurd)
        struct.pack_into("<I", spoilt, footer + 16, 0)  # no checksum of the summary
        path.write_bytes(spoilt)
        used(path, tmp_path / f"{absurd}")
        bag = Bag(path)
        assert bag.attachments() == ["notes.txt"]
        assert bag.attachment("notes.txt") == b"spare gripper"
        assert bag.notes() == {"cell": {"operator": "night shift"}}


def types(*parts: str) -> str:
    """Return a definition: the root's fields, then NAME: fields of each other type."""
    return f"\n{'=' * 80}\nMSG: ".join(
        part.replace(": ", "\n", 1) if k else part for k, part in enumerate(parts)
    )


# Each type has the next twice, in a list: a trillion fields.
DOUBLED = [f"x/T{k}: T{k + 1} a\nT{k + 1} b" for k in range(40)]
DIAMONDS = [f"x/{one}{k}: A{k + 1} a\nB{k + 1} b" for k in range(40) for one in "AB"]
MESH = types("A0 t", *DIAMONDS, "x/A40: bool x", "x/B40: bool x")
SHORT = b"\0\1\0\0\0"
HOSTILE: dict[str, tuple[str, str, str, bytes]] = {
    "a type that contains itself": ("x/msg/A", "ros2msg", "A a\n", SHORT),
    "two types in a circle": ("x/msg/A", "ros2msg", types("B b", "x/B: A a"), SHORT),
    "a doubling of types": ("x/msg/A", "ros2msg", types("T0 t", *DOUBLED, "x/T40: int8 x"), SHORT),
    "a list of doubled types": ("x/msg/A", "ros2msg", types("T0[] t", *DOUBLED, "x/T40: int8 x"), bytes(8)),
    "a mesh of types": ("x/msg/A", "ros2msg", MESH, SHORT),
    "an array of a billion": ("x/msg/A", "ros2msg", "int8[1000000000] x\n", SHORT),
    "a billion structures": ("x/msg/A", "ros2msg", types("B[1000000000] x", "x/B: bool y"), bytes(99)),
    "a length of four gigabytes": ("x/msg/A", "ros2msg", "string data\n", b"\0\1\0\0" + b"\xff" * 4),
    "deep IDL": ("x/msg/A", "ros2idl", "module x { module msg { struct A { " + "sequence<" * 3000, SHORT),
    "a name that is a path": ("../../../etc/passwd", "ros2msg", "", SHORT),
    "a name that is a module": ("os/path/join", "ros2msg", "", SHORT),
}  # fmt: skip


@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_definitions(what: str, tmp_path: Path) -> None:
    """They are refused in a sentence, or found to be longer than their messages."""
    kind, encoding, schema, data = HOSTILE[what]
    begun = time.monotonic()
    used(by_hand(tmp_path / "a.mcap", "/t", kind, schema, data, encoding), tmp_path / "out")
    assert time.monotonic() - begun < SECONDS


@pytest.mark.parametrize("what", HOSTILE)
def test_what_cannot_be_decoded_is_counted(what: str, tmp_path: Path) -> None:
    """A robot's joint states with such a definition are timed and counted as any messages are."""
    _, encoding, schema, data = HOSTILE[what]
    bag = Bag(by_hand(tmp_path / "a.mcap", "/joint_states", JOINTS, schema, data, encoding))
    assert [t.count for t in examine(bag).timings.values()] == [bag.count] != [0]


def bomb(path: Path) -> Path:
    """Return an MCAP file whose only chunk is a gigabyte of nothing."""
    import zstandard

    squeezed = zstandard.ZstdCompressor().compress(bytes(1 << 20))
    body = (
        struct.pack("<QQQI", 0, 1, 1 << 40, 0)
        + struct.pack("<I", 4)
        + b"zstd"
        + struct.pack("<Q", len(squeezed))
        + squeezed
    )
    whole = by_mcap(path, run(2), compression=CompressionType.ZSTD).read_bytes()
    head = whole.index(bytes([Opcode.CHUNK]), 40)
    path.write_bytes(whole[:head] + struct.pack("<BQ", Opcode.CHUNK, len(body)) + body + whole[head:])
    return path


def swelling(folder: Path) -> Path:
    """Return a file of a few kilobytes that unpacks to more than a gigabyte."""
    import zstandard

    path = folder / "swell.mcap.zstd"
    with path.open("wb") as stream, zstandard.ZstdCompressor(level=19).stream_writer(stream) as packed:
        for _ in range(1200):
            packed.write(bytes(1 << 20))
    return path


@pytest.mark.parametrize("made", [lambda p: bomb(p / "bomb.mcap"), swelling], ids=["chunk", "file"])
def test_archives_that_swell(made: Callable[[Path], Path], tmp_path: Path) -> None:
    """Neither memory nor disk is filled by what a file says of itself."""
    path = made(tmp_path)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    used(path, tmp_path / "out")
    assert (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024 < MEGABYTES


def test_files_outside_the_bag_are_not_read(tmp_path: Path) -> None:
    """metadata.yaml may list what it likes: only files within its folder are taken."""
    outside = by_mcap(tmp_path / "outside_0.mcap", run(2))
    bag = tmp_path / "bag"
    bag.mkdir()
    for name in ("../outside_0.mcap", str(outside), "sub/../../outside_0.mcap"):
        (bag / "metadata.yaml").write_text(
            f"rosbag2_bagfile_information:\n  relative_file_paths: [{json.dumps(name)}]\n"
        )
        with pytest.raises(BagError, match="lists"):
            Bag(bag)


def test_a_terminal_obeys_nothing_of_a_file(tmp_path: Path) -> None:
    """Names, types and texts with control characters are shown as escapes by every verb."""
    odd = "/odd\x1b[2J\x07\u202e\r\n"
    path = by_hand(tmp_path / "odd.mcap", odd, EMPTY, "", b"\0\1\0\0\0")
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        for words in (("info", path), ("compare", path, path), ("export", path, "-o", tmp_path / "tables"),
                      ("recover", path), ("report", path), ("view", path, "--save", tmp_path / "x.rrd"),
                      ("info", tmp_path / "no\x1b[2J.mcap")):  # fmt: skip
            done = flexsim_here(*words, cwd=tmp_path)
            for text in (done.stdout, done.stderr):
                assert not set("\x1b\x07\u202e\r") & set(text), (words, text)
    assert sorted(f.name for f in (tmp_path / "tables").iterdir()) == ["odd_2J_.csv"]
