"""`flexsim accuracy`: what it finds is right, what it advises holds, and it goes on where it stopped."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from flexsim.study.choice import Cost, Truth, choose, conditions_said, frontier, quantity, truth_of
from flexsim.study.order import observed_orders
from flexsim.study.point import Measure, Outcome, Reference
from flexsim.study.ringing import ringing
from flexsim.study.robot import RobotStudy
from flexsim.study.scene_text import plain
from flexsim.study.store import Store, StudyError
from flexsim.study.writing import written
from processes import flexsim

from flexsim_node import load_scene

CONFIG = Path(__file__).parents[2] / "config"
PLANAR = CONFIG / "planar_double_pendulum.yaml"
TIP = Measure("tip", "tip position", "mm", 1e3)


def outcome(name: str, error: float, seconds: float, step: float | None = 1e-3) -> Outcome:
    return Outcome(name, name, step or 1e-3, {}, "ok", {"tip": error}, [seconds] * 3, step)


# From rest, by a torque that begins at nothing: the motion is smooth and the step's order shows.
SMOOTH = ("accuracy", PLANAR, "--quick", "-d", 0.2, "--set", "gravity=[0,0,0]", "--sine", "joint_1=1@2",
          "-o", "out")  # fmt: skip

POINTS = [
    outcome("coarse", 2e-3, 0.01),
    outcome("middle", 4e-4, 0.05),
    outcome("beaten", 5e-4, 0.06),
    outcome("fine", 1e-5, 0.3),
    outcome("adaptive", 1e-7, 0.02, None),
    Outcome("broken", "broken", 1e-3, {}, "stopped at 0.1 s"),
]


def test_the_frontier_is_what_nothing_beats_in_both() -> None:
    assert [o.point for o in frontier(POINTS, "tip", 1e-9)] == ["coarse", "adaptive"]
    assert [o.point for o in frontier(POINTS[:4], "tip", 1e-9)] == ["coarse", "middle", "fine"]
    assert [o.point for o in frontier(POINTS[:4], "tip", 4e-4)] == ["coarse", "middle"]


def test_an_effect_left_out_is_not_advised() -> None:
    cheap = outcome("gravity off", 1e-9, 1e-3)
    cheap.effect = True
    assert cheap not in frontier([*POINTS, cheap], "tip", 1e-9)
    assert choose([*POINTS, cheap], TIP, Cost(1000.0), None, 5e-4, 1e-9).outcome is POINTS[1]


def test_the_choice_from_either_side() -> None:
    cost = Cost(1000.0)
    within = choose(POINTS, TIP, cost, None, 5e-4, 1e-9)
    assert within.outcome is POINTS[1]
    assert within.sentence == (
        "For 1 kHz and 0.5 mm in tip position, use middle, step 1 ms: 0.4 mm, 50 µs of each 1 ms (5.0%)."
    )
    best = choose(POINTS, TIP, cost, 200e-6, None, 1e-9)
    assert best.outcome is POINTS[1]
    assert "1 kHz with 20% load (200 µs)" in best.sentence
    none = choose(POINTS, TIP, cost, 200e-6, 1e-4, 1e-9)
    assert none.outcome is None
    assert "nothing will do" in none.sentence
    assert "that accuracy takes 300 µs" in none.sentence
    # below what the reference can tell, the cheaper of two is as good
    assert choose(POINTS, TIP, cost, 1e-3, None, 1e-3).outcome is POINTS[1]


def test_an_error_that_cancels_by_luck_is_not_counted_on() -> None:
    """At 1 ms the curve passes through a small error on its way to that of its mesh."""
    lucky = [outcome("two", 2e-4, 0.01), outcome("two", 4.4e-4, 0.02, 5e-4)]
    lucky[1].point = "two, finer"
    found = choose(lucky, TIP, Cost(1000.0), None, 5e-4, 1e-9)
    assert found.outcome is lucky[0]
    assert "Count on 0.44 mm" in found.sentence
    assert choose([*lucky, *POINTS[:4]], TIP, Cost(1000.0), None, 3e-4, 1e-9).outcome is POINTS[3]


def test_a_control_period_takes_whole_steps() -> None:
    assert Cost(1000.0).of(outcome("short", 0.0, 0.1, 2.5e-4)) == pytest.approx(100e-6)
    assert Cost(1000.0).of(outcome("long", 0.0, 0.1, 4e-3)) == pytest.approx(400e-6)
    assert not Cost(1000.0).serves(POINTS[4])
    assert not Cost(1000.0).serves(outcome("long", 0.0, 0.1, 2e-3))
    assert Cost(1000.0).serves(POINTS[0])
    assert Cost(None).of(POINTS[3]) == pytest.approx(0.3)


def test_quantities() -> None:
    assert quantity("200us", ("us", "ms")) == pytest.approx(2e-4)
    assert quantity("0.5 mm", ("mm",)) == pytest.approx(5e-4)
    for wrong in ("200", "1kg", "-1ms", "nanms", "ms", "1e400ms"):
        with pytest.raises(ValueError, match="give a number and a unit"):
            quantity(wrong, ("us", "ms"))


def test_what_the_reference_cannot_tell_is_not_promised() -> None:
    """A tolerance below the reference's own bound gets the figure and what would tell, not a promise."""
    truth = Truth({"tip": 3e-4}, {}, finer="its steps limit it: --finer 1 halves the steps")
    found = choose(POINTS, TIP, Cost(1000.0), None, 1e-4, 1e-9, truth)
    assert found.outcome is None
    assert not found.told
    assert "can't be told: the reference itself is known to 0.3 mm only. Its steps limit it" in found.sentence
    sure = choose(POINTS, TIP, Cost(1000.0), None, 8e-4, 1e-9, truth)
    assert sure.outcome is POINTS[1]
    assert sure.promise == pytest.approx(7e-4)
    assert "count on 0.7 mm" in sure.sentence
    unsettled = Truth({"tip": math.inf}, {}, finer="give --finer 1")
    for tolerance in (1e-3, None):
        found = choose(POINTS, TIP, Cost(1000.0), 1e-3, tolerance, math.inf, unsettled)
        assert found.outcome is None and "has not settled; give --finer 1" in found.sentence


