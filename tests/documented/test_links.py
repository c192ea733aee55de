"""Every relative link of the pages leads somewhere: files, folders, images, headings."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        *ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "theory").glob("*.md"),
        *(ROOT / "examples").glob("*.md"),
    ]
)  # fmt: skip
FENCE = re.compile(r"^(```+).*?^\1", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)")
HEADING = re.compile(r"^#{1,6} (.+?)\s*#*$", re.MULTILINE)


def anchors(text: str) -> set[str]:
    """The names that GitHub gives a page's headings."""
    found: dict[str, int] = {}
    names = set()
    for heading in HEADING.findall(FENCE.sub("", text)):
        shown = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
        name = re.sub(r"[^\w\- ]", "", shown.lower()).replace(" ", "-")
        again = found.get(name, -1) + 1
        found[name] = again
        names.add(f"{name}-{again}" if again else name)
    return names


def broken(page: Path) -> list[str]:
    """The relative links of a page that lead nowhere."""
    out = []
    for link in LINK.findall(re.sub(r"`[^`\n]*`", "", FENCE.sub("", page.read_text()))):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if not target.exists() or not target.is_relative_to(ROOT):
            out.append(f"{link}: is not there")
        elif anchor and anchor not in anchors(target.read_text()):
            out.append(f"{link}: has no such heading")
    return out


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    assert not broken(page)


def test_a_broken_link_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(broken.__globals__, "ROOT", tmp_path)
    (tmp_path / "b.md").write_text(
        "# A `name`, and (more)\n\n## Twice\n\n## Twice\n\n```\n# no heading\n```\n"
    )
    (tmp_path / "a.md").write_text(
        "[1](b.md) [2](b.md#a-name-and-more) [3](b.md#twice-1) [4](https://x.y/z) `[no](link.md)`\n"
        "```\n[no](link.md)\n```\n[bad](c.md) [bad](b.md#no-heading) ![bad](x.png) [bad](../outside.md)\n"
    )
    assert [link.partition(":")[0] for link in broken(tmp_path / "a.md")] == [
        "c.md", "b.md#no-heading", "x.png", "../outside.md",
    ]  # fmt: skip


def test_every_page_is_in_the_sites_contents() -> None:
    """A page that the site does not list is found by nobody."""
    site = (
        ROOT / "docs" / "site" / "conf.py"
    ).read_text()  # it imports what is installed for `make docs` only
    contents = site.partition('CONTENTS = """')[2].partition('"""')[0]
    listed = {
        *re.findall(r"^(\S+)$", contents, re.MULTILINE),
        *re.findall(r'^root_doc = "(\w+)"$', site, re.MULTILINE),
    }
    assert "docs/theory/*" in listed
    for page in PAGES:
        name = str(page.relative_to(ROOT).with_suffix(""))
        assert name in listed or name.startswith("docs/theory/"), f"add {name} to docs/site/conf.py"
