"""What a role reads of the language: the pages of its section, in full only for the kinds that its plan names.

The pages are those of `docs/language.md`, made from the models, so a prompt cannot say other than the checker does.
"""

import re
from collections.abc import Collection, Iterable
from functools import cache

from text2sim.spec_schema.published.language_reference import section_kinds, section_text
from text2sim.spec_schema.published.reference_sections import INTRODUCTION, SECTIONS, Section
from text2sim.spec_schema.vocabulary.docstrings import model_doc

OWN_COLORS = ("aluminium", "amber", "asphalt", "bone", "brass", "brick", "bronze", "clay", "concrete", "copper",
              "cork", "cream", "emerald", "grass", "iron", "marble", "mustard", "oak", "pine", "rubber", "rust", "sand",
              "slate", "steel", "stone", "terracotta", "walnut", "water", "wood")  # fmt: skip
"""Colours that CSS has no name for."""
PLACING = ("Poses and places", "Copies")
READS: dict[str, tuple[str, ...]] = {
    "scene": ("`scene`: the stage", "Statics", "Copies", "Settings of the scene", "Solvers of deformable bodies",
              "Shapes", "Poses and places", "Materials, joints and looks"),
    "bodies": ("`bodies`: the actors", "Mounts", "Parts of articulated bodies and chains", "Motions", "Shapes",
               "Shapes of cloth", "Parts of a compound", *PLACING, "Regions of space",
               "Materials, joints and looks", "Materials of deformable bodies"),
    "actions": ("`actions`: the script", "Controls", "Schedules", "Measures", "Events", "Expectations",
                "Regions of space", "Regions on bodies"),
    "expectations": ("Measures", "Events", "Expectations", "Regions of space"),
    "render": ("`render`: the film", "Shots and overlays", "Cameras", "Lights"),
}  # fmt: skip
"""Titles of the pages that each reader gets."""
INDEXED = ("`bodies`: the actors", "Shapes", "Shapes of cloth", "Mounts", "Controls", "Copies", "Cameras")
"""Pages of which the Planner sees what kinds there are."""
NARROWED: dict[str, tuple[str, ...]] = {
    "scene": ("Shapes", "Copies"),
    "bodies": ("`bodies`: the actors", "Shapes", "Shapes of cloth", "Mounts", "Motions", "Copies"),
    "actions": ("Measures", "Events", "Controls"),
    "expectations": (),
    "render": (),
}
"""Pages on which only the kinds that are needed are described in full."""
DEFORMABLE = frozenset({"soft", "cloth", "granular", "liquid", "snow"})
ALWAYS = frozenset(
    {"rigid", "box", "sphere", "cylinder", "plane", "sheet", "line", "grid", "constant", "ramp", "still"}
    | {"drive", "initial_velocity", "force", "impulse", "attach", "release"}
)
"""Kinds that are described to everybody: nearly every case has them."""
_LINK = re.compile(r"\[([^\]\n]+)\]\(#[^)\n]*\)")
_RULE = re.compile(r"^\|(?:-+\|)+\n", re.MULTILINE)


def pages(reader: str, kinds: Collection[str] | None = None) -> str:
    """Return what one reader has to know of the language.

    Args:
        reader: A key of `READS`.
        kinds: Kinds that will be needed: of the other kinds of bodies, shapes and so on there is one line. All are
            described if left out.
    """
    wanted = None if kinds is None else ALWAYS | set(kinds)
    soft = wanted is None or bool(wanted & DEFORMABLE)
    jointed = wanted is None or bool(wanted & {"articulated", "hinge", "slider", "ball", "rope", "chain"})
    parts = []
    for section in _sections(READS[reader]):
        if section.title.endswith("deformable bodies") and not soft:
            continue
        if section.title == "Parts of articulated bodies and chains" and not jointed:
            continue
        if section.title == "Shapes of cloth" and not (wanted is None or "cloth" in wanted):
            continue
        if section.title == "Motions" and not (wanted is None or "driven" in wanted):
            continue
        narrow = wanted if section.title in NARROWED[reader] else None
        parts.append(_plain(section_text(section, narrow)))
    if reader in ("bodies", "scene"):
        parts.append(f"Colours: `#rrggbb`, or a name: those of CSS, and {', '.join(OWN_COLORS)}.\n")
    return "\n".join(parts)


