"""Bags survive what can happen to them: nothing crashes, nothing is lost in silence, and no more than
the last second is lost.  Each kind of mishap is tried by the hundred."""

from __future__ import annotations

import errno
import json
import os
import resource
import signal
import struct
import subprocess
import sys
import time
import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from flexsim.bag import Bag, BagDamaged, BagError, BagWriter
from flexsim.bag.mcap_file import McapFile
from flexsim.bag.mend import mend
from flexsim.bag.writer import RESERVE, RESERVE_NAME
from processes import flexsim
from rosbags.rosbag2 import Reader

pytestmark = [pytest.mark.ros, pytest.mark.filterwarnings("ignore::flexsim.bag.BagDamaged")]

SECOND = 10**9
RATE = 100
SECONDS = 6
TORQUES, WORDS = "/torques", "/words"
HEAD = struct.Struct("<BQ")


def torque(k: int) -> bytes:
    """Return a std_msgs/Float64MultiArray with three numbers that only message k has."""
    values = np.array([k, np.sin(k), np.cos(k)])
    return b"\0\1\0\0" + struct.pack("<III4x", 0, 0, 3) + values.tobytes()


def word(k: int) -> bytes:
    text = f"message {k}".encode() + b"\0"
    return b"\0\1\0\0" + struct.pack("<I", len(text)) + text


def fill(bag: BagWriter, count: int = RATE * SECONDS, pace: float = 0.0) -> list[tuple[str, int, bytes]]:
    """Write messages of two topics, handed to the system each second of their log time."""
    torques = bag.add_topic(TORQUES, "std_msgs/msg/Float64MultiArray")
    words = bag.add_topic(WORDS, "std_msgs/msg/String")
    bag.note("parameters", {"rate": "100.0"})
    bag.attach("scene.yaml", "application/yaml", b"model: robot\n" * 20)
    written = []
    for k in range(count):
        log_time = SECOND + k * SECOND // RATE
        bag.write(torques, torque(k), log_time)
        written.append((TORQUES, log_time, torque(k)))
        if k % 10 == 0:
            bag.write(words, word(k), log_time)
            written.append((WORDS, log_time, word(k)))
        if k % RATE == RATE - 1:
            bag.flush_if_due()
    return written


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, list[tuple[str, int, bytes]]]:
    """The bytes of a sound file, and the messages in it."""
    path = tmp_path_factory.mktemp("whole") / "run"
    with BagWriter(path, flush_period=0.0) as bag:
        written = fill(bag)
    return (path / "run_0.mcap").read_bytes(), written


def records(data: bytes) -> list[int]:
    """Return where records begin, and the file's end."""
    found, at = [], 8
    while at + 9 <= len(data) - 8:
        found.append(at)
        at += 9 + HEAD.unpack_from(data, at)[1]
    return [*found, at, len(data)]


def read_all(path: Path) -> tuple[Bag, list[tuple[str, int, bytes]]]:
    """Read each message of a bag."""
    bag = Bag(path)
    found = []
    for messages in bag.read():
        for topic, some in messages.items():
            found += zip([topic] * len(some), some.log_time.tolist(), some.data(), strict=True)
    return bag, found


def check(path: Path, written: list[tuple[str, int, bytes]], until: int | None = None) -> None:
    """Hold what can be read against what was written; `until`: what may be lost is later than this."""
    bag, found = read_all(path)
    assert len(set(found)) == len(found)
    lost = sorted(set(written) - set(found), key=lambda m: m[1])
    assert not set(found) - set(written), "something was read that nobody wrote"
    if lost:
        assert bag.damages, "a silent loss"
        span = lost[-1][1] - lost[0][1]
        if until is None:
            assert span < SECOND, f"{span * 1e-9} s lost"
        else:
            assert lost[0][1] >= until


def check_mended(path: Path, written: list[tuple[str, int, bytes]], *, by_rosbags: bool) -> None:
    """Mend a bag in place: then it is whole, and others read as much of it as we did before."""
    _, before = read_all(path)
    if not before:
        return
    results = mend(path)
    bag, after = read_all(path)
    assert set(after) == set(before)
    assert bag.complete
    assert sum(r.count for r in results) == len(after)
    if by_rosbags:
        with Reader(path) as reader:
            assert reader.message_count == len(after)
            assert len(list(reader.messages())) == len(after)


def bag_of(data: bytes, folder: Path) -> Path:
    """Write a bag of one file, with no metadata.yaml."""
    path = folder / "run"
    path.mkdir(exist_ok=True)
    for old in path.iterdir():
        old.unlink()
    (path / "run_0.mcap").write_bytes(data)
    return path


