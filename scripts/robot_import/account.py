"""What an import took, what it changed, what it could not take."""

from __future__ import annotations

from dataclasses import dataclass, field

TOOK, CHANGED, NOT_TAKEN, IN_DOUBT = "took", "changed", "not taken", "in doubt"
MOST_NAMED = 4


@dataclass
class Account:
    """Lines of an import's account: (kind, of what, what)."""

    lines: list[tuple[str, str, str]] = field(default_factory=list)

    def say(self, kind: str, of: str, what: str) -> None:
        """Add a line."""
        self.lines.append((kind, of, what))

    def of_several(self, kind: str, names: list[str], what: str) -> None:
        """Add a line about several, unless there are none."""
        if names:
            more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
            self.say(kind, ", ".join(names[:MOST_NAMED]) + more, what)

    def of_kind(self, kind: str) -> list[dict[str, str]]:
        """The lines of a kind, for --json."""
        return [{"of": of, "what": what} for k, of, what in self.lines if k == kind]
