"""A recorded run once more, into a new bag."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexsim_node import load_scene

from ..bag import Bag, BagError, BagWriter
from ..terminal.stop import Stop
from .drive import node_parameters, read_drive
from .lockstep import NODE, Driver, node_process
from .ticks import tick_by_tick

if TYPE_CHECKING:
    from ..ros.recorder import Recorder

# s without a message after which the simulator, which waits for a command, has said all; and at most
QUIET, LONGEST = 0.1, 2.0
WAITED_FOR = ("/joint_states", f"/{NODE}/elastic_state", f"/{NODE}/deformed_shape")


def again(
    bag: Bag,
    output: Path,
    scene: Path | None,
    settings: dict[str, Any],
    stopped: Stop,
    progress: Callable[[float, float], None],
) -> dict[str, Any]:
    """Drive flexsim_node with what drove a recorded robot, and record it.

    Parameters
    ----------
    bag : Bag
    output : Path
        The new bag.
    scene : Path or None
        None: the scene that the bag holds.
    settings : dict
        Changes of the scene, by key.
    progress : callable
        Called with the simulated time and the whole duration, s.

    Returns
    -------
    dict
        periods, duration, elapsed; stopped: why the simulator ended early, or "".
    """
    from ..ros.context import tool_node
    from ..ros.recorder import Recorder

    drive = read_drive(bag)
    if scene is None and drive.scene is None:
        raise BagError(f"{bag.path}: {drive.why_not}; name it: --scene SCENE.yaml")
    with tempfile.TemporaryDirectory(prefix="flexsim_") as name, tool_node("flexsim_play") as node:
        folder = Path(name)
        changes, own = drive.overrides, dict(drive.parameters)  # another scene gets what its node changed
        if scene is None:
            assert drive.scene is not None
            changes = {}
            own.pop("faults", None)  # the scene has them
            scene = folder / "scene.yaml"
            scene.write_text(json.dumps(drive.scene.scene), encoding="utf-8")  # JSON is YAML
        as_it_was = load_scene(scene, overrides=changes)
        drive = tick_by_tick(drive, bag, as_it_was)
        parameters = node_parameters(replace(drive, parameters=own), scene.resolve(), changes | settings)
        said = ""
        with BagWriter(output) as written:
            recorder = Recorder(node, written, ["*"])

            def heard() -> bool:
                """Whether all of the robot's states reach the new bag."""
                return not recorder.expecting and all(
                    topic in recorder.topics and recorder.topics[topic].count for topic in WAITED_FOR
                )

            def meanwhile(k: int) -> None:
                recorder.step()
                progress(k * drive.period * 1e-9, drive.duration)

            try:
                with node_process(parameters, folder, stopped) as child:
                    driver = Driver(node, drive, meanwhile, child)
                    driver.connect(stopped, heard)
                    begun = time.monotonic()
                    try:
                        driver.run(stopped)
                    except RuntimeError as problem:
                        said = str(problem)
                    elapsed = time.monotonic() - begun
                    keep_last(recorder)
            finally:
                recorder.close()
            states = recorder.topics["/joint_states"].count
    return {
        "duration": drive.duration,
        "periods": len(drive.torque),
        "states": states,
        "elapsed": elapsed,
        "stopped": said,
    }


def keep_last(recorder: Recorder) -> None:
    """Record what the simulator has still on its way when the run is over."""
    count, since = -1, time.monotonic()
    end = since + LONGEST
    while time.monotonic() < min(end, since + QUIET):
        recorder.drain(everything=True)
        taken = sum(recorder.topics[topic].count for topic in WAITED_FOR if topic in recorder.topics)
        if taken != count:
            count, since = taken, time.monotonic()
        time.sleep(0.005)
    recorder.drain(everything=True)
