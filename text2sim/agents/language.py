"""Language reference for a role: the pages of its section, limited to kinds that its plan or instruction names.

A role can request more by name (`explanations`).
"""

import re
from collections.abc import Collection, Iterable
from functools import cache

from text2sim.agents.condensed_pages import (
    fields_named,
    first_sentence,
    kinds_brief,
    kinds_line_by_line,
    of_deformables,
    plain,
    prefab_brief,
    prefab_gist,
    section_brief,
)
from text2sim.agents.kind_words import kinds_in
from text2sim.agents.page_rows import (
    without_belts,
    without_copies,
    without_deformables,
    without_examples,
    without_rare_rows,
)
from text2sim.agents.page_selection import (
    ALWAYS_DESCRIBED,
    BELT,
    CONTROL_WORDS,
    COPIES,
    DEFORMABLE_KINDS,
    EVERYDAY_KINDS,
    FIELD_CONTROLS,
    FULLY_DESCRIBED,
    INDEXED_PAGES,
    KINDS_BY_MODEL,
    KINDS_BY_PAGE,
    PAGES_BY_READER,
    PLACING_WORDS,
    PLANNER_PAGES,
    TURNING_WORDS,
)
from text2sim.spec_schema.names.soft_measure_references import BONDED_KINDS
from text2sim.spec_schema.published.language_reference import load_examples, section_kinds
from text2sim.spec_schema.published.reference_prose import INTRODUCTION
from text2sim.spec_schema.published.reference_sections import SECTIONS, ReferenceSection
from text2sim.spec_schema.vocabulary.docstrings import model_doc

COLORS_NOTE = (
    "Colours: `#rrggbb`, or a name: those of CSS, and of materials (`oak`, `walnut`, `concrete`, `brass`, `steel`, "
    "`terracotta`, `rubber`, `cream`)."
)
MORE_KINDS_NOTE = "For measures, events and expectations of your own, `read` the kind"
PLACES_PAGE = (
    "Or `place`, one of the two, by true shapes: `on: table` (let down until it touches), `inside: cup`, `above`, "
    "`below`, `left_of`, `right_of`, `in_front_of`, `behind` (side against side), `beside: wall`, `around: pole`, "
    "`touching: egg` with `direction: [1, 1, 0]`; in its frame: `relative_to: ramp` with `pos`, `euler_deg`. What is "
    "open is their middle, or `at: [x, y]` in the world, `at: {corner: [left, front]}` with `inset`, `align`; then "
    '`offset`, `clearance`. Copies: one pattern; `on: "plate[*]"` puts one on each. More: `read: [Poses and places]`.'
)
STATIC_PLACES_PAGE = (
    "Or `place`, one of the two, by true shapes: `on: table`, `above`, `beside: wall`, `relative_to: ramp` and others, "
    "with `at: [x, y]` in the world, `offset`, `clearance`. More: `read: [Poses and places]`."
)
EXPECTATIONS_PAGE = (
    "## Expectations\nOf an event, which happens: `within: [0.3, end]` (its first time), `count: 3` or `[2, 5]`, "
    "`before` another event; or `never` does (`within` a span). Of a measure, which is `above`, `below`, `equals` with "
    "`tolerance`: `at: 1.5`, `start` or `end`, or `during: [0.5, end]` or `all`, then every value or `stat` of them "
    "(max, min, mean, std, range, change; with `swing: 0.05`, the smallest that counts: reversals, two in a full "
    "swing, period of one, decrement, the logarithmic one). `on: EVENT`: these times count from its first (`on: hit, "
    "during: [0, 0.5]`), which is better than a guess. `repeat: 3`: so many of this entry, `NAME_0` to `NAME_2`, with "
    "`k` in `${…}`."
)
"""The Planner's page about expectations; its prompt has examples."""
MIN_DESCRIPTION = 42
"""Smallest length of a description that says more than the kind's name [characters]."""
MIN_FIELD_WORD = 4
"""Smallest length of a word that may name a field [characters]."""
MAX_PAGES_SIZE = 14_000
"""Largest size of the pages in one reply [characters]."""


def reference_pages(reader: str, kinds: Collection[str] | None = None) -> str:
    """Return the language reference for one reader.

    Args:
        reader: A key of `PAGES_BY_READER`.
        kinds: Kinds to describe; the other kinds of bodies, shapes and so on are only named. Default: all.
    """
    wanted = None if kinds is None else ALWAYS_DESCRIBED | set(kinds)
    parts = [page for section in _sections(PAGES_BY_READER[reader]) if (page := _page(section, reader, wanted))]
    if wanted is not None and reader == "actions":
        kinds = kinds_to_expect_with(deformable=bool(wanted & DEFORMABLE_KINDS))
        parts.append(f"{MORE_KINDS_NOTE}, or `Expectations`: {kinds}.")
    if reader in ("scene", "bodies"):
        parts.append(COLORS_NOTE)
    text = "\n\n".join(parts)
    if wanted is None:
        return text
    text = without_rare_rows(text, of_statics=reader == "scene")
    text = text if BELT in wanted else without_belts(text)
    text = text if COPIES & wanted else without_copies(text)
    return text if wanted & DEFORMABLE_KINDS else without_deformables(text)


