"""What the frame program says of the loaded scenes: data/loaded_frame.json, made anew by

    python tests/robot/frame_figures.py

It takes minutes, so the figures are kept; a test holds that they belong to the scenes as they are, and makes
some of them again.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
from independent_frame import extrapolated, frame_of_scene, link_ends
from loaded_scenes import LOADED_ENDS, SIDE_LOADS, SPUN, WEIGHED, WRENCHES

from flexsim_node import load_scene

FILE = Path(__file__).parent / "data" / "loaded_frame.json"
MODES = 4
PARTS = (-0.1, 0.1, 1.0)  # of the weight
SPINS = (0.0, 0.3, 1.0)  # of the spin
SIDE_GRAVITY, SIDE_FORCE = 0.01, 1e-3  # m/s2, N


def digest(scene: dict) -> str:
    """Of a scene, to see whether figures belong to it."""
    return hashlib.sha256(json.dumps(scene, sort_keys=True).encode()).hexdigest()[:16]


def pulled(scene: dict, part: float) -> dict:
    """That part of the scene's gravity, as an override."""
    return {"gravity": [part * g for g in scene["gravity"]]}


def pose_of(scene: dict) -> list[float]:
    """Where its joints are held."""
    return list(load_scene(scene).start("position"))


def weighed(name: str, part: float) -> np.ndarray:
    """(MODES,) frequencies under a part of the weight, Hz."""
    scene = WEIGHED[name]
    read, pose = load_scene(scene, pulled(scene, part)), pose_of(scene)
    return extrapolated(lambda n: frame_of_scene(read, pose, n)[0].solved().frequencies(MODES), 6)


def spun(name: str, part: float) -> np.ndarray:
    """(MODES,) frequencies at a part of the spin, Hz."""
    scene, spin = SPUN[name]
    read, pose = load_scene(scene), pose_of(scene)

    def at(count: int) -> np.ndarray:
        frame, _ = frame_of_scene(read, pose, count, loaded=False, spin=part * spin)
        return frame.solved().frequencies(MODES)

    return extrapolated(at, 8)


def sideways(name: str) -> np.ndarray:
    """(L, 3) how the links' ends move with a small weight beside their own, m per m/s2."""
    scene = WEIGHED[name]

    def at(count: int) -> np.ndarray:
        ends = []
        for sign in (1.0, -1.0):
            gravity = np.array(scene["gravity"]) + sign * SIDE_GRAVITY * np.array(SIDE_LOADS[name])
            read = load_scene(scene, {"gravity": gravity.tolist()})
            frame, names = frame_of_scene(read, pose_of(scene), count)
            ends.append(link_ends(frame.solved(), names))
        return (ends[0] - ends[1]) / (2.0 * SIDE_GRAVITY)

    return extrapolated(at, 6)


def loaded_end(name: str, wrench: str) -> np.ndarray:
    """(3,) how the last link's end moves with a small force across, beside a wrench on it, m/N."""
    scene = LOADED_ENDS[name]
    last = scene["links"][-1]["name"]

    def at(count: int) -> np.ndarray:
        ends = []
        for sign in (1.0, -1.0):
            load = np.array(WRENCHES[wrench]) + sign * SIDE_FORCE * np.eye(6)[2]
            frame, names = frame_of_scene(load_scene(scene), [0.0], count, wrench={last: load})
            ends.append(link_ends(frame.solved(), names)[-1])
        return (ends[0] - ends[1]) / (2.0 * SIDE_FORCE)

    return extrapolated(at, 6)


def entries() -> dict:
    """Every figure by its name: how it is made, and the scene to which it belongs."""
    found = {}
    for name in WEIGHED:
        for part in PARTS:
            found[f"weighed/{name}/{part:g}"] = (weighed, (name, part), WEIGHED[name])
    for name in SIDE_LOADS:
        found[f"sideways/{name}"] = (sideways, (name,), WEIGHED[name])
    for name in SPUN:
        for part in SPINS:
            found[f"spun/{name}/{part:g}"] = (spun, (name, part), SPUN[name][0])
    for name in LOADED_ENDS:
        for wrench in WRENCHES:
            found[f"loaded_end/{name}/{wrench}"] = (loaded_end, (name, wrench), LOADED_ENDS[name])
    return found


def main() -> None:
    """Make what is missing or belongs to another scene."""
    kept = json.loads(FILE.read_text()) if FILE.exists() else {}
    made = {}
    for name, (of, arguments, scene) in entries().items():
        mark = digest(scene)
        if kept.get(name, {}).get("scene") == mark:
            made[name] = kept[name]
        else:
            try:
                made[name] = {"scene": mark, "value": of(*arguments).tolist()}
            except ArithmeticError as error:
                print(name, error, flush=True)
                continue
            print(name, flush=True)
            FILE.write_text(json.dumps({**kept, **made}, indent=0) + "\n")
    FILE.write_text(json.dumps(made, indent=0) + "\n")


if __name__ == "__main__":
    main()