def controls(kinds: Collection[str]) -> str:
    """Return what there is to know of some kinds of controls; nothing if none of the kinds is one."""
    (section,) = _sections(("Controls",))
    return _plain(section_text(section, kinds)) if set(kinds) & set(section_kinds(section.models)) else ""


@cache
def rules() -> str:
    """The rules of the whole language, expressions and selectors."""
    from text2sim.spec_schema.published.language_reference import language_reference

    whole = language_reference()
    start = whole.index("## Rules of the whole language")
    end = whole.index("## The case\n")
    assert INTRODUCTION[:40] in whole
    return _plain(whole[start:end])


@cache
def vocabulary() -> str:
    """What can be planned with: a line for each kind of body, shape, mount, control, camera, and for each prefab."""
    parts = []
    for section in _sections(INDEXED):
        rows = [f"- `{kind}`: {_first(model_doc(model))}" for kind, model in section_kinds(section.models).items()]
        parts.append(f"{section.title}\n" + "\n".join(rows))
    return "\n\n".join([*parts, "Prefabs (`use: NAME` in bodies or statics)\n" + prefabs(brief=True)])


def prefabs(*, brief: bool = False, only: Collection[str] | None = None) -> str:
    """Say which prefabs there are, with their parameters unless `brief`."""
    from text2sim.spec_schema.reuse.catalogue import built_in, param_rows, parts_of, usage

    rows = []
    for name, definition in built_in().items():
        if only is not None and name not in only:
            continue
        line = f"- `{name}`: {_first(' '.join(definition.model.doc.split()))}"
        if not brief:
            line += ". " + " ".join(
                f"`{row.name}` ({row.takes}; {row.default or 'required'})" for row in param_rows(definition)
            )
            if several := parts_of(definition):
                line += f" Bodies: {', '.join(f'NAME_{part}' for part in several)}."
            line += f"\n  ```yaml\n{_indented(usage(definition))}  ```"
        rows.append(line)
    return "\n".join(rows)


def known_kinds() -> frozenset[str]:
    """Every kind of body, shape, mount, pattern and the like, and the names of prefabs."""
    from text2sim.spec_schema.reuse.catalogue import examples

    found = set(examples())
    for section in SECTIONS:
        if not isinstance(section.models, tuple):
            found |= set(section_kinds(section.models))
    return frozenset(found)


def body_kinds() -> tuple[str, ...]:
    """Kinds of bodies."""
    return _kinds_of("`bodies`: the actors")


def shape_kinds() -> tuple[str, ...]:
    """Kinds of shapes, of bodies and of cloth."""
    return tuple(dict.fromkeys([*_kinds_of("Shapes"), *_kinds_of("Shapes of cloth")]))


def mount_kinds() -> tuple[str, ...]:
    """Kinds of mounts."""
    return _kinds_of("Mounts")


@cache
def _kinds_of(title: str) -> tuple[str, ...]:
    (section,) = _sections((title,))
    return tuple(section_kinds(section.models))


def _sections(titles: Iterable[str]) -> list[Section]:
    by_title = {section.title: section for section in SECTIONS}
    return [by_title[title] for title in titles]


def _plain(text: str) -> str:
    """Markdown with what only a browser needs taken out: it is paid for by the word."""
    return _RULE.sub("", _LINK.sub(r"\1", text)).replace("| field | takes | if left out | meaning |\n", "")


def _first(text: str) -> str:
    return text.partition(". ")[0].removesuffix(".")


def _indented(text: str) -> str:
    return "".join(f"  {line}\n" for line in text.rstrip("\n").splitlines())