def _page(section: ReferenceSection, reader: str, wanted: Collection[str] | None) -> str:
    """Return a page, limited to the wanted kinds; empty if these do not need it."""
    tabled = isinstance(section.models, tuple)
    only = _models(section, wanted) if tabled else wanted
    if wanted is None:
        return section_brief(section, only)
    needs = KINDS_BY_PAGE.get(section.title, wanted)  # pages that are not listed there are for every plan
    planned = reader == "actions" and section.title in PLANNER_PAGES
    if not set(needs) & set(wanted) or (tabled and not only):
        return ""
    if planned and (tabled or not set(wanted) & set(section_kinds(section.models))):
        return ""
    if section.title == "Poses and places":
        pose = _EXAMPLES_OF_PLACE.sub("", section_brief(section, {"Pose"}, intro=False))
        return f"{pose}\n{PLACES_PAGE if reader == 'bodies' else STATIC_PLACES_PAGE}"
    return section_brief(section, only)


@cache
def to_plan_with() -> str:
    """Return the Planner's reference of measures, events and expectations: a line and an example for each kind."""
    parts = []
    for section in _sections(PAGES_BY_READER["expectations"]):
        tabled = isinstance(section.models, tuple)
        parts.append(EXPECTATIONS_PAGE if tabled else kinds_line_by_line(section))
    return "\n\n".join(parts)


@cache
def kinds_to_expect_with(*, deformable: bool = True) -> str:
    """Return the names of kinds of measures and of events; those of deformable bodies alone only if `deformable`."""
    (section,) = _sections(("Measures",))
    soft = {kind for kind, model in section_kinds(section.models).items() if of_deformables(model)} - {*BONDED_KINDS}
    return ", ".join(kind for kind in measured_kinds() if deformable or kind not in soft)


@cache
def measured_kinds() -> tuple[str, ...]:
    """Return the kinds of measures and of events."""
    return tuple(kind for title in ("Measures", "Events") for kind in _kinds_of(title))


def schedules_in_examples(controls: Collection[str]) -> set[str]:
    """Return the kinds of schedules in the examples of some controls."""
    examples, schedules = load_examples()["controls"], _kinds_of("Schedules")
    used = {kind for control in controls for kind in re.findall(r"kind: (\w+)", examples.get(control, ""))}
    return used & set(schedules)


def _models(section: ReferenceSection, wanted: Collection[str] | None) -> set[str]:
    """Names of the models of a page that the wanted kinds need."""
    names = [model.__name__ for model in section.models]
    if wanted is None or len(names) == 1 and names[0] not in KINDS_BY_MODEL:
        return set(names)
    return {
        name
        for name in names
        if name in KINDS_BY_MODEL and (not KINDS_BY_MODEL[name] or KINDS_BY_MODEL[name] & set(wanted)) or name in wanted
    }


def named_reference(reader: str, text: str, present_kinds: Collection[str] = ()) -> str:
    """Return the reference for an instruction: named kinds with all fields, and named fields of other models.

    Controls are also named by everyday words for them, and those that are everyday words by backquotes.

    Args:
        reader: A key of `PAGES_BY_READER`.
        text: The instruction.
        present_kinds: Kinds that the section has already. Fields of models that belong to neither these nor named kinds
            are omitted.
    """
    words = set(re.findall(r"[a-z][a-z_0-9]*", _UNCHANGED_CLAUSE.sub("", text.lower())))
    named = kinds_in(words) - EVERYDAY_KINDS
    if reader == "actions":
        named |= {kind for kind, meant in CONTROL_WORDS.items() if meant & words}
        named |= set(re.findall(r"`([a-z_]+)`", text))
    wanted = kinds_in(words) | set(present_kinds)
    parts = []
    for section in _sections(PAGES_BY_READER[reader]):
        rows: list[str] = []
        needs = KINDS_BY_PAGE.get(section.title)
        if section.title == "Poses and places":
            rows = _places(reader, words)
        elif isinstance(section.models, tuple):
            if needs is None or needs & (wanted | words):
                long = {word for word in words if len(word) >= MIN_FIELD_WORD}
                rows = fields_named(section, long, _models(section, wanted), words & FULLY_DESCRIBED)
        elif kinds := named & set(section_kinds(section.models)):
            rows = kinds_brief(section, kinds)
        if rows:
            parts.append("\n".join([f"## {section.title}", *rows]))
    found = "\n\n".join(parts)
    return found if wanted & DEFORMABLE_KINDS else without_deformables(found)


