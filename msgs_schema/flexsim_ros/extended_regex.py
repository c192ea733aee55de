"""POSIX extended regular expressions, matched in a time that is linear in the text.

Filters come over the network from anybody, and Python's own `re` needs exponential time for some of them;
so an expression becomes a nondeterministic automaton whose states are all followed at once (Thompson, 1968).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NoReturn

LONGEST, DEEPEST, LARGEST = 1000, 50, 10_000  # characters, brackets in brackets, states
INFINITE = -1
CLASSES: dict[str, Callable[[str], bool]] = {
    "alnum": str.isalnum,
    "alpha": str.isalpha,
    "blank": lambda c: c in " \t",
    "cntrl": lambda c: ord(c) < 32 or ord(c) == 127,
    "digit": lambda c: c in "0123456789",
    "graph": lambda c: c.isprintable() and not c.isspace(),
    "lower": str.islower,
    "print": str.isprintable,
    "punct": lambda c: c.isprintable() and not c.isalnum() and not c.isspace(),
    "space": str.isspace,
    "upper": str.isupper,
    "xdigit": lambda c: c in "0123456789abcdefABCDEF",
}

# A tree of an expression: ("set", accepts) | ("begin",) | ("end",) | ("all", parts) | ("any", parts)
# | ("repeat", part, least, most).
Tree = tuple


class RegexError(ValueError):
    """An expression that can't be: what is wrong, and where."""


class ExtendedRegex:
    """A compiled expression; raises RegexError."""

    def __init__(self, text: str) -> None:
        if len(text) > LONGEST:
            raise RegexError(f"the expression has {len(text)} characters; give at most {LONGEST}")
        # Instructions: ("set", accepts), ("split", n, n), ("jump", n), ("begin",), ("end",), ("match",).
        self._program: list[tuple] = []
        self._work = 0
        self._emit_tree(_Parser(text).parse())
        self._emit("match")

    def matches(self, text: str) -> bool:
        """Whether the whole text matches."""
        last = len(text)
        states = self._follow([0], 0, last)
        for at, character in enumerate(text):
            taken = [n + 1 for n in states if self._program[n][0] == "set" and self._program[n][1](character)]
            states = self._follow(taken, at + 1, last)
            if not states:
                return False
        return any(self._program[n][0] == "match" for n in states)

    def _follow(self, starts: Iterable[int], at: int, last: int) -> list[int]:
        """All states that are reached without a character."""
        seen: set[int] = set()
        waiting = list(starts)
        while waiting:
            n = waiting.pop()
            if n in seen:
                continue
            seen.add(n)
            instruction = self._program[n]
            if instruction[0] in ("split", "jump"):
                waiting.extend(instruction[1:])
            elif (instruction[0] == "begin" and at == 0) or (instruction[0] == "end" and at == last):
                waiting.append(n + 1)
        return sorted(seen)

    def _emit(self, *instruction: object) -> int:
        self._spend()
        self._program.append(instruction)
        return len(self._program) - 1

    def _spend(self) -> None:
        self._work += 1
        if self._work > LARGEST:
            raise RegexError("the expression's repetitions are too many; give smaller counts")

    def _emit_tree(self, tree: Tree) -> None:
        self._spend()
        kind = tree[0]
        if kind == "all":
            for part in tree[1]:
                self._emit_tree(part)
        elif kind == "any":
            ends = []
            for part in tree[1][:-1]:
                split = self._emit("split")
                self._emit_tree(part)
                ends.append(self._emit("jump"))
                self._program[split] = ("split", split + 1, len(self._program))
            self._emit_tree(tree[1][-1])
            for end in ends:
                self._program[end] = ("jump", len(self._program))
        elif kind == "repeat":
            self._emit_repeat(*tree[1:])
        else:
            self._emit(*tree)

    def _emit_repeat(self, part: Tree, least: int, most: int) -> None:
        for _ in range(least):
            self._emit_tree(part)
        if most == INFINITE:
            split = self._emit("split")
            self._emit_tree(part)
            self._emit("jump", split)
            self._program[split] = ("split", split + 1, len(self._program))
            return
        splits = []
        for _ in range(most - least):
            splits.append(self._emit("split"))
            self._emit_tree(part)
        for split in splits:
            self._program[split] = ("split", split + 1, len(self._program))