def of_model(name: str, error: float, seconds: float, model: str) -> Outcome:
    found = outcome(name, error, seconds)
    found.model = model
    return found


def test_the_distance_of_models_counts() -> None:
    """Where erls and co_moving are 1 mm apart, no step of erls is 0.5 mm exact; co_moving is chosen."""
    truth = Truth({"tip": 1e-6, "tip_co_moving": 1e-6}, {"erls": 1.04e-3}, "co_moving")
    cheap, dear = of_model("e", 1e-5, 0.01, "erls"), of_model("c", 1e-5, 0.02, "co_moving")
    assert choose([cheap, dear], TIP, Cost(1000.0), None, 5e-4, 1e-9, truth).outcome is dear
    assert choose([cheap, dear], TIP, Cost(1000.0), None, 2e-3, 1e-9, truth).outcome is cheap
    far = of_model("c", 1e-3, 0.02, "co_moving")
    none = choose([cheap, far], TIP, Cost(1000.0), None, 5e-4, 1e-9, truth)
    assert none.outcome is None
    assert "erls up to 1.04 mm from co_moving" in none.sentence
    # where only the scene's own model was studied the promise is within it, and says so
    alone = choose([cheap], TIP, Cost(1000.0), None, 5e-4, 1e-9, truth)
    assert alone.outcome is cheap
    assert "That is within erls: erls up to 1.04 mm from co_moving" in alone.sentence
    assert "No step brings it within the tolerance" in alone.sentence


def test_a_budget_is_that_of_the_late_steps() -> None:
    """One period in a hundred is late: a budget is kept by the 99th percentile, not by the median."""
    calm, late = outcome("calm", 1e-3, 0.1), outcome("late", 1e-4, 0.1)
    calm.late, late.late = [1.2] * 3, [5.0, 4.0, 9.0]
    found = choose([calm, late], TIP, Cost(1000.0), 200e-6, None, 1e-9)
    assert found.outcome is calm
    assert "p99 120 µs" in found.sentence


