"""What lies at a path: which files are a bag's, how they are stored, and what else it may be instead."""

from __future__ import annotations

import re
import shutil
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..terminal.plain import plain
from .errors import BagError
from .metadata import NAME, Metadata, read_metadata

MCAP, SQLITE, ZSTD = b"\x89MCAP0\r\n", b"SQLite format 3\0", b"\x28\xb5\x2f\xfd"
ENDINGS = (".mcap", ".db3")
PACKED = ".zstd"
DESCRIPTIONS = (".yaml", ".yml")
# What a file is that is no bag of ROS 2, by how it begins, and what to do with it.
FOREIGN = {
    b"#ROSBAG V": "a bag of ROS 1. Convert it: rosbags-convert --src {file} --dst {stem}, of pip's rosbags",
    b"ULog\x01\x12\x35": "a ULog of PX4, which is no bag. Convert it: pip install pyulog; ulog2csv {file},"
    " or ulog2rosbag of an ROS 1",
    b"\x8e\xad\xe8": "an RPM package, which is no bag",
    b"PK\x03\x04": "a ZIP archive. Unpack it; the bag is the folder with metadata.yaml within",
    b"\x1f\x8b": "compressed by gzip. Unpack it: gunzip {file}, or tar xf {file}",
    b"LZ4\x00": "compressed by LZ4. Unpack it first",
    b"\x89HDF": "an HDF5 file, which is no bag",
    b"RRF2": "a rerun recording, which is no bag. Open it: rerun {file}",
}
# A packed file that grows beyond this is none that a recorder wrote: bytes, and times its own size.
LEAST_SWOLLEN, MOST_SWOLLEN = 1 << 28, 300
PIECE = 1 << 20


@dataclass
class Opened:
    """A bag's files.

    Attributes
    ----------
    folder : where the bag lies
    files : those that are read, in order; of a packed one its unpacked copy
    names : of each file, its own
    missing : files that metadata.yaml lists and that are not there
    unlisted : files that are there and that metadata.yaml does not list; they are not read
    metadata : what metadata.yaml says, or None
    why_no_metadata : why metadata.yaml can't be read; "" where it could, or isn't there
    """

    folder: Path
    files: list[Path] = field(default_factory=list)
    names: list[Path] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    unlisted: list[Path] = field(default_factory=list)
    metadata: Metadata | None = None
    why_no_metadata: str = ""
    _unpacked: tempfile.TemporaryDirectory[str] | None = None

    @property
    def packed(self) -> bool:
        """Whether some of the files are compressed as a whole."""
        return self.files != self.names

    def unpack(self) -> Opened:
        """Unpack the files that are compressed as a whole, for as long as this lives."""
        for name in self.names:
            if begin(name).startswith(ZSTD):
                if self._unpacked is None:
                    self._unpacked = tempfile.TemporaryDirectory(prefix="flexsim_bag_")
                plain_name = name.name.removesuffix(PACKED).removesuffix(".zst")
                self.files.append(
                    unpacked(name, Path(self._unpacked.name) / f"{len(self.files)}_{plain_name}")
                )
            else:
                self.files.append(name)
        return self


def find(path: Path) -> Opened:
    """Find a bag's files.

    Parameters
    ----------
    path : Path
        A bag's folder, its metadata.yaml, or one of its files.

    Raises
    ------
    BagError
        There is no bag: what lies there instead, and what to do with it.
    """
    if not path.exists():
        raise BagError(f"{path} does not exist")
    if path.is_file() and path.suffix in DESCRIPTIONS:
        read_metadata(path)  # says what is wrong, if this is no description of a bag
        path = path.parent
    if path.is_dir():
        return of_folder(path)
    if not path.is_file():
        raise BagError(f"{path} is neither a file nor a folder")
    found = Opened(path.parent, names=[path])
    beside = path.parent / NAME
    if beside.is_file():
        try:
            metadata = read_metadata(beside)
        except BagError:
            metadata = None
        if metadata is not None and path.name in {Path(name).name for name in metadata.files}:
            found.metadata = metadata
    return sound(path, found)


def of_folder(folder: Path) -> Opened:
    """Find the files of a bag's folder."""
    found = Opened(folder)
    there = bag_files(folder)
    if (folder / NAME).is_file():
        try:
            found.metadata = read_metadata(folder / NAME)
        except BagError as problem:
            found.why_no_metadata = str(problem)
    if found.metadata is None:
        found.names = there
    else:
        for name in found.metadata.files:
            file = listed(folder, name)
            if file is None:
                found.missing.append(plain(name))
            else:
                found.names.append(file)
        # Whoever renamed all the files still has a bag.
        if not found.names and there and found.missing:
            found.names = there
        found.unlisted = [file for file in there if file not in found.names]
    if not found.names:
        raise BagError(nothing_in(folder, found))
    return sound(folder, found)