def _places(reader: str, words: Collection[str]) -> list[str]:
    """Rows about poses and places, for an instruction that moves, turns or adds something."""
    if not (PLACING_WORDS | TURNING_WORDS) & set(words):
        return []
    (section,) = _sections(("Poses and places",))
    pose = _EXAMPLES_OF_PLACE.sub("", section_brief(section, {"Pose"}, intro=False)).partition("\n")[2]
    relations = PLACES_PAGE if reader == "bodies" else STATIC_PLACES_PAGE
    return [pose, relations] if PLACING_WORDS & set(words) else [pose]


def explanations(names: Iterable[str], before: Collection[str] = (), *, examples: bool = True) -> tuple[str, list[str]]:
    """Return pages about kinds, prefabs and models, within the size limit, and the names that were served.

    Args:
        names: Names that were asked for.
        before: Names that were served earlier; they are skipped.
        examples: Whether to keep examples of kinds other than those that the Planner writes.
    """
    parts: list[str] = []
    served: list[str] = []
    heads: set[str] = set()
    left = list(dict.fromkeys(name for name in names if name not in before))
    while left:
        text = explanation(left[0], examples)
        head, mark, rest = text.partition(f"- `{left[0]}`")
        if mark and head in heads:  # the shared fields of kinds of one page, once
            text = head[: head.index("\n") + 1] + mark + rest
        heads.add(head)
        if text and parts and sum(map(len, parts)) + len(text) > MAX_PAGES_SIZE:
            break
        name = left.pop(0)
        parts.append(text or f"There is nothing called `{name}`.")
        served.append(name)
    if left:
        parts.append(f"No room for {', '.join(f'`{name}`' for name in left)}: ask for fewer at once.")
    return "\n\n".join(parts), served


@cache
def explanation(name: str, examples: bool = True) -> str:
    """Return the full reference of a kind, a prefab or a page; empty if the name is unknown.

    Args:
        name: The name.
        examples: Whether to keep examples of kinds other than those that the Planner writes.
    """
    parts = []
    # Who asks for a shape does not mean its namesakes, which are on pages of their own.
    namesakes = ("Shapes of cloth", "Parts of a sculpt") if name in _kinds_of("Shapes") else ()
    for section in (one for one in SECTIONS if one.title not in namesakes):
        if isinstance(section.models, tuple):
            models = [model for model in section.models if model.__name__.lower() == name.lower()]
            if models or section.title.strip("`").lower() == name.lower():
                parts.append(section_brief(section, {model.__name__ for model in models} or None, intro=not models))
            elif examples and KINDS_BY_PAGE.get(section.title) == {name}:  # what its parts are made of
                parts.append(section_brief(section))
        elif name in section_kinds(section.models):
            page = "\n".join([f"## {section.title}", *kinds_brief(section, {name})])
            parts.append(page if examples or section.title in PLANNER_PAGES else without_examples(page))
            if section.title == "`bodies`: the actors" and (own := _own_material(name)):
                parts.append(own)
        elif section.title.lower().removesuffix("s") == name.lower().removesuffix("s"):
            parts.append(section_brief(section))
    prefab = prefabs(only={name})
    return "\n\n".join([*parts, *([f"## Prefab `{name}`\n{prefab}"] if prefab else [])])


def _own_material(kind: str) -> str:
    """Return the fields of the material of a kind of deformable body: most of what it can do is said there."""
    (section,) = _sections(("Materials of deformable bodies",))
    models = {model.__name__ for model in section.models if kind in KINDS_BY_MODEL.get(model.__name__, ())}
    return section_brief(section, models, intro=False).partition("\n")[2] if models else ""


@cache
def rules(*, brief: bool = False, reader: str = "") -> str:
    """Return the rules of the language, expressions and selectors.

    Args:
        brief: For authors whose answers are checked.
        reader: With `brief`, the section that they write, if it is one.
    """
    if brief:
        return _BRIEF_RULES + _JOINT_RULES * (reader not in _JOINTLESS_READERS)
    from text2sim.spec_schema.published.language_reference import language_reference

    whole = language_reference()
    start = whole.index("## Rules of the whole language")
    end = whole.index("## The case\n")
    assert INTRODUCTION[:40] in whole
    return plain(whole[start:end])