class _Parser:
    """Reads an expression by the grammar of POSIX.1-2017, section 9.5.3."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.depth = 0

    def parse(self) -> Tree:
        tree = self._alternatives()
        if self.at < len(self.text):
            self._fail("a ')' has no '('")
        return tree

    def _fail(self, why: str) -> NoReturn:
        raise RegexError(f"{why} at character {self.at + 1}")

    def _peek(self) -> str:
        return self.text[self.at : self.at + 1]

    def _take(self, word: str) -> bool:
        found = self.text.startswith(word, self.at)
        if found:
            self.at += len(word)
        return found

    def _alternatives(self) -> Tree:
        self.depth += 1
        if self.depth > DEEPEST:
            self._fail("too many brackets in each other")
        branches = [self._branch()]
        while self._take("|"):
            branches.append(self._branch())
        self.depth -= 1
        return ("any", branches)

    def _branch(self) -> Tree:
        parts = []
        while self._peek() not in ("", "|", ")"):
            part = self._atom()
            while self._peek() and self._peek() in "*+?{":
                part = ("repeat", part, *self._count())
            parts.append(part)
        return ("all", parts)

    def _count(self) -> tuple[int, int]:
        for sign, count in (("*", (0, INFINITE)), ("+", (1, INFINITE)), ("?", (0, 1))):
            if self._take(sign):
                return count
        end = self.text.find("}", self.at)
        least, comma, most = self.text[self.at + 1 : max(end, 0)].partition(",")
        good = least.isascii() and least.isdigit() and (not most or (most.isascii() and most.isdigit()))
        if end < 0 or not good or len(least) > 4 or len(most) > 4:
            self._fail("a '{' needs {n}, {n,} or {n,m} with counts below 10000")
        low = int(least)
        high = (int(most) if most else INFINITE) if comma else low
        if high != INFINITE and high < low:
            self._fail(f"{{{low},{high}}} runs backwards")
        self.at = end + 1
        return low, high

    def _atom(self) -> Tree:
        if self._take("("):
            inside = self._alternatives()
            if not self._take(")"):
                self._fail("a '(' is not closed")
            return inside
        if self._take("["):
            return ("set", self._bracket())
        if self._take("."):
            return ("set", lambda c: True)
        if self._take("^"):
            return ("begin",)
        if self._take("$"):
            return ("end",)
        if self._peek() in "*+?{":
            self._fail(f"nothing is before '{self._peek()}'")
        self._take("\\")
        if not self._peek():
            self._fail("nothing is behind '\\'")
        return ("set", self._next().__eq__)

    def _next(self) -> str:
        character = self._peek()
        self.at += 1
        return character

    def _bracket(self) -> Callable[[str], bool]:
        excluded = self._take("^")
        tests: list[Callable[[str], bool]] = []
        first = True
        while first or self._peek() != "]":
            first = False
            if not self._peek():
                self._fail("a '[' is not closed")
            if self._take("[:"):
                name = self._until(":]")
                if name not in CLASSES:
                    self._fail(f"no class [:{name}:]; there are {', '.join(CLASSES)}")
                tests.append(CLASSES[name])
                continue
            low = self._element()
            high = low
            if self._peek() == "-" and self.text[self.at + 1 : self.at + 2] not in ("", "]"):
                self.at += 1
                high = self._element()
                if high < low:
                    self._fail(f"the range {low}-{high} runs backwards")
            tests.append(lambda c, low=low, high=high: low <= c <= high)  # type: ignore[misc]
        self.at += 1
        return lambda c: any(test(c) for test in tests) != excluded

    def _element(self) -> str:
        for mark in (".", "="):
            if self._take(f"[{mark}"):
                name = self._until(f"{mark}]")
                if len(name) != 1:
                    self._fail(f"[{mark}{name}{mark}] is not one character")
                return name
        if not self._peek():
            self._fail("a '[' is not closed")
        return self._next()

    def _until(self, word: str) -> str:
        end = self.text.find(word, self.at)
        if end < 0:
            self._fail(f"no '{word}'")
        found = self.text[self.at : end]
        self.at = end + len(word)
        return found