def test_conditions_are_said() -> None:
    found = {
        "longer": [
            {"times": 1, "duration": 0.5, "error": 4e-4, "unsure": 1e-6},
            {"times": 2, "duration": 1.0, "error": 6e-1, "unsure": 3e-1},
        ],
        "stopped": "",
        "hopeless": 0.8,
        "nearby": {"begun 0.05 rad or m beside": {"error": 5e-4, "unsure": 1e-6}},
        "alone": {"p50": 2e-5, "p99": 4e-5, "p50_spread": 1e-6, "p99_spread": 2e-6, "busy": 0.1},
    }
    text = " ".join(conditions_said(found, TIP, Cost(1000.0)))
    assert "holds for 500 ms of this motion (0.4 mm); over longer runs: 1 s 600 mm (± 300 mm)" in text
    assert "From 800 ms on no step helps" in text
    assert "begun 0.05 rad or m beside 0.5 mm" in text
    assert "p99 40 µs ± 2 µs" in text
    assert "busy" not in text


def test_ringing_is_heard_as_it_is() -> None:
    t = np.arange(300) * 2e-3
    slow = np.exp(-0.7 * t) * np.cos(2 * np.pi * 8.3 * t + 0.4)
    fast = 0.2 * np.exp(-5.0 * t) * np.sin(2 * np.pi * 31.0 * t)
    signal = np.outer(slow + fast, [1.0, 0.3, 0.0]) + np.array([1.0, 2.0, 3.0])
    assert ringing(signal, 2e-3) == pytest.approx((8.3, 0.7), rel=1e-6)
    assert ringing(signal, 2e-3, near=31.0) == pytest.approx((31.0, 5.0), rel=1e-6)
    with pytest.raises(ValueError, match="nothing rings"):
        ringing(np.outer(np.exp(-t), [1.0, 0.0, 0.0]), 2e-3)


def test_orders_are_those_of_the_curve() -> None:
    points = [
        Outcome(f"{h}", "second", h, {}, "ok", {"time": 3.0 * h * h}, [1.0], h) for h in (4e-3, 2e-3, 1e-3)
    ]
    assert observed_orders(points, "time", 1e-9) == {"second": [2.0, 2.0]}
    assert observed_orders(points, "time", 1e-5) == {"second": [2.0]}


VERSIONS = {"flexsim": "1"}


def test_a_store_goes_on_and_does_not_mix_studies(tmp_path: Path) -> None:
    folder, scene = tmp_path / "s", b"name: a\n"
    with Store(folder, scene) as store:
        store.begin({"list": (1, 2)}, VERSIONS)
        store.keep(POINTS[0])
        store.keep_reference(Reference({"tip": np.eye(3)}, {"tip": math.inf}, "two ways", finer="more"))
        store.keep_conditions("coarse", {"busy": 0.5})
    with (folder / "points.jsonl").open("a") as file:
        file.write('{"point": "half a li')
    with Store(folder, scene) as again:
        again.begin({"list": [1, 2]}, VERSIONS)
        assert list(again.outcomes) == ["coarse"]
        assert again.outcomes["coarse"] == POINTS[0]
        assert again.conditions == {"coarse": {"busy": 0.5}}
        kept = again.reference()
        assert kept is not None
        np.testing.assert_array_equal(kept.arrays["tip"], np.eye(3))
        assert kept.error == {"tip": math.inf}
        assert kept.finer == "more"
        again.keep(POINTS[1])
    with Store(folder, scene) as third:
        third.begin({"list": [1, 2]}, VERSIONS)
        assert list(third.outcomes) == ["coarse", "middle"]
    with Store(folder, scene) as other, pytest.raises(StudyError, match="another scene, duration or grid"):
        other.begin({"list": [3]}, VERSIONS)
    with pytest.raises(StudyError, match="the scene's file has changed"):
        Store(folder, b"name: b\n")
    with Store(folder, b"name: b\n", fresh=True) as fresh:
        fresh.begin({"list": [3]}, VERSIONS)
        assert not fresh.outcomes
        assert fresh.scene.read_bytes() == b"name: b\n"


def test_a_study_owns_its_scene(tmp_path: Path) -> None:
    """It reads the scene as it was when it began; its copy may not be another."""
    folder = tmp_path / "s"
    with Store(folder, b"one") as store:
        store.begin({}, VERSIONS)
        store.will_write(b"written")
    with Store(folder, b"written") as store:
        assert store.text == b"one"
    (folder / "scene.yaml").write_bytes(b"two")
    with pytest.raises(StudyError, match="is not the scene that the study began with"):
        Store(folder, b"one")


def test_two_studies_do_not_share_a_folder(tmp_path: Path) -> None:
    with (
        Store(tmp_path / "s", b"one"),
        pytest.raises(StudyError, match=r"another study works here \(process \d+\)"),
    ):
        Store(tmp_path / "s", b"one", fresh=True)
    Store(tmp_path / "s", b"one").close()


