"""Places of a scene's joints in messages, which may have them in another order."""

from __future__ import annotations

from collections.abc import Sequence


def joint_order(topic: str, published: Sequence[str], wanted: Sequence[str]) -> list[int]:
    """Return where each of the wanted joints stands in a message; raises ValueError where one is missing."""
    missing = [name for name in wanted if name not in published]
    if missing:
        raise ValueError(f"{topic} has no {missing[0]}, only {', '.join(published)}; is it of another scene?")
    return [list(published).index(name) for name in wanted]
