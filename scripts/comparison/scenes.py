"""Whether two bags' simulators ran the same scenes, by the hashes that they published."""

from __future__ import annotations

from typing import Any

from ..bag import Bag
from ..bag.scenes import differing, scenes_in


def scenes(first: Bag, second: Bag) -> dict[str, dict[str, Any]]:
    """Return of each simulator its scene's hash in either bag, and in which keys they differ.

    `same` is None where one of the bags does not hold the scene, and `why` says so.
    """
    found = {}
    sides = scenes_in(first), scenes_in(second)
    for node in sorted({*sides[0], *sides[1]}):
        here = [side.get(node) for side in sides]
        told = [None if one is None else one.scene for one in here]
        why = [
            f"{bag.path} holds no scene of it" if one is None else one.why_not
            for bag, one in zip((first, second), here, strict=True)
        ]
        a, b = told
        found[node] = {
            "first": a and a.hash,
            "second": b and b.hash,
            "same": None if a is None or b is None else a.hash == b.hash,
            "differ": [] if a is None or b is None else differing(a.scene, b.scene),
            "why": "; ".join(filter(None, why)),
        }
    return found


def sentence(node: str, found: dict[str, Any]) -> str:
    """Say of a simulator whether both runs were of one scene."""
    if found["same"] is None:
        return f"scene of {node}: not compared, {found['why']}"
    if found["same"]:
        return f"scene of {node}: the same, {found['first'][:15]}"
    keys = found["differ"]
    more = f" and {len(keys) - 5} more" if len(keys) > 5 else ""
    return f"scene of {node}: differs in {', '.join(keys[:5])}{more}"