def test_other_versions_results_count_only_when_told(tmp_path: Path) -> None:
    with Store(tmp_path / "s", b"one") as store:
        store.begin({}, VERSIONS)
        store.keep(POINTS[0])
    with Store(tmp_path / "s", b"one") as store:
        with pytest.raises(StudyError, match=r"flexsim 1 \(now 2\); give --across-versions"):
            store.begin({}, {"flexsim": "2"})
        store.begin({}, {"flexsim": "2"}, across=True)
        assert list(store.outcomes) == ["coarse"]


def test_damage_is_seen(tmp_path: Path) -> None:
    """A byte changed at random costs that point, or is said; it never changes what is advised."""
    folder = tmp_path / "s"
    with Store(folder, b"one") as store:
        store.begin({}, VERSIONS)
        for point in POINTS:
            store.keep(point)
        store.keep_reference(Reference({"tip": np.arange(30.0).reshape(10, 3)}, {"tip": 1e-9}, "two ways"))
    whole = {p: (folder / p).read_bytes() for p in ("points.jsonl", "reference.npz", "scene.yaml")}
    random = np.random.default_rng(4)
    for _ in range(60):
        name = str(random.choice(list(whole)))
        text = bytearray(whole[name])
        at = int(random.integers(len(text)))
        text[at] ^= int(random.integers(1, 256))
        (folder / name).write_bytes(bytes(text[: at + 1] if random.random() < 0.3 else text))
        try:
            with Store(folder, b"one") as store:
                store.begin({}, VERSIONS)
                assert all(store.outcomes[p.point] == p for p in POINTS if p.point in store.outcomes)
                kept = store.reference()
                assert kept is None or np.array_equal(kept.arrays["tip"], np.arange(30.0).reshape(10, 3))
        except StudyError as problem:
            assert "--fresh" in str(problem) or "--across-versions" in str(problem)
        for path, before in whole.items():
            (folder / path).write_bytes(before)


def test_the_grid_has_what_the_scene_offers() -> None:
    study = RobotStudy(str(PLANAR), {}, 0.5, {}, {"damping.beta": [0.0, 1e-4]})
    curves = {p.curve for p in study.points()}
    assert {"rosenbrock_w, 1 element a link", "generalized_alpha, 8 elements a link"} <= curves
    assert {"runge_kutta_4", "radau", "dop853", "shear on", "gravity off", "zeroed: chord"} <= curves
    assert "damping.beta=0.0001" in curves
    assert "co_moving, generalized_alpha, 4 elements a link" in curves
    assert "rosenbrock_w, 8 elements a link, 4 modes" in curves
    assert all(math.isclose(study.period / s % 1.0, 0.0, abs_tol=1e-9) or s > 1e-3
               for s in {p.size for p in study.points() if p.curve.startswith("rosenbrock")})  # fmt: skip


def test_formulations_and_reductions_that_a_scene_refuses_are_named_once() -> None:
    """Co-moving frames take no reduction, and none of chords; the reason stands beside the point."""
    for path, given, curve, said in (
        (PLANAR, {"formulation": "co_moving"}, "reduced links", "reduction: takes formulation: erls"),
    ):
        study = RobotStudy(str(path), given, 0.1, {}, {})
        points = [p for p in study.points() if p.curve.startswith(curve)]
        assert len(points) == 1, curve
        outcome = study.measure(points[0], Reference({}, {}, ""))
        assert not outcome.ok and said in outcome.status
    moving = RobotStudy(str(PLANAR), {"formulation": "co_moving", "erls.zeroed": "auto"}, 0.1, {}, {})
    assert "erls, rosenbrock_w, 4 elements a link" in {p.curve for p in moving.points()}