_BRIEF_RULES = """\
SI units (m, kg, s, N, rad); degrees only where a field ends in `deg`. z is up, left is -x, in front is -y; quaternions
are (w, x, y, z). A positive turn about y carries the +x side down, about x the +y side up, about z +x towards +y.
Names are of letters, digits and `_`. Unknown fields are errors; `*` marks required ones.
`${…}` is arithmetic over `params`: + - * / // % **, comparisons, `a if c else b`, `list[0]`, sin, cos, tan, asin, acos,
atan2, sqrt, abs, min, max, radians, degrees, pi. In copies (`repeat`) also `i`, `n`, `u` (0 to 1), `row`, `column`,
`layer`; in other repeats `k`. Selectors: `brick` or `brick[*]` every copy, `brick[3]`, `brick[2:5]`, `arm.hand` a
link or joint, in `of` also a list."""
_JOINT_RULES = """ The joint of a rigid body on a hinge or slider goes by the body's name, that of an articulated
body by its link; its position counts from the start."""
_JOINTLESS_READERS = ("scene", "render")
"""Readers whose sections name no joints."""


@cache
def vocabulary() -> str:
    """Return the vocabulary of a plan: a line for each kind of body, shape, mount, control, camera, and each prefab."""
    parts, listed = [], set[type]()
    for section in _sections(INDEXED_PAGES):
        kinds = section_kinds(section.models)
        fresh = {kind: model for kind, model in kinds.items() if kind not in FIELD_CONTROLS and model not in listed}
        rows = _gist_rows({kind: first_sentence(model_doc(model)) for kind, model in fresh.items()})
        listed |= {*kinds.values()}
        if some := [f"`{kind}`" for kind in kinds if kind in FIELD_CONTROLS]:
            rows.append(f"- {', '.join(some)}: fields of force, on mpm and pbd bodies alone")
        parts.append(f"{section.title}\n" + "\n".join(rows))
    return "\n\n".join([*parts, "Prefabs (`use: NAME` in bodies or statics)\n" + prefabs(brief=True)])


def prefabs(*, brief: bool = False, only: Collection[str] | None = None) -> str:
    """List the prefabs, with their parameters unless `brief`."""
    from text2sim.spec_schema.reuse.catalogue import built_in

    chosen = {name: definition for name, definition in built_in().items() if only is None or name in only}
    if brief:
        return "\n".join(_gist_rows({name: prefab_gist(definition) for name, definition in chosen.items()}))
    return "\n".join(prefab_brief(definition, explained=only is not None) for definition in chosen.values())


def _gist_rows(gists: dict[str, str]) -> list[str]:
    """One line for each kind that needs an explanation, and one line with the names of the others."""
    explained = {name: gist for name, gist in gists.items() if len(gist) >= MIN_DESCRIPTION}
    rows = [f"- `{name}`: {gist}" for name, gist in explained.items()]
    rest = [f"`{name}`" for name in gists if name not in explained]
    return [*([f"- {', '.join(rest)}"] if rest else []), *rows]


def body_kinds() -> tuple[str, ...]:
    """Return the kinds of bodies."""
    return _kinds_of("`bodies`: the actors")


def shape_kinds() -> tuple[str, ...]:
    """Return the kinds of shapes, of bodies and of cloth."""
    return tuple(dict.fromkeys([*_kinds_of("Shapes"), *_kinds_of("Shapes of cloth")]))


@cache
def shapes_of(body: str) -> tuple[str, ...]:
    """Return the kinds of shapes that a kind of body, or a static, accepts; empty if it has no shape of its own."""
    from text2sim.spec_schema.models.scene import Static
    from text2sim.spec_schema.vocabulary.words import slot_of

    (section,) = _sections(("`bodies`: the actors",))
    model = Static if body == "static" else section_kinds(section.models).get(body)
    field = None if model is None else model.model_fields.get("shape")
    return () if field is None else tuple(slot_of(field.annotation, field.metadata).models)


def mount_kinds() -> tuple[str, ...]:
    """Return the kinds of mounts."""
    return _kinds_of("Mounts")


@cache
def _kinds_of(title: str) -> tuple[str, ...]:
    (section,) = _sections((title,))
    return tuple(section_kinds(section.models))


def _sections(titles: Iterable[str]) -> list[ReferenceSection]:
    by_title = {section.title: section for section in SECTIONS}
    return [by_title[title] for title in titles]


_UNCHANGED_CLAUSE = re.compile(
    r"\b(?:keep(?:ing)?|nothing else|do(?: not|n't) (?:touch|change|move)|without (?:touching|changing|moving))\b[^.;]*"
    r"|\b(?:leav(?:e|ing) )[^.;]*\b(?:alone|as (?:it|they)|untouched|unchanged)\b[^.;]*"
)
"""Clauses about parts that must not change."""
_EXAMPLES_OF_PLACE = re.compile(r"^  e\.g\. `place: .*\n?", re.MULTILINE)
"""Examples that `PLACES_PAGE` replaces."""
