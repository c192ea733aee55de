"""`flexsim sweep`: from a study to rows, parts, answers; a sentence for each study that can't be meant."""

from __future__ import annotations

import csv
import json
import signal
import time
from pathlib import Path

import pytest
from flexsim.sweep.table import Table
from processes import Background, command, flexsim, flexsim_here, ros_environment
from sweep_work import Here

ROOT = Path(__file__).parents[2]
THICKNESS = "leaf.layers.1.thickness"
COLUMN = ROOT / "config" / "thesis_door_column.yaml"
STUDY = """
scene: {scene}
set: {{mesh.layers: [1, 20, 1], criteria.standard: ftp_a}}
duration: 3600
vary:
  leaf.layers.1.thickness: {{from: 0.04, to: 0.08, count: {count}}}
  ambient: [20.0, {ambient}]
observe:
  mean: max(unexposed_mean) - initial(unexposed_mean)
  minutes: held('insulation')
  a60: awarded('A-60')
  late: at(unexposed_mean, 1800)
  failed: failure_time('mean temperature rise')
ask: {ask}
"""


def study(
    folder: Path, ask: str = "table", count: int = 2, ambient: str = "25.0", name: str = "study"
) -> Path:
    path = folder / f"{name}.yaml"
    path.write_text(STUDY.format(scene=COLUMN, ask=ask, count=count, ambient=ambient))
    return path


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows are run in this process: to begin a worker takes longer than they do."""
    monkeypatch.setattr("flexsim.verbs.sweep.engine_of", lambda work, *_: Here(work))


def swept(*words: object, cwd: Path) -> dict:
    """A sweep's JSON."""
    done = flexsim_here("sweep", *words, "--json", cwd=cwd)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.slow
def test_rows_are_what_single_runs_give_and_are_run_once(tmp_path: Path) -> None:
    """Each row is a run by hand to the bit; the same command runs nothing, a finer grid only what is new."""
    from thermal_node import load_scene, simulate

    found = swept(study(tmp_path), "--workers", 1, "--csv", "rows.csv", "--report", "page.html", cwd=tmp_path)
    assert (found["points"], found["ran"], found["failed"]) == (4, 4, 0)
    rows = list(csv.DictReader((tmp_path / "rows.csv").open()))
    assert [(r["leaf.layers.1.thickness"], r["ambient"]) for r in rows] == [
        ("0.04", "20.0"), ("0.04", "25.0"), ("0.08", "20.0"), ("0.08", "25.0"),
    ]  # fmt: skip
    for row in rows[1:3]:
        overrides = {"mesh.layers": [1, 20, 1], THICKNESS: float(row[THICKNESS]),
                     "ambient": float(row["ambient"]), "criteria.standard": "ftp_a"}  # fmt: skip
        run = simulate(load_scene(COLUMN, overrides), 3600.0)
        mean = run.probes["unexposed_mean"]
        assert float(row["mean"]) == mean.max() - mean[0]
        assert float(row["late"]) == mean[run.time == 1800.0][0]
        assert row["a60"] == str(run.verdict.startswith("A-60 by")).lower()
        failure = run.criteria[0].time_of_failure
        assert float(row["failed"]) == (float("inf") if failure is None else failure)
    assert {row["a60"] for row in rows} == {"true", "false"}
    page = (tmp_path / "page.html").read_text()
    assert page.count("<svg ") == 5 and "leaf.layers.1.thickness" in page

    table = (tmp_path / "study.sqlite").read_bytes()
    again = swept(study(tmp_path), "--csv", "again.csv", cwd=tmp_path)
    assert (again["ran"], again["kept"]) == (0, 4)
    assert (tmp_path / "study.sqlite").read_bytes() == table
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "rows.csv").read_bytes()
    finer = swept(study(tmp_path, count=3), "--workers", 1, cwd=tmp_path)
    assert (finer["points"], finer["ran"], finer["kept"]) == (6, 2, 4)


@pytest.mark.usefixtures("alone")
def test_parts_come_to_the_whole_and_failures_are_rows(tmp_path: Path) -> None:
    """Two parts merged give the table of one sweep; an impossible value is a row with its reason."""
    path = study(tmp_path, count=2, ambient="-500.0")
    whole = swept(path, "-o", "whole.sqlite", "--workers", 1, cwd=tmp_path)
    assert (whole["rows"], whole["failed"]) == (4, 2)
    assert whole["reasons"][0]["reason"].startswith("thesis_door_column.yaml, override: ambient: ")
    assert whole["reasons"][0]["rows"] == 2
    for k in (1, 2):
        part = swept(path, "--part", f"{k}/2", "-o", f"{k}.sqlite", "--workers", 1, cwd=tmp_path)
        assert (part["points"], part["ran"], part["answer"]) == (4, 2, None)
    assert swept("--merge", "1.sqlite", "2.sqlite", "-o", "both.sqlite", cwd=tmp_path)["added"] == 4
    with (
        Table(tmp_path / "whole.sqlite", write=False) as one,
        Table(tmp_path / "both.sqlite", write=False) as two,
    ):
        assert one.rows() == two.rows()
    found = swept(path, "-o", "both.sqlite", cwd=tmp_path)
    assert found["ran"] == 0 and found["answer"] == whole["answer"]


