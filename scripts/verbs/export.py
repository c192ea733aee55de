"""`flexsim export`: the signals of a bag or a run for other tools."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.report import print_json, print_table, say

if TYPE_CHECKING:
    from ..bag import Bag

FORMATS = (".csv", ".npz", ".parquet")


@click.command()
@click.argument("source", metavar="BAG|RUN.npz", type=click.Path())
@click.argument("topics", nargs=-1, metavar="[TOPIC]...")
@click.option("-o", "--output", type=click.Path(), required=True, metavar="FILE|FOLDER",
              help="FILE.csv or FILE.parquet of one topic, FILE.npz of several; a FOLDER gets one"
                   " file a topic.")  # fmt: skip
@click.option("--format", "kind", type=click.Choice(["csv", "parquet"]), default="csv", show_default=True,
              help="Of the files in a FOLDER.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(source: str, topics: tuple[str, ...], output: str, kind: str, as_json: bool) -> None:
    """Write the signals of a bag, or of a run that `flexsim simulate` saved, as tables.

    TOPIC is a topic's name, or a pattern such as '/door/*'; without one, all are written. A row is a
    message; t is its own time, or that of receipt since the bag's beginning where it bears none.
    Joint states have a column a joint, such as joint_1/effort, which `simulate --torque` reads.

    \b
    Example:
      flexsim export run /joint_states -o joints.csv
      flexsim export run -o tables --format parquet
      flexsim export run -o signals.npz
    """
    target = Path(output)
    if target.exists():
        raise click.ClickException(f"{target} exists already; name another file or remove it")
    if not target.absolute().parent.is_dir():
        raise click.ClickException(f"{target.parent} does not exist; make it first")
    from ..comparison.saved_run import is_saved

    if is_saved(Path(source)):
        if topics:
            raise click.UsageError("topics can be chosen of a bag; a saved run is written whole.")
        found = of_run(Path(source), target)
    else:
        from ..bag import Bag

        bag = Bag(source)
        bag.needs_messages()
        found = of_bag(bag, topics, target, kind)
    if as_json:
        print_json(found)
    else:
        rows = [[file, what["topic"], what["rows"], what["columns"]] for file, what in found["files"].items()]
        print_table(f"{source} is written", ["file", "topic", "rows", "columns"], rows)
        for topic, why in found["left_out"].items():
            say(f"{topic}: not written, {why}")
    if not found["files"]:
        raise click.ClickException("nothing could be written")


def of_bag(bag: Bag, topics: tuple[str, ...], target: Path, kind: str) -> dict[str, Any]:
    """Write topics of a bag; returns what was written."""
    from ..bag import BagError
    from ..bag.topics import chosen
    from ..signals.written import Signals, write_csv, write_numpy, write_parquet

    names = chosen(bag, topics, ())
    if target.suffix in (".csv", ".parquet") and len(names) != 1:
        raise click.UsageError(
            f"a {target.suffix} holds one topic, and these are {len(names)}: {', '.join(names)}; name one, or"
            " give a folder"
        )
    signals: dict[str, Signals] = {}
    left_out = {}
    for name in names:
        try:
            signals[name] = Signals(bag, name)
        except BagError as problem:
            left_out[name] = str(problem)
    found: dict[str, Any] = {"source": str(bag.path), "files": {}, "left_out": left_out}
    if not signals:
        return found

    def told(file: Path, topic: str, rows: int) -> None:
        found["files"][str(file)] = {"topic": topic, "rows": rows, "columns": len(signals[topic].columns)}

    if target.suffix == ".npz":
        part = unfinished(target)
        rows = write_numpy(signals, part)
        part.replace(target)
        columns = sum(len(s.columns) for s in signals.values())
        found["files"][str(target)] = {
            "topic": ", ".join(signals), "rows": sum(rows.values()), "columns": columns
        }  # fmt: skip
        return found
    single = target.suffix in FORMATS
    ending = target.suffix if single else f".{kind}"
    if not single:
        target.mkdir()
    taken: set[str] = set()
    for topic, one in signals.items():
        file = target if single else target / f"{file_name(topic, taken)}{ending}"
        part = unfinished(file)
        try:
            if ending == ".csv":
                with part.open("w", newline="", encoding="utf-8") as stream:
                    rows_written = write_csv(one, stream)
            else:
                rows_written = write_parquet(one, part)
            part.replace(file)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
        told(file, topic, rows_written)
    return found


def of_run(path: Path, target: Path) -> dict[str, Any]:
    """Write the arrays of a saved run that have a value a sample; returns what was written."""
    import csv

    import numpy as np

    from ..comparison.saved_run import arrays_of

    if target.suffix not in (".csv", ".parquet"):
        raise click.UsageError("a saved run is an .npz already; give a .csv or .parquet to write")
    arrays = arrays_of(path)
    if "time" not in arrays:
        raise click.ClickException(f"{path} is not a run that flexsim simulate --save wrote")
    count = len(arrays["time"])
    columns: dict[str, Any] = {"t": arrays["time"]}
    left_out = {}
    joints = [str(name) for name in arrays.get("joint_names", ())]
    for name, values in arrays.items():
        if name == "time":
            continue
        if values.ndim == 0 or len(values) != count:
            left_out[name] = "it has no value a sample"
        elif values.ndim == 1:
            columns[name] = values
        else:
            flat = values.reshape(count, -1)
            by_joint = joints if flat.shape[1] == len(joints) else None
            for k in range(flat.shape[1]):
                place = ",".join(map(str, np.unravel_index(k, values.shape[1:])))
                columns[f"{by_joint[k]}/{name}" if by_joint else f"{name}[{place}]"] = flat[:, k]
    part = unfinished(target)
    if target.suffix == ".csv":
        with part.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(columns)
            writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    else:
        import pyarrow
        from pyarrow import parquet

        parquet.write_table(pyarrow.table(dict(columns)), part)
    part.replace(target)
    files = {str(target): {"topic": "", "rows": count, "columns": len(columns)}}
    return {"source": str(path), "files": files, "left_out": left_out}


def unfinished(file: Path) -> Path:
    """Return where a file is written until it is whole."""
    return file.with_name(f".{file.name}.{os.getpid()}.part")


def file_name(topic: str, taken: set[str]) -> str:
    """Return a file's name for a topic; never another folder's, nor one that is taken."""
    stem = re.sub(r"[^\w.-]+", "_", topic.strip("/"), flags=re.ASCII).lstrip(".")[:120] or "topic"
    name, k = stem, 1
    while name in taken:
        k += 1
        name = f"{stem}_{k}"
    taken.add(name)
    return name
