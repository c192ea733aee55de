"""What each standard judges a door by: its furnace, its points, its limits, its classes.

Of these texts the FTP Code, A.754(18) and UL 10C's clause 5 were read where they are public (imorules.com,
shipregulations.com, a preview of UL 10C:2016); the others are known from summaries, and `unread` says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

Places = dict[str, tuple[float, float]]

FAHRENHEIT = 5.0 / 9.0
"""K of a rise by one degree Fahrenheit."""
EDGE_STRIP = 0.1
"""m from the leaf's edge, EN 1634-1 and ISO 3008's nearest points of the normal procedure."""
NEAR_EDGE = 0.025
"""m from the visible edge, EN 13501-2's points of class I1."""
FOOT = 0.305
"""m from the edge: UL 10B, UL 10C and ASTM E119 have no thermocouple nearer."""


def leaf_points(width: float, height: float) -> Places:
    """Centre and quarter centres: A.754(18) 7.5.1.1 and doors likewise, EN 1634-1 9.1.2.2."""
    x, y = 0.25 * width, 0.25 * height
    return {
        "ftp_centre": (0.0, 0.0),
        "ftp_upper_left": (-x, y),
        "ftp_upper_right": (x, y),
        "ftp_lower_left": (-x, -y),
        "ftp_lower_right": (x, -y),
    }


def edge_points(width: float, height: float, strip: float, prefix: str) -> Places:
    """Middles of the upright edges and of the top, and the top corners, `strip` m within the edge."""
    x, y = 0.5 * width - min(strip, 0.2 * width), 0.5 * height - min(strip, 0.2 * height)
    return {
        f"{prefix}_left_edge": (-x, 0.0),
        f"{prefix}_right_edge": (x, 0.0),
        f"{prefix}_top_edge": (0.0, y),
        f"{prefix}_top_left": (-x, y),
        f"{prefix}_top_right": (x, y),
    }


def en_points(width: float, height: float) -> Places:
    """100 mm within the edges: EN 1634-1 9.1.2.3."""
    return edge_points(width, height, EDGE_STRIP, "en")


def en_1_points(width: float, height: float) -> Places:
    """25 mm within the visible edges: EN 1634-1's supplementary procedure, EN 13501-2 class I1."""
    return edge_points(width, height, NEAR_EDGE, "en1")


def ul_points(width: float, height: float) -> Places:
    """At least three, one for each 16 square feet (1.5 m2), none within 12 in of the edge."""
    columns = max(1, math.ceil((width - 2.0 * FOOT) / 1.2))
    rows = max(math.ceil(3 / columns), math.ceil(width * height / 1.5 / columns))
    inside = max(0.0, 0.5 * width - FOOT), max(0.0, 0.5 * height - FOOT)
    places = {}
    for j in range(rows):
        for i in range(columns):
            x = width * ((i + 0.5) / columns - 0.5)
            y = height * ((j + 0.5) / rows - 0.5)
            at = min(max(x, -inside[0]), inside[0]), min(max(y, -inside[1]), inside[1])
            places[f"ul_{j * columns + i + 1}"] = at
    return places


def nine_points(width: float, height: float) -> Places:
    """Centre, quarter centres and four between, none within 12 in of the edge: ASTM E119."""
    x = min(0.25 * width, max(0.0, 0.5 * width - FOOT))
    y = min(0.25 * height, max(0.0, 0.5 * height - FOOT))
    return {f"astm_{3 * (j + 1) + i + 2}": (i * x, j * y) for j in (-1, 0, 1) for i in (-1, 0, 1)}


@dataclass(frozen=True)
class Rise:
    """A limit of temperature rise on the unexposed face.

    limit : K; of : sets of points; mean : of their mean, else of the hottest
    kind : which insulation class it belongs to, "" where every one needs it
    extra : whether the scene's own criteria.points count as well
    """

    name: str
    limit: float
    of: tuple[Callable[[float, float], Places], ...]
    mean: bool
    clause: str
    kind: str = ""
    extra: bool = False


