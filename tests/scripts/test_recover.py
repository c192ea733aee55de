"""`recover` mends what is broken and changes nothing else; mcap and rosbags are the judges."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from bag_kinds import JOINTS, KINDS, MCAP, MESSAGE, QOS, T0, by_mcap, by_rosbags, cdr, definition, idl, run
from flexsim.bag import Bag, BagError
from flexsim.bag.mend import mend
from mcap.reader import NonSeekingReader, make_reader
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import Reader
from ruamel.yaml import YAML


def folder_bytes(path: Path) -> dict[str, bytes]:
    return {f.name: f.read_bytes() for f in path.rglob("*") if f.is_file()}


def messages(file: Path) -> list[tuple[Any, ...]]:
    """Return all that mcap reads: each message with its channel and schema."""
    with file.open("rb") as stream:
        return [
            (c.topic, c.message_encoding, tuple(c.metadata.items()),
             s and (s.name, s.encoding, s.data), m.log_time, m.publish_time, m.sequence, m.data)
            for s, c, m in NonSeekingReader(stream, validate_crcs=True).iter_messages(log_time_order=False)
        ]  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_sound_bag_is_left_as_it_is(kind: str, tmp_path: Path) -> None:
    """Not a byte changes, in place nor in a copy; and valid files without index or statistics are sound."""
    (tmp_path / "there").mkdir()
    path = KINDS[kind](tmp_path / "there" / "run", run(6))
    before = folder_bytes(tmp_path / "there")
    results = mend(path)
    assert not any(r.lost or r.written_anew for r in results)
    after = folder_bytes(tmp_path / "there")
    if kind == "mcap, two files":  # which had no metadata.yaml
        after.pop("metadata.yaml")
    assert after == before
    mend(path, tmp_path / "copy")
    copied = folder_bytes(tmp_path / "copy")
    for name, data in before.items():
        assert copied[name] == data, name


@pytest.mark.parametrize("compression", CompressionType)
def test_a_cut_foreign_bag(compression: CompressionType, tmp_path: Path) -> None:
    """JSON, protobuf, IDL and channels without schema keep their names, encodings, and each byte."""
    path = tmp_path / "run.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, compression=compression, chunk_size=2000)
        writer.start(profile="x-cell", library="somebody")
        writer.add_attachment(5, 7, "notes.txt", "text/plain", b"spare gripper")
        writer.add_metadata("cell", {"operator": "night shift"})
        writer.add_metadata("cell", {"operator": "day shift"})
        schemas = [
            writer.register_schema(JOINTS, "ros2msg", definition(JOINTS).encode()),
            writer.register_schema(JOINTS, "ros2idl", idl(JOINTS).encode()),
            writer.register_schema("foxglove.Joints", "protobuf", b"\x0a\x03abc"),
            writer.register_schema("Joints", "jsonschema", b'{"type": "object"}'),
            0,
        ]
        encodings = ["cdr", "cdr", "protobuf", "json", "json"]
        channels = [
            writer.register_channel(f"/t{k}", encoding, schema, {"offered_qos_profiles": QOS, "by": str(k)})
            for k, (encoding, schema) in enumerate(zip(encodings, schemas, strict=True))
        ]
        rows = [row for row in run(30) if row.topic == "/joint_states"]
        for n, row in enumerate(rows):
            k = n % 5
            data = cdr(row) if k < 2 else b'{"x": %d}' % n
            writer.add_message(channels[k], row.time, data, row.time - 5, n)
        # times are unsigned in the file, and nobody promises sensible ones
        writer.add_message(channels[3], 2**63 + 5, b"{}", 2**64 - 1, 2**32 - 1)
        writer.finish()
    whole = messages(path)
    path.write_bytes(path.read_bytes()[:-300])
    (result,) = mend(path)
    assert result.written_anew
    assert messages(path) == whole
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert (reader.get_header().profile, reader.get_header().library) == ("x-cell", "somebody")
        (note,) = reader.iter_attachments()
        assert (note.name, note.create_time, note.log_time, note.data) == (
            "notes.txt",
            5,
            7,
            b"spare gripper",
        )
        told = [m.metadata["operator"] for m in reader.iter_metadata()]
        assert told == ["night shift", "day shift"]
        chunks = reader.get_summary().chunk_indexes
        names = {CompressionType.NONE: "", CompressionType.LZ4: "lz4", CompressionType.ZSTD: "zstd"}
        assert {c.compression for c in chunks} == {names[compression]}
    assert Bag(path).complete


def test_compressed_messages_stay_compressed(tmp_path: Path) -> None:
    """Compression by message and custom_data are kept; rosbags reads the mended bag as the whole one."""
    rows = run(20)
    path = by_rosbags(tmp_path / "run", rows, MCAP, MESSAGE, {"operator": "night shift", "robot": "cell 4"})
    file = next(path.glob("*.mcap"))
    whole = messages(file)
    file.write_bytes(file.read_bytes()[:-300])
    mend(path)
    assert messages(file) == whole
    told = YAML(typ="safe").load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert told["custom_data"] == {"operator": "night shift", "robot": "cell 4"}
    assert (told["compression_mode"].lower(), told["compression_format"]) == ("message", "zstd")
    with Reader(path) as reader:
        read = [(c.topic, t, bytes(d)) for c, t, d in reader.messages()]
    assert sorted(read) == sorted((row.topic, row.time, cdr(row)) for row in rows)


def test_a_file_that_is_missing_is_said(tmp_path: Path) -> None:
    """metadata.yaml that lists a file which is not there is written anew, and the loss is said."""
    path = by_rosbags(tmp_path / "run", run(4), MCAP)
    described = path / "metadata.yaml"
    name = next(path.glob("*.mcap")).name
    described.write_text(described.read_text().replace(f"  - {name}\n", f"  - {name}\n  - gone_1.mcap\n"))
    assert "gone_1.mcap" in str(Bag(path).damages[0])
    results = mend(path)
    assert ["gone_1.mcap" in str(r.lost) for r in results] == [False, True]
    assert Bag(path).complete


def test_a_damaged_database_is_not_touched(tmp_path: Path) -> None:
    """sqlite3 mends its own files better than we could: it is said how."""
    path = KINDS["rosbag2, sqlite3"](tmp_path / "run", run(60))
    file = next(path.glob("*.db3"))
    data = bytearray(file.read_bytes())
    data[8192:16384] = bytes(8192)
    file.write_bytes(bytes(data))
    with pytest.raises(BagError, match=r"sqlite3 .*\.recover"):
        mend(path)
    assert file.read_bytes() == bytes(data)


def test_what_could_not_be_read_back_is_not_put_in_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the other reader finds something else the bag stays as it was."""
    path = by_mcap(tmp_path / "run.mcap", run(5, t0=T0))
    path.write_bytes(path.read_bytes()[:-300])
    before = path.read_bytes()
    monkeypatch.setattr("flexsim.bag.mend.read_back", lambda _: 1)
    with pytest.raises(BagError, match="left as it was"):
        mend(path)
    assert folder_bytes(tmp_path) == {"run.mcap": before}