def sound(path: Path, found: Opened) -> Opened:
    """Return what was found, unpacked; raises BagError where a file is something else."""
    for file in found.names:
        start = begin(file)
        for mark, what in FOREIGN.items():
            if start.startswith(mark):
                raise BagError(f"{file} is " + what.format(file=file, stem=file.stem))
        known = start.startswith((MCAP, SQLITE, ZSTD)) or not start
        if not known and len(found.names) == 1 and file.suffix not in ENDINGS:
            raise BagError(
                f"{file} is not an MCAP file, nor an sqlite3 database: it is no bag. Give a bag's folder, its"
                f" {NAME}, or an .mcap or .db3 file"
            )
    return found.unpack()


def listed(folder: Path, name: str) -> Path | None:
    """Return a file that metadata.yaml lists; None where it isn't there. Never one outside the folder."""
    parts = Path(name).parts
    if not parts or Path(name).is_absolute() or ".." in parts:
        return None
    # rosbag2 once wrote the bag's own folder before the name, and lists packed files without their ending.
    for relative in (Path(name), Path(parts[-1])):
        for ending in ("", PACKED, ".zst"):
            file = folder / f"{relative}{ending}"
            if file.is_file():
                return file
    return None


def bag_files(folder: Path) -> list[Path]:
    """Return the files of a folder that are named as a bag's, in the order of their numbers."""
    found: dict[str, Path] = {}
    for file in folder.iterdir():
        name = file.name.removesuffix(PACKED)
        if file.is_file() and name.endswith(ENDINGS) and (name not in found or name == file.name):
            found[name] = file
    return [found[name] for name in sorted(found, key=file_number)]


def file_number(name: str) -> tuple[int, str]:
    """Return a split file's number, so that run_10 comes behind run_9."""
    last = re.search(r"_(\d{1,9})$", name.rpartition(".")[0])
    return (int(last[1]) if last else 0, name)


def nothing_in(folder: Path, found: Opened) -> str:
    """Say why a folder is no bag."""
    if found.missing:
        return f"{folder} has no file of its bag: its {NAME} lists {', '.join(found.missing)}"
    if found.metadata is not None:
        return f"{folder} holds a {NAME} that lists no file: nothing was recorded"
    if found.why_no_metadata:
        return f"{found.why_no_metadata}; and it holds no .mcap file and no .db3 file"
    for file in sorted(folder.iterdir())[:100]:
        start = begin(file) if file.is_file() else b""
        for mark, what in FOREIGN.items():
            if start.startswith(mark):
                return f"{folder} holds no bag; {file.name} in it is " + what.format(
                    file=file, stem=file.stem
                )
    nothing = "" if any(folder.iterdir()) else ", nor anything else"
    return f"{folder} is not a bag: it holds no .mcap file and no .db3 file{nothing}"


def begin(file: Path) -> bytes:
    """Return how a file begins."""
    with file.open("rb") as stream:
        return stream.read(16)


def unpacked(file: Path, target: Path) -> Path:
    """Unpack a file; what can be unpacked of one that is cut off. Raises BagError where it swells."""
    import zstandard

    most = max(LEAST_SWOLLEN, MOST_SWOLLEN * file.stat().st_size)
    most = min(most, shutil.disk_usage(target.parent).free - LEAST_SWOLLEN)
    size = 0
    with file.open("rb") as source, target.open("wb") as into:
        reader = zstandard.ZstdDecompressor().stream_reader(source, read_across_frames=True)
        try:
            while piece := reader.read(PIECE):
                size += len(piece)
                if size > most:
                    raise BagError(
                        f"{file} holds more than {most / 1e6:.0f} MB, as no recorder writes, or for"
                        f" which {target.parent} has no room. Unpack it: zstd -d"
                    )
                into.write(piece)
        except zstandard.ZstdError:
            pass  # cut off or damaged: what lies before is read, and found to have no end
    return target


def described(opened: Opened) -> dict[str, Any]:
    """Return what is to be known of how a bag is stored, for --json."""
    told = opened.metadata
    return {
        "storage": sorted({"sqlite3" if is_sqlite(file) else "mcap" for file in opened.files}),
        "compression": "file" if opened.packed else "message" if told and told.per_message else "",
        "missing": opened.missing,
        "not_read": [file.name for file in opened.unlisted],
        "custom_data": told.custom_data if told else {},
    }


def is_sqlite(file: Path) -> bool:
    """Say whether a file is an sqlite3 database."""
    return begin(file).startswith(SQLITE)