@dataclass(frozen=True)
class Tolerance:
    """How far a furnace may be off its curve.

    area : "narrowing" (15 % to 10 min, down to 2.5 % at 60 min) or "american" (10, 7.5 and 5 % for tests to
        1 h, to 2 h and longer); since : s; each : °C, of any thermocouple after 10 min, or None
    """

    area: str
    since: float
    each: float | None
    clause: str


@dataclass(frozen=True)
class Standard:
    """One standard.

    curve : its furnace's, a key of furnace.CURVES; insulation : its kinds of I, the first one foremost
    minutes : of its list of classes
    integrity : min that E must hold whatever the class, or None where E and I are classified alike
    latch : UL's rule for the latch edge, instead of gap gauges
    beside : what it asks for that nothing here computes
    """

    key: str
    title: str
    mark: str
    curve: str
    tolerance: Tolerance
    rises: tuple[Rise, ...]
    minutes: tuple[int, ...]
    integrity: float | None
    integrity_clause: str
    classes_clause: str
    insulation: tuple[str, ...] = ("",)
    latch: bool = False
    radiation: bool = False
    beside: str = "cotton pad and flaming"
    unread: bool = True


_FTP_TOLERANCE = Tolerance("narrowing", 300.0, 100.0, "FTP Code 2010 part 3 app. 1, 8.3.1.3 and 8.3.1.4")
# The Code's 15 % begin at 0 min; judged here from 5 min on, as by EN 1363-1: before, an area tells little.
_EN_TOLERANCE = Tolerance("narrowing", 300.0, 100.0, "EN 1363-1 5.1.2")
_ISO_TOLERANCE = Tolerance("narrowing", 300.0, 100.0, "ISO 834-1 6.1.2")
_HYDROCARBON_TOLERANCE = Tolerance("narrowing", 300.0, 100.0, "EN 1363-2 4")
_FIVE, _EDGES = (leaf_points,), (leaf_points, en_points)
EN_MINUTES = (15, 20, 30, 45, 60, 90, 120, 180, 240)
UL_MINUTES = (20, 30, 45, 60, 90, 180)
UL_RISES = {250: 250.0 * FAHRENHEIT, 450: 450.0 * FAHRENHEIT, 650: 650.0 * FAHRENHEIT}
"""K of the rises of 250, 450 and 650 °F that a door may be classified by."""
UL_RISE_TIME = 1800.0
"""s at which UL 10B and UL 10C read the rise."""


def _ftp(letter: str, limit: float, minutes: tuple[int, ...], integrity: float, clause: str) -> Standard:
    return Standard(
        key=f"ftp_{letter.lower()}",
        title=f"FTP Code {letter}",
        mark=f"{letter}-",
        curve="iso_834",
        tolerance=_FTP_TOLERANCE,
        rises=(
            Rise("mean temperature rise", 140.0, _FIVE, True, f"FTP Code 2010 part 3, {clause}"),
            Rise(
                "maximum temperature rise", limit, _FIVE, False, f"FTP Code 2010 part 3, {clause}", extra=True
            ),
        ),
        minutes=minutes,
        integrity=integrity,
        integrity_clause="FTP Code 2010 part 3, 3.2.3 (gap gauges) and app. 1, 8.5",
        classes_clause=f"FTP Code 2010 part 3, {clause}",
        unread=False,
    )


def _ul(number: str) -> Standard:
    return Standard(
        key=f"ul_{number.lower()}",
        title=f"UL {number}",
        mark="",
        curve="astm_e119",
        tolerance=Tolerance("american", 0.0, None, f"UL {number} 5.4" if number == "10C" else "UL 10B 4.4"),
        rises=(
            Rise(
                "temperature rise at 30 min",
                UL_RISES[650],
                (ul_points,),
                False,
                f"UL {number}, unexposed rise",
                extra=True,
            ),
        ),
        minutes=UL_MINUTES,
        integrity=None,
        integrity_clause=f"UL {number}, conditions of acceptance: latch edge",
        classes_clause=f"UL {number}, ratings of NFPA 80",
        insulation=(),
        latch=True,
        beside="hose stream, through openings and flaming",
        unread=True,
    )


