"""What a scene may say of how its door is judged."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from flexsim_core.quantities import Misplaced, Part
from pydantic import BeforeValidator, Field, model_validator

from .quantities import NotNegative, Positive

StandardName = Literal[
    "ftp_a", "ftp_b", "ftp_f", "en_1634", "iso_834", "ul_10b", "ul_10c", "astm_e119", "imo_h"
]


def _several(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


Standards = Annotated[tuple[StandardName, ...], Field(min_length=1)]


class CriteriaPart(Part):
    """What the door is judged by.

    standard : one or several of standards.STANDARDS; left out, the FTP Code's class of `division`,
        and EN 1634-1 beside class A
    division : FTP Code division, the short form of standard: ftp_a, ftp_b, ftp_f
    minutes : time asked for
    points : of probes.points, thermocouples on the unexposed face that count beside the standards'
        own for the maximum rise
    mean_rise, maximum_rise : K; gap : m between leaf and frame; deflection : m; limits of one's own,
        judged beside the standards'
    """

    standard: Annotated[Standards | None, BeforeValidator(_several)] = None
    division: Literal["A", "B", "F"] | None = None
    minutes: Positive | None = None
    points: tuple[str, ...] = ()
    mean_rise: Positive | None = None
    maximum_rise: Positive | None = None
    gap: Positive | None = None
    deflection: Positive | None = None

    @model_validator(mode="after")
    def _one_way(self) -> CriteriaPart:
        if self.standard is None:
            return self
        if self.division is not None:
            raise Misplaced(("division",), "is given beside standard; give one of the two")
        return self

    @property
    def standards(self) -> tuple[str, ...]:
        """Names of the standards that judge, the first one foremost."""
        if self.standard is not None:
            return self.standard
        division = self.division or "A"
        return ("ftp_a", "en_1634") if division == "A" else (f"ftp_{division.lower()}",)


class SealsPart(Part):
    """What keeps the gap between leaf and frame closed; the scene's word, not computed.

    bridged : m of gap through the leaf's plane that the seals and the rebate close
    until : s after which they are gone; left out, never
    """

    bridged: NotNegative = 0.0
    until: Positive | None = None
