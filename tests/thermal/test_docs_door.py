"""The page on the fire door runs as printed, where it needs no log of a test."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_live_block_of_the_page_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    text = (ROOT / "docs" / "door.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    live = next(block for block in blocks if "heat.save()" in block)
    names: dict[str, object] = {}
    exec(compile(live, "door.md", "exec"), names)
    heat = names["heat"]
    assert heat.time == 60.0  # type: ignore[attr-defined]
    assert heat.status.ok  # type: ignore[attr-defined]


def test_every_scene_in_config_is_read():
    from thermal_node import door_model, load_scene

    paths = sorted((ROOT / "config").glob("*door*.yaml"))
    assert len(paths) >= 4
    for path in paths:
        assert len(door_model(load_scene(path)).nodes) > 10