def test_the_thesis_door_s_thickness_is_that_of_bisection_by_hand(tmp_path: Path) -> None:
    """How thick the wool must be for A-60 by insulation, by one command and by a loop."""
    from thermal_node import load_scene, simulate

    found = swept(ROOT / "config/studies/door_thickness.yaml", "--workers", 1, cwd=tmp_path)["answer"]
    low, high = 0.03, 0.09
    while high - low > 1e-5:
        middle = 0.5 * (low + high)
        run = simulate(load_scene(COLUMN, {"leaf.layers.1.thickness": middle}), 3600.0)
        low, high = (low, middle) if run.verdict.startswith("A-60 by insulation") else (middle, high)
    assert found["found"] == {"leaf.layers.1.thickness": high}


def test_ctrl_c_ends_it_and_it_goes_on(tmp_path: Path) -> None:
    """130, every row that was over is kept, and no lock is left."""
    path = study(tmp_path, count=400)
    sweep = Background(command("sweep", path, "--workers", 1), ros_environment(), tmp_path, cwd=tmp_path)
    begun = time.monotonic()
    while rows_in(tmp_path / "study.sqlite") < 3:
        assert time.monotonic() - begun < 120.0
        time.sleep(0.02)
    assert sweep.end(signal.SIGINT) == 130
    kept = rows_in(tmp_path / "study.sqlite")
    assert 3 <= kept < 800
    with Table(tmp_path / "study.sqlite") as table:
        assert len(table) == kept


def rows_in(path: Path) -> int:
    try:
        with Table(path, write=False) as table:
            return len(table)
    except ValueError:
        return 0


