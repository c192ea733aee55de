"""`flexsim accuracy`: what it finds is right, what it advises holds, and it goes on where it stopped."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from flexsim.study.choice import Cost, choose, frontier, quantity, write_choice
from flexsim.study.order import observed_orders
from flexsim.study.point import Measure, Outcome, Reference
from flexsim.study.ringing import ringing
from flexsim.study.robot import RobotStudy
from flexsim.study.store import Store
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


def test_the_choice_is_written_and_comments_stay(tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    shutil.copy(PLANAR, scene)
    write_choice(scene, {"solver.step": 5e-4, "links.1.beam.elements": 4, "effects.shear": True})
    before, after = PLANAR.read_text(), scene.read_text()
    changed = load_scene(scene)
    assert changed.solver.step == 5e-4
    assert [link.beam.elements for link in changed.links if link.beam] == [2, 4]
    assert changed.effects.shear is True
    remarks = [line.split("#")[1].strip() for line in before.splitlines() if "#" in line]
    assert len(remarks) > 8
    assert all(remark in after for remark in remarks)


def test_reductions_and_formulations_are_written_and_taken_back(tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    shutil.copy(PLANAR, scene)
    for overrides in ({"reduction": {"modes": 3}, "links.0.reduction": False}, {"formulation": "co_moving",
                      "erls.zeroed": "root", "reduction": None, "links.0.reduction": None}):  # fmt: skip
        write_choice(scene, overrides)
        assert load_scene(scene) == load_scene(PLANAR, overrides)


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


def test_a_store_goes_on_and_does_not_mix_studies(tmp_path: Path) -> None:
    store = Store(tmp_path / "s", {"scene": "a", "list": (1, 2)}, fresh=False)
    store.keep(POINTS[0])
    store.keep_reference(Reference({"tip": np.eye(3)}, {"tip": 1e-9}, "two ways"))
    with (tmp_path / "s" / "points.jsonl").open("a") as file:
        file.write('{"point": "half a li')
    again = Store(tmp_path / "s", {"scene": "a", "list": (1, 2)}, fresh=False)
    assert list(again.outcomes) == ["coarse"]
    assert again.outcomes["coarse"] == POINTS[0]
    kept = again.reference()
    assert kept is not None
    np.testing.assert_array_equal(kept.arrays["tip"], np.eye(3))
    again.keep(POINTS[1])
    assert list(Store(tmp_path / "s", {"scene": "a", "list": [1, 2]}, False).outcomes) == ["coarse", "middle"]
    with pytest.raises(ValueError, match="another scene, duration or grid"):
        Store(tmp_path / "s", {"scene": "b"}, fresh=False)
    assert not Store(tmp_path / "s", {"scene": "b"}, fresh=True).outcomes


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
    assert len(points) == 18
    assert {"co_moving, rosenbrock_w, 2 elements a link, 0.002",
            "rosenbrock_w, 4 elements a link, 2 modes, 0.002"} <= set(points)  # fmt: skip
    smallest = min(p["errors"]["tip"] for p in points.values())
    assert found["reference"]["error"]["tip"] < 0.1 * smallest
    # So stiff a robot is the same in both formulations; each one's step is judged by its own end.
    own, other = (
        points[f"{name}rosenbrock_w, 2 elements a link, 0.002"]["errors"] for name in ("", "co_moving, ")
    )
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
    scene = tmp_path / "door.yaml"
    shutil.copy(CONFIG / "thesis_door_column.yaml", scene)
    done = flexsim(
        "accuracy", scene, "--quick", "-d", 600, "-o", "out", "--tolerance", "1K", "--write", "--json",
        cwd=tmp_path, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert all(p["status"] == "ok" for p in found["points"])
    assert found["reference"]["error"]["unexposed"] < 0.05
    chosen = next(p for p in found["points"] if p["point"] == found["choice"])
    assert chosen["errors"]["unexposed"] <= 1.0
    from thermal_node import load_scene

    written = load_scene(scene)
    for key, value in chosen["overrides"].items():
        place = written
        for part in key.split("."):
            place = getattr(place, part)
        assert place == value or (value == "auto" and place is None) or list(place) == value
    assert "#" in scene.read_text()


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