STANDARDS: dict[str, Standard] = {
    s.key: s
    for s in (
        _ftp("A", 180.0, (0, 15, 30, 60), 60.0, "3.1.1"),
        _ftp("B", 225.0, (0, 15), 30.0, "3.1.2"),
        _ftp("F", 225.0, (0, 15), 30.0, "3.1.2"),
        Standard(
            key="en_1634",
            title="EN 1634-1",
            mark="EI2 ",
            curve="iso_834",
            tolerance=_EN_TOLERANCE,
            rises=(
                Rise("mean temperature rise", 140.0, _FIVE, True, "EN 13501-2 class I1 and I2"),
                Rise("maximum temperature rise", 180.0, _EDGES, False, "EN 13501-2 class I2", "2", True),
                Rise(
                    "maximum temperature rise 25 mm from the edge",
                    180.0,
                    (leaf_points, en_points, en_1_points),
                    False,
                    "EN 13501-2 class I1",
                    "1",
                    True,
                ),
            ),
            minutes=EN_MINUTES,
            integrity=None,
            integrity_clause="EN 1363-1 11.1 (gap gauges)",
            classes_clause="EN 13501-2 7.5.5",
            insulation=("2", "1"),
            radiation=True,
            beside="cotton pad, flaming, and the frame's 360 K (I2) or 180 K (I1)",
        ),
        Standard(
            key="iso_834",
            title="ISO 834-1",
            mark="EI ",
            curve="iso_834",
            tolerance=_ISO_TOLERANCE,
            rises=(
                Rise("mean temperature rise", 140.0, _FIVE, True, "ISO 834-1 10.2.3"),
                Rise("maximum temperature rise", 180.0, _EDGES, False, "ISO 834-1 10.2.3", extra=True),
            ),
            minutes=EN_MINUTES,
            integrity=None,
            integrity_clause="ISO 834-1 10.2.2 (gap gauges)",
            classes_clause="ISO 834-1 12: minutes held; here the list of EN 13501-2",
        ),
        _ul("10B"),
        _ul("10C"),
        Standard(
            key="astm_e119",
            title="ASTM E119",
            mark="",
            curve="astm_e119",
            tolerance=Tolerance("american", 0.0, None, "ASTM E119 7.1.1"),
            rises=(
                Rise("mean temperature rise", 250.0 * FAHRENHEIT, (nine_points,), True, "ASTM E119, walls"),
                Rise(
                    "maximum temperature rise",
                    325.0 * FAHRENHEIT,
                    (nine_points,),
                    False,
                    "ASTM E119, walls",
                    extra=True,
                ),
            ),
            minutes=(20, 30, 45, 60, 90, 120, 180, 240),
            integrity=None,
            integrity_clause="ASTM E119, walls: no flame or gases through; judged here by a 6 mm gap",
            classes_clause="ASTM E119, hours of the building code",
            beside="hose stream, cotton waste and flaming",
        ),
        Standard(
            key="imo_h",
            title="IMO H",
            mark="H-",
            curve="hydrocarbon",
            tolerance=_HYDROCARBON_TOLERANCE,
            rises=(
                Rise(
                    "mean temperature rise",
                    140.0,
                    _FIVE,
                    True,
                    "H divisions as Norway's Facilities Regulations",
                ),
                Rise("maximum temperature rise", 180.0, _FIVE, False, "the same", extra=True),
            ),
            minutes=(0, 60, 120),
            integrity=120.0,
            integrity_clause="H divisions: smoke and flame kept back for two hours",
            classes_clause="H-0, H-60, H-120: Norway's Facilities Regulations (iadclexicon.org)",
        ),
    )
}