@pytest.mark.slow
def test_a_robot_s_rows_are_what_single_runs_give(tmp_path: Path) -> None:
    """The figures of `flexsim simulate`, to the bit; as plain Python, which compiles nothing."""
    plain = {**ros_environment(), "NUMBA_DISABLE_JIT": "1"}
    scene = ROOT / "config" / "simple_pendulum.yaml"
    (tmp_path / "robot.yaml").write_text(f"""
scene: {scene}
duration: 0.005
vary:
  gravity.1: [-20.0]
  links.link_1.beam.depth: {{scale: [1.0]}}
observe:
  bent: max(deflection())
  angle: final(position('joint_1'))
  high: final(y('link_1'))
""")
    done = flexsim("sweep", "robot.yaml", "--workers", 1, "--csv", "rows.csv", cwd=tmp_path, env=plain)
    assert done.returncode == 0, done.stderr
    for row in csv.DictReader((tmp_path / "rows.csv").open()):
        words = ["simulate", scene, "-d", 0.005, "--set", f"gravity.1={row['gravity.1']}", "--json"]
        alone = json.loads(flexsim(*words, cwd=tmp_path, env=plain).stdout)
        assert float(row["bent"]) == alone["tip_deflection_peak"] > 0.0
        assert float(row["angle"]) == alone["joint_position"][0]
        assert float(row["high"]) == alone["tips"]["link_1"][1]


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("vary:", "varry:", "varry: unknown key; did you mean 'vary'?"),
        ("scene: ", "scene: nowhere/", "no such file"),
        (
            "leaf.layers.1.thickness",
            "leaf.layers.1.thikness",
            "thikness: unknown key; did you mean 'thickness'?",
        ),
        ("leaf.layers.1.thickness", "leaf.layers.7.thickness", "no '7' in leaf.layers"),
        ("[20.0, 25.0]", "[2026-01-01]", "vary: holds a date or the like"),
        ("from: 0.04", "from: 0.4", "0.4 is not below 0.08"),
        ("count: 2", "count: 2, steps: 3", "'steps' is not known beside from"),
        ("ask: table", "ask: morris", "has a count, which is for a grid, not morris"),
        ("criteria.standard: ftp_a", "criteria.standard: ftp", "criteria.standard"),
        ("max(unexposed_mean)", "maxx(unexposed_mean)", "did you mean 'max'?"),
        ("max(unexposed_mean)", "__import__('os')", "'__import__' is not known"),
        ("max(unexposed_mean)", "max(bow)", "bow: the scene computes no deformation"),
        ("observe:", "observed:", "observed: unknown key; did you mean 'observe'?"),
        ("  mean:", "  max 1:", "is no name"),
        ("  mean:", "  and:", "is no name"),
        ("ask: table", "ask: tabel", "did you mean 'table'?"),
        ("ask: table", "ask: {sobol: {of: meen}}", "'meen' is not observed; did you mean 'mean'?"),
        ("ask: table", "ask: {sobol: {resample: 9}}", "unknown key; did you mean 'resamples'?"),
        ("ask: table", "ask: {monte_carlo: {confidence: 95}}", "give a number from 0.5 to 0.9999"),
        ("ask: table", "ask: {search: {so_that: a60}}", "give minimise or maximise"),
        ("ask: table", "ask: {search: {minimise: men}}", "did you mean 'mean'?"),
        ("ask: table", "ask: {search: {minimise: mean, tolerance: 1}}", "tolerance is for bisection"),
        ("ask: table", "ask: {pareto: {minimise: mean}}", "fewer than two aims"),
        ("ask: table", "ask: {morris: {levels: 5}}", "give an even number"),
        ("ask: table", "ask: {sobol: {of: []}}", "is an empty list"),
        ("ask: table", "ask: {morris: {seed: 3}}", "morris.seed: unknown key"),
        ("ask: table", "ask: {search: {minimise: mean}}\nsample: {count: 9}", "none has; leave it out"),
        ("ask: table", "sample: {seed: 5}", "a grid has as many rows as its levels make"),
        ("  mean:", "  ambient:", "is the name of something that varies"),
        ("  mean:", "  failure:", "or of a column"),
        ("ask: table", "sample: {method: lhs}", "give grid, random, latin_hypercube, sobol"),
        ("ask: table", "sample: {count: 5}", "a grid has as many rows as its levels make"),
        ("ask: table", "sample: {method: random, seed: -1}", "give a whole number from 0"),
        (
            "ask: table",
            "correlation: [[ambient, leaf.layers.1.thickness, 0.5]]",
            "inputs that have distributions",
        ),
        ("duration: 3600", "duration: -5", "duration: is -5"),
        ("set: {", "set: {ambient: 3, ", "is in set also"),
    ],
)
def test_studies_that_cant_be_meant(old: str, new: str, sentence: str, tmp_path: Path) -> None:
    """One sentence, exit code 1, and no row."""
    path = study(tmp_path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    done = flexsim_here("sweep", path, "--workers", 1, cwd=tmp_path)
    assert done.returncode == 1, done.stdout
    assert sentence in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert rows_in(tmp_path / "study.sqlite") == 0
    # Only a row that was run has needed a table.
    assert old == "max(unexposed_mean)" or not list(tmp_path.glob("*.sqlite*"))


def test_numbers_without_a_point_are_numbers(tmp_path: Path) -> None:
    """YAML takes 4e-2 for a word."""
    from flexsim.sweep.runs import KNOWN
    from flexsim.sweep.study_file import read_study

    path = study(tmp_path, "{search: {minimise: mean, tolerance: 1e-5}}")
    path.write_text(path.read_text().replace("from: 0.04", "from: 4e-2"))
    read = read_study(path, KNOWN)
    assert (read.vary[0].of, read.options["tolerance"]) == ((0.04, 0.08), 1e-5)


def test_a_grid_needs_levels(tmp_path: Path) -> None:
    path = study(tmp_path, "table\nsample: {method: grid}")
    path.write_text(path.read_text().replace(", count: 2", ""))
    done = flexsim_here("sweep", path, cwd=tmp_path)
    assert done.returncode == 1
    assert "study.yaml:6: vary.leaf.layers.1.thickness: has no count, which a grid needs" in done.stderr


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["nowhere.yaml"], 1, "nowhere.yaml does not exist"),
        (["study.yaml", "--part", "3/2"], 2, "give K/N, K from 1 to N"),
        (["study.yaml", "--part", "1/2", "--csv", "a.csv"], 2, "--part has no answer yet"),
        (["study.yaml", "-o", "study.yaml"], 2, "does not end in .sqlite"),
        (["study.yaml", "other.yaml"], 2, "Give one study"),
        (["study.yaml", "--cluster", "tcp://127.0.0.1:9", "--workers", "2"], 2, "--cluster has its own"),
        (["--merge", "a.sqlite"], 2, "-o TABLE.sqlite"),
        (["--merge", "a.sqlite", "-o", "a.sqlite"], 2, "is among the tables"),
        (["--merge", "a.sqlite", "-o", "b.sqlite"], 1, "a.sqlite: no such table"),
        (["search.yaml", "--part", "1/2"], 2, "it has no parts"),
        (["study.yaml", "-o", "text.sqlite"], 1, "is no table of a sweep"),
    ],
)
def test_mistakes(words: list[str], code: int, sentence: str, tmp_path: Path) -> None:
    study(tmp_path)
    study(tmp_path, "{search: {minimise: mean}}", name="search")
    (tmp_path / "text.sqlite").write_text("no database " * 100)
    done = flexsim_here("sweep", *words, cwd=tmp_path)
    assert (done.returncode, sentence in done.stderr) == (code, True), done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.usefixtures("alone")
def test_where_every_row_fails_the_work_has_failed(tmp_path: Path) -> None:
    """Of a part it may be chance, such as every second row."""
    path = study(tmp_path)
    path.write_text(path.read_text().replace("[20.0, 25.0]", "[-500.0, -600.0]"))
    done = flexsim_here("sweep", path, "--workers", 1, cwd=tmp_path)
    assert done.returncode == 1
    assert "every row failed; the first:" in done.stderr and "ambient" in done.stderr
