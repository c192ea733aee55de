"""`flexsim sweep`: many runs of one scene, and what they say together."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.output_file import OutputFile
from ..terminal.report import print_json, print_table, say

if TYPE_CHECKING:
    from ..sweep.answer import Answer
    from ..sweep.campaign import Campaign
    from ..sweep.cluster import Cluster
    from ..sweep.engine import Processes
    from ..sweep.runs import SceneRun
    from ..sweep.study_file import Study

MOST_WORKERS = 1000


@click.command()
@click.argument("files", metavar="STUDY.yaml", type=click.Path(), nargs=-1, required=True)
@click.option("-o", "--output", type=OutputFile(".sqlite"), metavar="TABLE.sqlite",
              help="The table of rows, gone on with if it is there; STUDY.sqlite if not given.")  # fmt: skip
@click.option("--workers", type=click.IntRange(1, MOST_WORKERS), metavar="N",
              help="Processes; as many as there are cores if not given.")  # fmt: skip
@click.option(
    "--cluster", metavar="tcp://HOST:PORT", help="Workers of a Dask scheduler, instead of processes."
)
@click.option("--part", metavar="K/N", help="Run only the K-th of N parts, for an array of jobs; each has its"
                                            " own --output.")  # fmt: skip
@click.option(
    "--merge", is_flag=True, help="Put the rows of several tables, given instead of a study, into one."
)
@click.option("--csv", "csv_file", type=OutputFile(".csv"), metavar="FILE.csv", help="Write the rows.")
@click.option("--report", type=OutputFile(".html"), metavar="FILE.html", help="Write a report with plots.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    files: tuple[str, ...],
    output: str | None,
    workers: int | None,
    cluster: str | None,
    part: str | None,
    merge: bool,
    csv_file: str | None,
    report: str | None,
    as_json: bool,
) -> None:
    """Run a scene many times, as a study asks, and answer it.

    STUDY.yaml says which keys of a robot's or a door's scene vary and how, what is observed, and what is
    asked: a table, probabilities, indices, a Pareto front or a search. Rows lie in a table by what was
    run: stopped or killed, the same command goes on; a row is never run twice.

    \b
    Example:
      flexsim sweep config/studies/door_thickness.yaml
      flexsim sweep config/studies/door_probability.yaml --part 1/2 -o a.sqlite
      flexsim sweep --merge a.sqlite b.sqlite -o c.sqlite
    """
    if merge:
        merged(files, output, as_json, bool(workers or cluster or part or csv_file or report))
        return
    if len(files) != 1:
        raise click.UsageError("Give one study; several tables go with --merge.")
    if workers and cluster:
        raise click.UsageError("--workers are processes here; --cluster has its own.")
    piece = part_of(part)
    path = Path(files[0])
    if not path.is_file():
        raise click.ClickException(f"{path} does not exist; give a study's YAML file")
    if piece != (1, 1) and (csv_file or report):
        raise click.UsageError("--part has no answer yet: give --csv and --report with the merged table.")

    from ..sweep.runs import KNOWN
    from ..sweep.study_file import read_study
    from ..sweep.tasks import Programs, scene_run, tasks_of

    study = read_study(path, KNOWN)
    if study.ask == "search" and piece != (1, 1):
        raise click.UsageError("--part: a search's next rows depend on its last ones; it has no parts.")
    work = scene_run(study)

    from ..sweep.answer import answered, refuse
    from ..sweep.campaign import Campaign
    from ..sweep.table import Table, write_csv

    refuse(study)
    depends = Programs(study.kind)()
    table_path = Path(output or f"{path.name.split('.')[0]}.sqlite")
    with Table(table_path) as table, engine_of(work, workers, cluster) as engine:
        campaign = Campaign(table, engine, lambda some: tasks_of(work, study.vary, some, depends), piece)
        answer = answered(study, campaign.rows)
    found = figures(study, campaign, answer) | {"table": str(table_path)}
    if csv_file:
        rows = [row for row in answer.rows if row is not None]
        write_csv(answer.points, rows, [one.key for one in study.vary], list(study.observe), Path(csv_file))
        found["csv"] = csv_file
    if report:
        from ..sweep.report import write_report

        write_report(study, answer, found, Path(report))
        found["report"] = report
    if as_json:
        print_json(found)
    else:
        print_answer(study, found)
    if answer.whole and found["rows"] == found["failed"]:  # of a part it may be chance
        raise click.ClickException(f"every row failed; the first: {found['reasons'][0]['reason']}")
    if study.ask == "search" and found["answer"]["found"] is None:
        raise click.ClickException(found["answer"]["how"])


def engine_of(work: SceneRun, workers: int | None, cluster: str | None) -> Processes | Cluster:
    """Where rows are run."""
    if cluster is None:
        from ..sweep.engine import Processes

        return Processes(work, workers or len(os.sched_getaffinity(0)))
    from ..sweep.cluster import Cluster
    from ..sweep.tasks import Programs

    return Cluster(work, cluster, Programs(work.kind))


def part_of(words: str | None) -> tuple[int, int]:
    """Read K/N."""
    if words is None:
        return 1, 1
    first, slash, second = words.partition("/")
    if not (slash and first.isdecimal() and second.isdecimal() and 1 <= int(first) <= int(second)):
        raise click.UsageError(f"--part {words}: give K/N, K from 1 to N, such as 1/4")
    return int(first), int(second)


def merged(files: tuple[str, ...], output: str | None, as_json: bool, others: bool) -> None:
    """Merge tables."""
    if output is None or others:
        raise click.UsageError("--merge takes tables and -o TABLE.sqlite, nothing else.")
    from ..sweep.table import merge

    if any(Path(name).resolve() == Path(output).resolve() for name in files):
        raise click.UsageError(f"{output} is among the tables to be merged; give another -o.")
    came = merge([Path(name) for name in files], Path(output))
    if as_json:
        print_json({"table": output, "added": came.added, "had": came.had, "studies": came.studies})
        return
    say(f"{output}: {came.added} rows added{f', {came.had} were there already' if came.had else ''}")
    if came.studies > 1:
        say(f"they are of {came.studies} studies at least, which vary other keys; each finds its own rows")


def figures(study: Study, campaign: Campaign, answer: Answer) -> dict[str, Any]:
    """What a sweep came to."""
    from collections import Counter

    rows = [row for row in answer.rows if row is not None]
    failed = Counter(row.reason for row in rows if row.observed is None)
    warned = Counter(row.warnings[0] for row in rows if row.warnings)
    return {
        "study": study.source,
        "scene": str(study.scene),
        "ask": study.ask,
        "points": len(answer.points),
        "rows": len(rows),
        "ran": campaign.ran,
        "kept": campaign.kept,
        "failed": sum(failed.values()),
        "reasons": [{"reason": reason, "rows": count} for reason, count in failed.most_common(10)],
        "warned": sum(warned.values()),
        "warnings": [{"warning": first, "rows": count} for first, count in warned.most_common(10)],
        "answer": answer.found if answer.whole else None,
    }


def print_answer(study: Study, found: dict[str, Any]) -> None:
    """Print tables."""
    from ..sweep.words import tables

    failed = f", {found['failed']} failed" if found["failed"] else ""
    say(f"{found['rows']} of {found['points']} points{failed}; {found['ran']} rows run now; {found['table']}")
    if found["reasons"]:
        print_table("failed rows", ["rows", "reason"], [[r["rows"], r["reason"]] for r in found["reasons"]])
    if found["warnings"]:
        told = [[w["rows"], w["warning"]] for w in found["warnings"]]
        print_table("rows that came to their end and warn", ["rows", "the first warning of each"], told)
    if found["answer"] is None:
        say("the other parts' rows are missing; merge the tables, and run the study on the merged one")
        return
    for title, columns, rows in tables(study, found["answer"]):
        print_table(title, columns, rows)
    for name in ("csv", "report"):
        if name in found:
            say(f"{name}: {found[name]}")