def test_cut_off_anywhere(whole: tuple[bytes, list[tuple[str, int, bytes]]], tmp_path: Path) -> None:
    """A file that ends at any record, or anywhere, holds every chunk that ended before; it is mended."""
    data, written = whole
    boundaries = records(data)
    random = np.random.default_rng(1)
    cuts = [*boundaries[:-1], *random.integers(0, len(data), 200).tolist()]
    assert len(boundaries) > 30
    for n, cut in enumerate(cuts):
        path = bag_of(data[:cut], tmp_path)
        ends = [b for a, b in pairwise(boundaries) if data[a] == 6 and b <= cut]
        kept = sum(1 for _ in ends)  # a chunk is a second
        check(path, written, until=SECOND + kept * SECOND)
        assert not Bag(path).complete
        if n % 4 == 0:
            check_mended(path, written, by_rosbags=n % 8 == 0)


def flipped(data: bytes, bit: int) -> bytes:
    changed = bytearray(data)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


def test_flipped_bits(whole: tuple[bytes, list[tuple[str, int, bytes]]], tmp_path: Path) -> None:
    """A bit that is flipped anywhere costs at most the second that it is in, and that is said."""
    data, written = whole
    random = np.random.default_rng(2)
    for n, bit in enumerate(random.integers(0, 8 * len(data), 300).tolist()):
        path = bag_of(flipped(data, bit), tmp_path)
        check(path, written)
        if n % 5 == 0:
            check_mended(path, written, by_rosbags=n % 10 == 0)


def test_flipped_bits_in_a_file_without_end(
    whole: tuple[bytes, list[tuple[str, int, bytes]]], tmp_path: Path
) -> None:
    """The same where no index helps: a recorder was killed, and then the disk erred."""
    data, written = whole
    end = next(a for a in records(data) if data[a] == 15)
    random = np.random.default_rng(3)
    for n, bit in enumerate(random.integers(0, 8 * end, 300).tolist()):
        path = bag_of(flipped(data[:end], bit), tmp_path)
        check(path, written)
        assert not Bag(path).complete
        if n % 5 == 0:
            check_mended(path, written, by_rosbags=n % 10 == 0)


def test_each_bit_of_what_holds_chunks_together(
    whole: tuple[bytes, list[tuple[str, int, bytes]]], tmp_path: Path
) -> None:
    """Where a flip does most: each bit of each record's head, of the header and of the footer."""
    data, written = whole
    end = next(a for a in records(data) if data[a] == 15)
    heads = [8 * a + bit for a in records(data)[:12] for bit in range(0, 9 * 8, 5)]
    for bit in [*range(0, 64, 2), *heads]:
        for whole_file in (True, False):
            if bit < 8 * end or whole_file:
                path = bag_of(flipped(data if whole_file else data[:end], bit), tmp_path)
                check(path, written)


def test_garbage(tmp_path: Path) -> None:
    """What is no bag at all is refused, or read as nothing, and never crashes."""
    random = np.random.default_rng(4)
    for n in range(200):
        junk = random.bytes(int(random.integers(0, 3000)))
        path = bag_of((b"\x89MCAP0\r\n" if n % 2 else b"") + junk, tmp_path)
        try:
            bag, found = read_all(path)
        except ValueError as problem:
            assert "is not an MCAP file" in str(problem)
        else:
            assert not found
            assert not bag.complete


def test_killed_writer(tmp_path: Path) -> None:
    """A process that dies by SIGKILL at any moment loses at most what one flush period held.

    It writes down when it begins each message, so what is held against the period is what it did,
    however seldom a busy machine let it run: behind a message that came a period after the first
    that is lost, none was begun.
    """
    period = 0.02
    random = np.random.default_rng(5)
    for n in range(100):
        path = tmp_path / f"run_{n}"
        clock = np.memmap(tmp_path / "clock", dtype=np.float64, mode="w+", shape=200_000)
        child = os.fork()
        if child == 0:
            try:
                bag = BagWriter(path, flush_period=period)
                channel = bag.add_topic(TORQUES, "std_msgs/msg/Float64MultiArray")
                for k in range(len(clock)):
                    clock[k] = time.monotonic()
                    bag.write(channel, torque(k), SECOND + k)
                    bag.flush_if_due()
                    time.sleep(1e-4)
            finally:
                os._exit(1)
        while clock[0] == 0.0:
            time.sleep(1e-3)
        time.sleep(float(random.uniform(0.0, 0.06)))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        _, found = read_all(path)
        assert [m[2] for m in found] == [torque(k) for k in range(len(found))]
        assert not Bag(path).complete
        lost = clock[len(found) : np.count_nonzero(clock)]
        assert len(lost) < 2 or lost[-2] - lost[0] <= period
        check_mended(path, [], by_rosbags=n % 10 == 0)
        assert not (path / RESERVE_NAME).exists() or not found


