"""Text from a file as it may be shown: without anything that a terminal would obey."""

from __future__ import annotations

import unicodedata

# Control characters, those that turn the direction of writing, private ones and halves of pairs.
HIDDEN = {"Cc", "Cf", "Co", "Cs", "Zl", "Zp"}


def plain(text: str, keep: str = "") -> str:
    """Return a text with what can't be shown written as an escape, `\\x1b`, but for what is to be kept."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(escaped(c) if unicodedata.category(c) in HIDDEN and c not in keep else c for c in text)


def escaped(character: str) -> str:
    """Return a character as Python writes it."""
    return character.encode("unicode_escape").decode("ascii")
