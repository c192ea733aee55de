"""Points kept as they are found, one JSON object a line, so that a study can be stopped and resumed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from .point import Outcome, Reference


class Store:
    """A study's folder: points.jsonl and reference.npz.

    The first line says what the points depend on; a study of anything else does not go on there.

    Raises
    ------
    ValueError
        Where the folder holds another study.
    """

    def __init__(self, folder: Path, fingerprint: dict[str, Any], fresh: bool) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self._points, self._reference = folder / "points.jsonl", folder / "reference.npz"
        self.outcomes: dict[str, Outcome] = {}
        head = json.loads(json.dumps({"study": fingerprint}))
        if fresh or not self._points.exists():
            self._reference.unlink(missing_ok=True)
            self._points.write_text(json.dumps(head) + "\n", encoding="utf-8")
            return
        lines = self._points.read_text(encoding="utf-8").splitlines()
        if not lines or _parsed(lines[0]) != head:
            raise ValueError(
                f"{self._points}: holds a study of another scene, duration or grid; give another"
                " --output, or --fresh to begin anew"
            )
        kept = [line for line in lines[1:] if isinstance(_parsed(line), dict)]
        if len(kept) < len(lines) - 1:  # stopped while it wrote
            self._points.write_text("\n".join([lines[0], *kept]) + "\n", encoding="utf-8")
        for line in kept:
            outcome = Outcome(**json.loads(line))
            self.outcomes[outcome.point] = outcome

    def keep(self, outcome: Outcome) -> None:
        """Add a point."""
        self.outcomes[outcome.point] = outcome
        with self._points.open("a", encoding="utf-8") as file:
            file.write(json.dumps(outcome.record()) + "\n")

    def reference(self) -> Reference | None:
        """The reference of an earlier run, if it is there."""
        if not self._reference.exists():
            return None
        with np.load(self._reference, allow_pickle=False) as kept:
            arrays = {k: kept[k] for k in kept.files if k != "said"}
            said = json.loads(str(kept["said"]))
        return Reference(arrays, said["error"], said["how"], said["formulations"])

    def keep_reference(self, reference: Reference) -> None:
        """Keep the reference."""
        said = json.dumps(
            {"error": reference.error, "how": reference.how, "formulations": reference.formulations}
        )
        part = self._reference.with_suffix(".part")
        with part.open("wb") as file:
            np.savez_compressed(file, said=np.array(said), **reference.arrays)  # type: ignore[arg-type]
        part.replace(self._reference)


def _parsed(line: str) -> Any:
    try:
        return json.loads(line)
    except json.JSONDecodeError:
        return None
