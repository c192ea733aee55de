"""Sphinx: the pages of the checkout and a reference from docstrings, as one site (`make docs`)."""

from __future__ import annotations

import re
from typing import Any

from docutils.nodes import SkipNode
from latex2mathml.converter import convert
from pygments.lexers.special import TextLexer

project = "flexsim"
copyright = "the authors of flexsim, Apache-2.0"
extensions = ["myst_parser", "sphinx.ext.autodoc"]

# README.md is the first page. Pages link to each other and to files of the checkout by relative paths.
root_doc = "README"
include_patterns = [
    "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md", "docs/theory/*.md", "docs/site/*.rst",
    "examples/README.md",
]  # fmt: skip
exclude_patterns = ["docs/accuracy/**", "**/.venv*/**"]
CONTENTS = """

```{toctree}
:hidden:
:caption: The programs
docs/robot
docs/frames
docs/import
docs/many_runs
docs/learning
docs/node
docs/door
docs/door_verdict
docs/door_supports
docs/materials
docs/thermal_node
docs/bags
docs/controllers
docs/lockstep
docs/ros2_control
docs/network
docs/sweep
```

```{toctree}
:hidden:
:caption: How good it is
docs/validation
docs/accuracy
docs/hard_cases
docs/finite_elements_two_point
docs/finite_elements_triangle
```

```{toctree}
:hidden:
:caption: Theory
:glob:
docs/theory/README
docs/theory/*
```

```{toctree}
:hidden:
:caption: For programmers
examples/README
docs/site/api
CONTRIBUTING
docs/architecture
docs/testing
docs/dependencies
CHANGELOG
```
"""

myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 4
suppress_warnings = ["toc.not_included"]
rst_epilog = ".. |stored - in| replace:: \\|stored - in\\|"  # a docstring's absolute value is no reference

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings give types with shapes and units

html_theme = "furo"
html_title = "flexsim"
html_extra_path = ["first_page"]  # index.html, which leads to README.html
html_copy_source = False
html_math_renderer = "mathml"
TAG = re.compile(r"\\tag\{(\w+)\}")


def add_contents(app: Any, docname: str, source: list[str]) -> None:
    """Give the first page its list of all others, which on GitHub are links in its text."""
    if docname == root_doc:
        source[0] += CONTENTS


def as_lists(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Turn the sections of a docstring into lists, each line as it is written.

    Ours tell several names in one entry (`mass, damping : (n, n); force : (n, i)`), which napoleon loses.
    """
    out: list[str] = []
    inside = ended = False
    for line, after in zip(lines, [*lines[1:], ""], strict=True):
        if line and not line.strip("-"):
            out.append("")
        elif after and not after.strip("-"):
            out += ["", f".. rubric:: {line}"]
            inside, ended = True, False
        elif not inside or not line.strip():
            out.append(line)
            ended = inside
        elif line[0].isspace():
            out.append(f"  {line.strip()}")
        elif ended and " : " not in line:
            out.append(line)
            inside = False
        else:
            names, colon, rest = line.partition(" : ")
            out.append(f"* ``{names}`` : {rest}" if colon else f"* {line}")
    lines[:] = out


def write_formula(writer: Any, node: Any) -> None:
    """Write a formula within a line as MathML, which browsers show without any program or network."""
    writer.body.append(convert(node.astext()))
    raise SkipNode


def write_equation(writer: Any, node: Any) -> None:
    """Write a formula of its own, with its number."""
    found = TAG.search(node.astext())
    number = f'<span id="{found[1]}">({found[1]})</span>' if found else ""
    formula = convert(TAG.sub("", node.astext()), display="block")
    style = "display: flex; align-items: center; gap: 1em; overflow: auto hidden; margin: 1em 0"
    writer.body.append(f'<div style="{style}"><div style="flex: 1">{formula}</div>{number}</div>')
    raise SkipNode


def setup(app: Any) -> None:
    """Connect."""
    app.add_html_math_renderer("mathml", (write_formula, None), (write_equation, None))
    app.connect("autodoc-process-docstring", as_lists)
    app.connect("source-read", add_contents)
    app.add_lexer("mermaid", TextLexer)  # diagrams, which GitHub draws, stay text
