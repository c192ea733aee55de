"""The page: sections of figures, tables and pictures, as one HTML file that needs nothing else."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, "Liberation Sans", Arial, sans-serif; color: #22262e; background: #fff;
       max-width: 64rem; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.7rem; margin: 0 0 .2rem; } h2 { font-size: 1.2rem; margin: 2.4rem 0 .4rem;
       border-bottom: 2px solid #22262e; padding-bottom: .2rem; }
.about { color: #5c6370; margin: 0 0 1rem; }
.verdict { font-size: 1.15rem; border-left: .4rem solid #c2453c; background: #faf3f2; padding: .5rem 1rem; }
table { border-collapse: collapse; margin: .8rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .18rem .8rem; text-align: left; border-bottom: 1px solid #d9dce1; vertical-align: top; }
th { font-weight: 600; border-bottom: 1px solid #22262e; white-space: nowrap; } td.n { text-align: right; }
.missing { color: #8a4b00; background: #fff6e8; border-left: .3rem solid #e0a040; padding: .4rem .8rem; }
.note { color: #5c6370; font-size: .9rem; } svg { max-width: 100%; height: auto; display: block; }
@media print { body { margin: 0; max-width: none; } h2, svg, table { break-inside: avoid; } }
"""


@dataclass
class Section:
    """One section: a title, and what stands in it, in order."""

    title: str
    parts: list[str] = field(default_factory=list)
    gaps: list[str] = field(default_factory=list)

    def say(self, words: str) -> None:
        """Add a sentence that explains."""
        self.parts.append(f'<p class="note">{html.escape(words)}</p>')

    def missing(self, words: str) -> None:
        """Say what the bag does not hold."""
        self.gaps.append(words)
        self.parts.append(f'<p class="missing">{html.escape(words)}</p>')

    def verdict(self, words: str) -> None:
        """Add what matters most."""
        self.parts.append(f'<p class="verdict">{html.escape(words)}</p>')

    def table(self, head: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
        """Add a table; numbers are set flush right."""
        top = "".join(f"<th>{html.escape(name)}</th>" for name in head)
        body = "".join("<tr>" + "".join(cell(value) for value in row) + "</tr>" for row in rows)
        self.parts.append(f"<table><tr>{top}</tr>{body}</table>")

    def picture(self, svg: str) -> None:
        """Add a picture."""
        self.parts.append(svg)


def cell(value: Any) -> str:
    """Return a table's cell."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f'<td class="n">{number(value)}</td>'
    return f"<td>{html.escape(str(value))}</td>"


def number(value: float) -> str:
    """Return a number as people read it: four digits."""
    if value == value and abs(value) < 1e9 and value == int(value):
        return str(int(value))
    return f"{value:.4g}" if value == value else "–"


def page(title: str, about: str, sections: Sequence[Section]) -> str:
    """Return the whole file."""
    body = "".join(f"<section><h2>{html.escape(s.title)}</h2>{''.join(s.parts)}</section>" for s in sections)
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style></head>'
        f'<body><h1>{html.escape(title)}</h1><p class="about">{html.escape(about)}</p>{body}</body></html>\n'
    )
