"""Compares two bags: every message of both is compared, or named with the reason why not."""

from __future__ import annotations

from fnmatch import fnmatchcase

from ..bag import Bag, BagError
from . import pairing
from .difference import SECOND, Compared, Comparison
from .messages import Progress, comparer
from .pairing import ORDER, STAMP, Pairs, Sequence
from .straight import compare_straight
from .streams import Piece, paired

# Stamps farther from the run's beginning than this are of another clock, ns.
OTHER_CLOCK = 3600 * SECOND


def compare_bags(
    first: Bag,
    second: Bag,
    topics: tuple[str, ...] = (),
    without: tuple[str, ...] = (),
    align: str = STAMP,
    offset: float = 0.0,
    progress: Progress = lambda _: None,
    once: bool = False,
) -> Comparison:
    """Compare two bags: each field of each message of either.

    Parameters
    ----------
    topics, without : names, or patterns such as '/door/*'; all topics, and none
    align : STAMP, ELAPSED or RECEIPT
        What brings messages together. Topics without stamps are compared in order, or by receipt.
    offset : s
        Added to the times of the second run.
    progress : called with what is being done
    once : whether of messages of one stamp only the first counts

    Raises
    ------
    BagError
        Neither bag has a topic that is asked for.
    """
    found = Comparison()
    names = chosen(first, second, topics, without, found)
    both = []
    for name in names:
        why = why_not(first, second, name)
        if why:
            found.not_compared[name] = why
        elif name in first.topics and first.topics[name].count:
            both.append(name)
    left = both
    if align == STAMP and not offset and not once:
        left = compare_straight(first, second, both, found, progress)
    sets: dict[tuple[str, ...], int] = {}
    sequences = [
        pairing.sequences(bag, left, sets, lambda n, bag=bag: progress(f"{n} times of {bag.path} read"))  # type: ignore[misc]
        for bag in (first, second)
    ]
    pairs = {name: topic_pairs(name, sequences, align, offset, once) for name in left}
    for name in left:
        taken(found, name, pairs[name], first, second)
    pairs = {name: some for name, some in pairs.items() if name in found.topics}
    compare_pairs(first, second, pairs, found, progress)
    found.topics = {name: found.topics[name] for name in both if name in found.topics}
    for letter, bag in (("A", first), ("B", second)):
        for damage in bag.damages:
            found.not_compared[f"{letter}, {damage.file.name}"] = f"byte {damage.offset}: {damage.what}"
    return found


def chosen(
    first: Bag, second: Bag, topics: tuple[str, ...], without: tuple[str, ...], found: Comparison
) -> list[str]:
    """Return the topics that are to be compared; raises BagError for one that neither bag has."""
    there = sorted({*first.topics, *second.topics})
    for pattern in (*topics, *without):
        if not any(fnmatchcase(name, pattern) for name in there):
            raise BagError(f"neither bag has a topic {pattern}; they have {', '.join(there) or 'no topics'}")
    names = [n for n in there if not topics or any(fnmatchcase(n, p) for p in topics)]
    for name in names:
        if any(fnmatchcase(name, p) for p in without):
            found.left_out[name] = "by --without"
    return [name for name in names if name not in found.left_out]


def why_not(first: Bag, second: Bag, name: str) -> str:
    """Say why a topic can't be compared; "" where it can be."""
    counts = [bag.topics[name].count if name in bag.topics else None for bag in (first, second)]
    if not any(counts):
        return ""
    for letter, bag, count in zip("AB", (first, second), counts, strict=True):
        if not count:
            has = "no such topic" if count is None else "no messages of it"
            return f"{letter}, {bag.path}, has {has}"
    types = [bag.topics[name].types for bag in (first, second)]
    if not set(types[0]) & set(types[1]):
        return f"of another type: {' and '.join(types[0])} in A, {' and '.join(types[1])} in B"
    return ""


def topic_pairs(
    name: str, sequences: list[dict[str, Sequence]], align: str, offset: float, once: bool
) -> list[Pairs]:
    """Pair the messages of a topic."""
    a, b = (side[name] for side in sequences)
    origins = origin(sequences[0], name, sequences), origin(sequences[1], name, sequences)
    return pairing.pairs(a, b, align, round(offset * SECOND), origins, once)


def origin(side: dict[str, Sequence], name: str, sequences: list[dict[str, Sequence]]) -> int:
    """Return when a run began by the clock of a topic, ns."""
    own = side[name].stamp
    if own is None or not len(own):
        return 0
    stamped = [n for n in side if all(s[n].stamp is not None and len(s[n].receipt) for s in sequences)]
    begun = [int(stamp[0]) for n in stamped if (stamp := side[n].stamp) is not None]
    near = [time for time in begun if abs(time - int(own[0])) < OTHER_CLOCK]
    return min(near, default=int(own[0]))


def taken(found: Comparison, name: str, pairs: list[Pairs], first: Bag, second: Bag) -> None:
    """Take up a topic that is going to be compared, or why it can't be."""
    if not any(len(p.first) for p in pairs):
        what = {STAMP: "no stamp in common", ORDER: "nothing in common"}.get(
            pairs[0].by if pairs else "", "no time in common"
        )
        found.not_compared[name] = f"{what}; --align elapsed compares runs of different times"
        return
    found.topics[name] = Compared(
        name,
        ", ".join(dict.fromkeys(p.by for p in pairs)),
        0,
        sum(p.only_first for p in pairs),
        sum(p.only_second for p in pairs),
        sum(p.moved for p in pairs),
        pairing.crossed(pairs),
    )


def compare_pairs(
    first: Bag, second: Bag, pairs: dict[str, list[Pairs]], found: Comparison, progress: Progress
) -> None:
    """Compare the messages that belong together."""
    comparers = {name: comparer(first, second, found.topics[name]) for name in pairs}
    for piece in paired(first, second, pairs):
        if isinstance(piece, Piece):
            time = pairs[piece.topic][piece.group].time[piece.row : piece.row + len(piece.first)]
            comparers[piece.topic].add(time, piece.first, piece.second)
            progress(f"{piece.topic}, {time[-1] / SECOND:.0f} s compared")
        else:
            old = found.topics[piece]
            old.pairs, old.fields = 0, {}
    for name, some in pairs.items():
        # What can't be read when its turn comes is not the same.
        lacking = sum(len(p.first) for p in some) - found.topics[name].pairs
        if lacking:
            found.not_compared[f"{name} "] = f"{lacking} of its messages can't be read"