class SmallDisk:
    """A file on a disk that has only so much room, and more when the bag's reserve is given up."""

    def __init__(self, file: object, room: int, folder: Path) -> None:
        self.file, self.room, self.reserve = file, room, folder / RESERVE_NAME

    def write(self, data: memoryview) -> int:
        free = self.room + (0 if self.reserve.exists() else RESERVE) - self.file.tell()
        if free <= 0:
            raise OSError(errno.ENOSPC, "no space left on device")
        return self.file.write(data[:free])

    def __getattr__(self, name: str) -> object:
        return getattr(self.file, name)


def test_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever the disk gets full, the writer says so, and all that it took is in a whole bag."""
    random = np.random.default_rng(6)
    begin = McapFile.__init__
    for n, room in enumerate(random.integers(3000, 60_000, 150).tolist()):

        def small(self: McapFile, path: Path, room: int = room, **more: int) -> None:
            begin(self, path, **more)
            self._file = SmallDisk(self._file, room, path.parent)

        monkeypatch.setattr(McapFile, "__init__", small)
        path = tmp_path / f"run_{n}"
        bag = BagWriter(path, flush_period=0.0)
        with pytest.raises(OSError, match="no space left"):
            fill(bag, 3000)
        bag.close()
        found_bag, found = read_all(path)
        assert found_bag.complete
        assert (bag.lost, found_bag.count, len(found)) == (0, bag.count, bag.count)
        assert sorted(p.name for p in path.iterdir()) == ["metadata.yaml", f"run_{n}_0.mcap"]
        if n % 5 == 0:
            with Reader(path) as reader:
                assert reader.message_count == len(found)


def test_room_for_the_end_grows(tmp_path: Path) -> None:
    """The index at a file's end grows with its chunks, and so does the room that is kept for it."""
    bag = BagWriter(tmp_path / "run", flush_period=0.0)
    topic = bag.add_topic(TORQUES, "std_msgs/msg/Float64MultiArray")
    reserved = tmp_path / "run" / RESERVE_NAME
    assert reserved.stat().st_size == RESERVE
    for k in range(3000):
        bag.write(topic, torque(k), SECOND + k)
        bag.flush_if_due()
    (file,) = (tmp_path / "run").glob("*.mcap")
    before = file.stat().st_size
    assert reserved.stat().st_size > RESERVE + 100_000
    kept = reserved.stat().st_size - RESERVE
    bag.close()
    assert 100_000 < file.stat().st_size - before < kept


