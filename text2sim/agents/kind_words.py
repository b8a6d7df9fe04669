"""Words that name kinds of the language."""

from collections.abc import Iterable
from functools import cache

from text2sim.agents.page_selection import BODY_WORDS
from text2sim.spec_schema.published.language_reference import section_kinds
from text2sim.spec_schema.published.reference_sections import SECTIONS


def known_kinds() -> frozenset[str]:
    """Return every kind of body, shape, mount, pattern and the like, and the names of prefabs."""
    from text2sim.spec_schema.reuse.catalogue import examples

    found = set(examples())
    for section in SECTIONS:
        if not isinstance(section.models, tuple):
            found |= set(section_kinds(section.models))
    return frozenset(found)


def kinds_in(words: Iterable[str]) -> set[str]:
    """Return the kinds that words name; inflected verbs count: `released` means `release`."""
    forms = _forms()
    return {kind for word in words for kind in forms.get(word, ())}


@cache
def _forms() -> dict[str, set[str]]:
    forms: dict[str, set[str]] = {}
    for kind in known_kinds():
        found = {kind, *(kind + end for end in ("s", "es", "ed", "ing"))}
        if kind.endswith("e"):
            found |= {kind + "d", kind + "n", kind[:-1] + "ing"}
        found |= {word + end for word in BODY_WORDS.get(kind, ()) for end in ("", "s")}
        for form in found:
            forms.setdefault(form, set()).add(kind)
    return forms