def test_a_formulation_left_to_auto_is_studied_as_both() -> None:
    """The reference is in co-moving frames, each point says which it has, and what is chosen is written."""
    given = {"formulation": "auto", "tolerance": 1e-4, "erls.zeroed": "chord", "effects": "auto"}
    study = RobotStudy(str(PLANAR), given, 0.1, {}, {})
    assert study.scene.formulation == "co_moving"
    assert "reference is in co_moving" in study.taken
    points = study.points()
    named = [p for p in points if p.curve.partition(",")[0] in ("erls", "co_moving")]
    for ending in ("rosenbrock_w, 2 elements a link", "generalized_alpha, 4 elements a link"):
        assert {f"erls, {ending}", f"co_moving, {ending}"} <= {p.curve for p in named}
    assert "erls, rosenbrock_w, 4 elements a link, 2 modes" in {p.curve for p in named}
    assert not [p.curve for p in points if p.curve.startswith(("rosenbrock", "generalized", "radau", "dop"))]
    for point in (named[0], next(p for p in named if p.curve.startswith("erls"))):
        name = point.curve.partition(",")[0]
        scene = study.scene_with(point.overrides)
        assert (scene.formulation, scene.erls.zeroed == "chord") == (name, name == "erls")
        text = written(PLANAR.read_bytes(), {**study.changes, **point.overrides}, load_scene)
        there = load_scene(plain(text.decode()))
        assert there.formulation == name and not there.undecided
    plainly = RobotStudy(str(PLANAR), {"formulation": "co_moving"}, 0.1, {}, {})
    assert plainly.fingerprint != RobotStudy(str(PLANAR), {**given, "effects": {}}, 0.1, {}, {}).fingerprint
    reduced = RobotStudy(str(PLANAR), {**given, "reduction": {"modes": 1}}, 0.1, {}, {})
    assert reduced.scene.formulation == "erls"
    assert "this study is in erls, for co_moving does not take the scene: reduction" in reduced.taken


def test_the_erls_is_promised_with_its_distance_where_the_reference_is_in_co_moving_frames() -> None:
    """Its points are held against its own end, which is so far from the one that holds."""
    far = {"erls": {"distance": 2e-3, "uncertainty": 1e-4}}
    truth = truth_of("co_moving", Reference({}, {"tip": 1e-6}, "", far), "co_moving", False)
    tip = Measure("tip", "tip position", "mm", 1e3)
    erls, own = (Outcome(m, m, 1e-3, {}, "ok", {"tip": 1e-5}, [1.0], 1e-3, model=m) for m in
                 ("erls", "co_moving"))  # fmt: skip
    assert truth.model(erls, tip) == pytest.approx(2.1e-3)
    assert truth.model(own, tip) == 0.0
    unknown = Reference({}, {"tip": 1e-6}, "", {"erls": {"refused": "x"}})
    lost = truth_of("co_moving", unknown, "co_moving", False)
    assert lost.model(erls, tip) == math.inf
    choice = choose([erls, own], tip, Cost(1000.0), None, 1e-3, 1e-7, truth)
    assert choice.outcome is own
    assert "erls up to 2.1 mm from co_moving" in truth.model_said(tip)


def test_what_a_scene_reduces_is_whole_in_the_grid_and_the_reference() -> None:
    """Else fewer elements than modes would be refused, and the reference would lack what is left out."""
    given = {"reduction": {"modes": 3}, "links.0.reduction": {"modes": 2}, "links.1.beam.elements": 4,
             "links.0.beam.elements": 4}  # fmt: skip
    grid = RobotStudy(str(PLANAR), given, 0.1, {}, {}).grid
    for modes in (None, 4):
        scene = load_scene(PLANAR, {**given, **grid.meshed(8, modes)})
        assert [scene.modes_of(link) for link in scene.links] == [modes, modes]