def test_full_disk_without_reserve(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where not a byte is left: what was handed over is there, and what was lost is counted."""
    random = np.random.default_rng(8)
    begin = McapFile.__init__
    for n, room in enumerate(random.integers(3000, 60_000, 100).tolist()):

        def small(self: McapFile, path: Path, room: int = room, **more: int) -> None:
            begin(self, path, **more)
            self._file = SmallDisk(self._file, room - RESERVE, path.parent)
            (path.parent / RESERVE_NAME).unlink(missing_ok=True)

        monkeypatch.setattr(McapFile, "__init__", small)
        path = tmp_path / f"run_{n}"
        bag = BagWriter(path, flush_period=0.0)
        with pytest.raises(OSError, match="no space left"):
            fill(bag, 3000)
        closed = True
        try:
            bag.close()
        except OSError:
            closed = False  # for want of the last fifty bytes
        found_bag, found = read_all(path)
        assert found_bag.complete == closed
        assert len(found) == bag.count
        assert bag.lost <= 110  # a second
        if found and n % 5 == 0:
            check_mended(path, [], by_rosbags=False)


def test_a_disk_that_is_really_full(tmp_path: Path) -> None:
    """The recorder itself, on a small file system of its own: an error in words, and a whole bag."""
    script = f"""
mount -t tmpfs -o size=4m none {tmp_path} || exit 77
cd {tmp_path}
{sys.executable} -c "
from flexsim.bag import BagWriter
import os
bag = BagWriter('run')
topic = bag.add_topic('/words', 'std_msgs/msg/String')
try:
    for k in range(10**6):
        text = os.urandom(1000).hex().encode() + bytes(1)
        bag.write(topic, bytes([0, 1, 0, 0]) + len(text).to_bytes(4, 'little') + text, k)
except OSError as problem:
    print(problem.strerror)
bag.close()
print(bag.count, bag.lost)
" && {sys.executable} -c "from flexsim.cli import main; main()" info run --json
"""
    done = subprocess.run(["unshare", "-rm", "sh", "-c", script], capture_output=True, text=True, timeout=60)
    if done.returncode == 77 or "unshare" in done.stderr:  # may not mount: the tests above stand alone
        return
    assert done.returncode == 0, done.stderr
    said, count, rest = done.stdout.split("\n", 2)
    assert said == "No space left on device"
    info = json.loads(rest)
    assert info["complete"]
    assert count == f"{info['messages']} 0"
    assert info["messages"] > 1000


def test_files_that_may_not_grow(tmp_path: Path) -> None:
    """Under a limit on the size of files a bag goes on in further files, each of them whole."""
    random = np.random.default_rng(7)
    for n, limit in enumerate(random.integers(30_000, 80_000, 100).tolist()):
        path = tmp_path / f"run_{n}"
        child = os.fork()
        if child == 0:
            code = 1
            try:
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
                with BagWriter(path, flush_period=0.0) as bag:
                    fill(bag, 2000)
                code = 0
            finally:
                os._exit(code)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        bag, found = read_all(path)
        assert bag.complete
        assert len(found) == 2200
        assert len(bag.files) > 1
        assert all(file.stat().st_size <= limit for file in bag.files)
        if n % 10 == 0:
            with Reader(path) as reader:
                assert len(list(reader.messages())) == 2200


def test_the_command_mends(whole: tuple[bytes, list[tuple[str, int, bytes]]], tmp_path: Path) -> None:
    """`flexsim recover` says what was lost, keeps what was damaged, and does nothing to a whole bag."""
    data, written = whole
    boundaries = records(data)
    second = [a for a in boundaries[:-1] if data[a] == 6][1]
    broken = bytearray(data[: boundaries[-3]])
    broken[second + 60] ^= 8
    path = bag_of(bytes(broken), tmp_path)
    copied = json.loads(flexsim("recover", path, "-o", tmp_path / "copy", "--json").stdout)
    assert (path / "run_0.mcap").read_bytes() == bytes(broken)
    assert copied["messages"] == len(written) - 110
    done = flexsim("recover", path)
    assert done.returncode == 0, done.stderr
    assert "a chunk is damaged" in done.stdout
    assert (path / "run_0.mcap.damaged").read_bytes() == bytes(broken)
    bag = Bag(path)
    assert bag.complete
    assert bag.count == len(written) - 110
    assert bag.attachment("scene.yaml") == b"model: robot\n" * 20
    assert bag.notes() == {"parameters": {"rate": "100.0"}}
    before = (path / "run_0.mcap").stat().st_mtime_ns
    again = json.loads(flexsim("recover", path, "--json").stdout)
    assert again["whole"]
    assert (path / "run_0.mcap").stat().st_mtime_ns == before
    nothing = flexsim("recover", bag_of(b"", tmp_path))
    assert nothing.returncode == 1
    assert "holds nothing that can be read" in nothing.stderr


@pytest.mark.parametrize("name", ["notes.txt", "notes.mcap"])
def test_what_is_no_bag_is_not_mended(name: str, tmp_path: Path) -> None:
    """A wrong word on the command line costs nobody a file."""
    file = tmp_path / name
    file.write_text("model: robot\n" * 50)
    for path in (file, tmp_path) if name.endswith(".mcap") else (file,):
        for output in (None, tmp_path / "copy"):
            with pytest.raises(BagError, match=r"holds nothing that can be read|is not an MCAP file"):
                mend(path, output)
            assert [f.name for f in tmp_path.iterdir()] == [name]
    assert file.read_text() == "model: robot\n" * 50


def test_killed_before_the_first_message(tmp_path: Path) -> None:
    """What a recorder leaves that heard nothing becomes a whole bag without messages."""
    folder = tmp_path / "run"
    killed = BagWriter(folder)  # kept, so that nothing closes it
    assert not Bag(folder).complete
    mend(folder)
    assert Bag(folder).complete
    assert Bag(folder).count == 0
    assert sorted(f.name for f in folder.iterdir()) == ["metadata.yaml", "run_0.mcap"]
    del killed


def test_damage_is_said_where_it_is_met(
    whole: tuple[bytes, list[tuple[str, int, bytes]]], tmp_path: Path
) -> None:
    """A chunk that its index still promises is missed aloud by whoever reads on."""
    data, _ = whole
    second = [a for a in records(data)[:-1] if data[a] == 6][1]
    path = bag_of(flipped(data, 8 * (second + 60)), tmp_path)
    bag = Bag(path)
    assert bag.complete
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        t, _ = bag.array(TORQUES, "data")
    assert len(t) == RATE * (SECONDS - 1)
    assert [w.category for w in caught] == [BagDamaged]
    assert "a chunk is damaged" in str(bag.damages[0])
    assert not bag.complete
