"""Topics of a bag by their names or patterns."""

from __future__ import annotations

from fnmatch import fnmatchcase

from .reader import Bag


def chosen(bag: Bag, patterns: tuple[str, ...], without: tuple[str, ...]) -> list[str]:
    """Return the topics that match patterns, all where there are none; BagError for one that matches none."""
    there = [t.name for t in bag.topics.values() if t.count]
    wanted = [p if p in there or p.startswith(("/", "*")) else f"/{p}" for p in patterns]
    for pattern in wanted:
        if not any(fnmatchcase(name, pattern) or name == pattern for name in there):
            bag.topic(pattern)
    unwanted = [p if p in there or p.startswith(("/", "*")) else f"/{p}" for p in without]
    return [
        name
        for name in there
        if any(fnmatchcase(name, p) or name == p for p in wanted or ["*"])
        and not any(fnmatchcase(name, p) or name == p for p in unwanted)
    ]