@pytest.fixture(scope="module")
def studied(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    folder = tmp_path_factory.mktemp("accuracy")
    done = flexsim(*SMOOTH, "--tolerance", "0.1mm", "--json", cwd=folder, timeout=600)
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_a_robots_study(studied: tuple[Path, dict]) -> None:
    """The reference is far better than what is plotted, the integrators show their order, pictures exist."""
    folder, found = studied
    points = {p["point"]: p for p in found["points"]}
    assert all(p["status"] == "ok" for p in points.values())
    assert len(points) == 19
    assert {"co_moving, rosenbrock_w, 2 elements a link, 0.002",
            "rosenbrock_w, 4 elements a link, 2 modes, 0.002"} <= set(points)  # fmt: skip
    smallest = min(p["errors"]["tip"] for p in points.values())
    assert found["reference"]["error"]["tip"] < 0.1 * smallest
    # So stiff a robot is the same in both formulations; each one is judged by its own end.
    own, other = (
        points[f"{name}rosenbrock_w, 2 elements a link, 0.002"]["errors"] for name in ("", "co_moving, ")
    )
    assert found["reference"]["orders"]["rosenbrock_w"] == pytest.approx(2.0, abs=0.1)
    assert found["promise"] <= 1e-4
    assert "count on" in found["sentence"]
    assert [row["times"] for row in found["conditions"]["longer"]] == [1, 2, 4]
    assert len(found["conditions"]["nearby"]) == 2
    assert 0.0 < found["formulations"]["co_moving"]["distance"] < 0.3 * own["tip"]
    assert math.isclose(own["time"], other["time"], rel_tol=0.05)
    for method in ("rosenbrock_w", "generalized_alpha"):
        orders = found["orders"][f"{method}, 2 elements a link"]
        assert np.allclose(orders, 2.0, atol=0.1), (method, orders)
    assert points[found["choice"]]["errors"]["tip"] < 1e-4
    assert "use " in found["sentence"]
    assert found["machine"]["cores"] >= 1
    for path in found["diagrams"].values():
        assert (folder / path).read_bytes()[:4] == b"\x89PNG"
    assert json.loads((folder / "out" / "accuracy.json").read_text())["points"] == found["points"]


def test_the_same_command_goes_on(studied: tuple[Path, dict]) -> None:
    """With half of its points gone it runs only those."""
    folder, found = studied
    kept = folder / "out" / "points.jsonl"
    lines = kept.read_text().splitlines()
    kept.write_text("\n".join(lines[:-3]) + "\n")
    again = flexsim(*SMOOTH, "--budget", "300us", "--json", cwd=folder, timeout=600)
    assert again.returncode == 0, again.stderr
    points = json.loads(again.stdout)["points"]
    assert points[:-3] == found["points"][:-3]
    assert [p["point"] for p in points] == [p["point"] for p in found["points"]]
    other = flexsim("accuracy", PLANAR, "--quick", "-d", 0.4, "-o", "out", cwd=folder)
    assert other.returncode == 1
    assert "another scene, duration or grid" in other.stderr


def test_a_doors_study(tmp_path: Path) -> None:
    """What --set changed is written with the choice, nothing else is, and the same command goes on."""
    scene = tmp_path / "door.yaml"
    shutil.copy(CONFIG / "thesis_door_column.yaml", scene)
    words = ["accuracy", scene, "--quick", "-d", 600, "-o", "out", "--tolerance", "1K", "--write", "--json",
             "--set", "ambient=21.5"]  # fmt: skip
    done = flexsim(*words, cwd=tmp_path, timeout=300)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert all(p["status"] == "ok" for p in found["points"])
    assert found["reference"]["error"]["unexposed"] < 0.1
    chosen = next(p for p in found["points"] if p["point"] == found["choice"])
    assert chosen["errors"]["unexposed"] <= 1.0
    assert "from full" in found["sentence"]
    from thermal_node import load_scene

    original = CONFIG / "thesis_door_column.yaml"
    studied = load_scene(original, {"ambient": 21.5, **chosen["overrides"]})
    assert load_scene(scene).model_copy(update={"source": studied.source}) == studied
    before, after = original.read_text().splitlines(), scene.read_text().splitlines()
    keys = {k.split(".")[0] for k in chosen["overrides"]} | {"ambient"}
    changed = [new for new in after if new not in before]
    assert all(line.split(":")[0].strip() in keys for line in changed), changed
    again = flexsim(*words, cwd=tmp_path, timeout=300)
    assert again.returncode == 0, again.stderr
    assert json.loads(again.stdout)["points"] == found["points"]
    assert scene.read_text().splitlines() == after


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["nowhere.yaml"], 1, "does not exist"),
        ([PLANAR, "--tolerance", "5"], 2, "give a number and a unit"),
        ([PLANAR, "--sine", "joint_1=5"], 2, "JOINT=AMPLITUDE@HZ"),
        ([PLANAR, "--sine", "joint_9=5@1"], 1, "no such joint; there are joint_1, joint_2"),
        ([PLANAR, "--vary", "damping.beta"], 2, "KEY=V1,V2"),
        ([CONFIG / "thesis_door_column.yaml", "--sine", "joint_1=5@1"], 2, "no joints"),
    ],
)
def test_wrong_words(words: list[object], code: int, said: str, tmp_path: Path) -> None:
    done = flexsim("accuracy", *words, cwd=tmp_path)
    assert done.returncode == code
    assert said in done.stderr
