"""Scene files that never end, or that no program should read, and what is said of them."""

from __future__ import annotations

import os
from pathlib import Path


def endless_files(folder: Path, model: str) -> list[tuple[Path, str]]:
    """Aliases that stand for ever more of themselves, a pipe, a device, a file that is too long, a folder."""
    bomb = "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 20))
    pipe = folder / "pipe"
    os.mkfifo(pipe)
    texts = {
        "bomb": f"model: {model}\na0: &a0 [1]\n{bomb}",
        "itself": f"model: {model}\nname: &a [*a]\n",
        "long": "#" * 2_000_000,
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    return [
        (folder / "bomb", "fewer YAML aliases"),
        (folder / "itself", "name|aliases"),
        (folder / "long", "is no file of at most"),
        (pipe, "is no file"),
        (Path("/dev/zero"), "is no file"),
        (folder, "is no file"),
    ]
