"""Tool that looks up the language: pages of its reference, rules of the lint, prefabs."""

import re
from dataclasses import dataclass, replace
from functools import cache

from text2sim.lint.rules import RULES, find_rule
from text2sim.mcp_server.answers import MAX_PAGE, ToolAnswer, refusal, text_page
from text2sim.service.descriptions import describe_prefab, describe_rule
from text2sim.spec_schema.errors import did_you_mean
from text2sim.spec_schema.published.language_reference import language_reference
from text2sim.spec_schema.reuse.catalogue import library

_HEADING = re.compile(r"^(#{1,4}) (.+)$")
_LINK = re.compile(r"\[([^\]\n]+)\]\(#[^)\n]*\)")
_TABLE_RULE = re.compile(r"^\|(?:-+\|)+\n", re.MULTILINE)


@dataclass(frozen=True)
class Page:
    """A heading of the reference and the text below it, up to the next heading."""

    level: int
    title: str
    text: str
    above: tuple[str, ...]
    """Names of the headings above it."""

    @property
    def name(self) -> str:
        """Name for lookup: `rigid`, `materials, joints and looks`, `bodies`."""
        word = re.match(r"`(\w+)`", self.title)
        return (word[1] if word else self.title).lower()

    @property
    def path(self) -> str:
        """Its name after that of the heading above, which distinguishes pages of the same name."""
        return f"{self.above[-1]}/{self.name}" if self.above else self.name


def language(topic: str, offset: int) -> ToolAnswer:
    """Return the page of a topic; the list of pages without one."""
    words = topic.strip().lower().replace("`", "")
    if not words:
        return _index()
    found = _find_pages(words)
    if len(found) == 1:
        page = found[0]
        text = "\n".join([page.text, *(subpage.text for subpage in _subpages(page))])
        below = [subpage.name for subpage in _subpages(page)]
        document = {"topic": page.path}
        if len(text) > MAX_PAGE and below:
            text, document["pages_below"] = page.text, ", ".join(below)
        if page.above:
            document["see_also"] = page.above[-1]
        piece, part = text_page(text, offset)
        return ToolAnswer({**document, **part}, piece)
    if found:
        return ToolAnswer({"topic": words, "several": [page.path for page in found], "next": "ask for one of these"})
    if (rule := find_rule(words)) is not None:
        return ToolAnswer({"rule": rule.id, "severity": rule.severity}, describe_rule(rule))
    if (prefab := _prefab(words)) is not None:
        return ToolAnswer({"prefab": words}, prefab)
    known = [*(page.name for page in _pages()), *(rule.id for rule in RULES), *_prefab_names()]
    message = f"there is no page, rule or prefab `{words[:80]}`; without a topic, the pages are listed"
    return refusal(message + did_you_mean(words, known))


def _index() -> ToolAnswer:
    lines = []
    for page in _pages():
        if page.level in (2, 3):
            below = ", ".join(
                subpage.name for subpage in _subpages(page) if subpage.level == page.level + 1 and subpage.level != 3
            )
            lines.append(f"{'  ' * (page.level - 2)}{page.name}{': ' if below else ''}{below}")
    lines += ["", f"prefabs: {', '.join(_prefab_names())}", f"rules of the lint: {', '.join(r.id for r in RULES)}"]
    return ToolAnswer({"next": "ask for one of these, such as `rigid`, `shapes/box` or `tunnelling`"}, "\n".join(lines))


@cache
def _pages() -> tuple[Page, ...]:
    """The reference, split at its headings."""
    text = _TABLE_RULE.sub("", _LINK.sub(r"\1", language_reference()))
    pages: list[Page] = []
    lines: list[str] = []
    fenced = False
    for line in text.splitlines():
        fenced ^= line.startswith("```")
        heading = None if fenced else _HEADING.match(line)
        if heading is None:
            lines.append(line)
            continue
        _finish_page(pages, lines)
        level = len(heading[1])
        above = [page for page in pages if page.level < level and page.level > 1]
        chain: list[Page] = []
        for page in reversed(above):
            if page.level < (chain[-1].level if chain else level):
                chain.append(page)
        lines = [line]
        pages.append(Page(level, heading[2], "", tuple(page.name for page in reversed(chain))))
    _finish_page(pages, lines)
    return tuple(pages[1:])


def _finish_page(pages: list[Page], lines: list[str]) -> None:
    if pages:
        pages[-1] = replace(pages[-1], text="\n".join(lines).strip() + "\n")


def _find_pages(words: str) -> list[Page]:
    above, _, name = words.rpartition("/")
    above, name = above.strip(), name.strip()
    same = [page for page in _pages() if name in (page.name, page.title.lower().replace("`", ""))]
    if not same:
        same = [page for page in _pages() if len(name) > 3 and name in page.title.lower()]
    if not above:  # parts have the names of similar shapes
        return [page for page in same if not page.path.startswith("parts of")] or same
    below = [page for page in same if any(above.rpartition("/")[2] in name_above for name_above in page.above)]
    return [page for page in below if page.path == f"{above}/{name}"] or below


def _subpages(page: Page) -> list[Page]:
    found = []
    for other in _pages()[_pages().index(page) + 1 :]:
        if other.level <= page.level:
            break
        found.append(other)
    return found


@cache
def _prefab_names() -> tuple[str, ...]:
    return tuple(library().names())


def _prefab(name: str) -> str | None:
    """Description of a built-in prefab; None if there is none of that name."""
    return None if name not in _prefab_names() else describe_prefab(library().find(name))
