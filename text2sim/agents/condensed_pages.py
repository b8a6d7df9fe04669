"""Condensed pages of the language reference: the content of `docs/language.md` without its tables.

Both are generated from the models, so neither can disagree with the checker.
"""

import re
from collections.abc import Collection, Iterable
from textwrap import indent

from pydantic import BaseModel

from text2sim.spec_schema.models import soft_measures
from text2sim.spec_schema.published.language_reference import field_rows, load_examples, section_kinds, shared_bases
from text2sim.spec_schema.published.reference_sections import ReferenceSection
from text2sim.spec_schema.reuse.catalogue import Definition, param_rows, parts_of, usage
from text2sim.spec_schema.vocabulary.docstrings import model_doc

_LINK = re.compile(r"\[([^\]\n]+)\]\(#[^)\n]*\)")
_REGION = re.compile(r"region: \{kind: (\w+), [^{}]*\}")
_RULE = re.compile(r"^\|(?:-+\|)+\n", re.MULTILINE)
_MAGNITUDES = re.compile(r"from 1e-\S+ to 1e\+\S+ [a-z]+[0-9/a-z]*")
"""Wide bounds of quantities with a unit; a condensed page says `greater than 0`, and the checker reports the rest."""
_BOX = "{min: [x, y, z], max: [x, y, z]}"
_SHORTER = (
    ("a number greater than ", "> "), ("a number of at least ", ">= "), ("a number from ", "number "),
    ("a whole number", "int"), ("whole numbers", "ints"), (", and at most ", ", <= "), ("true or false", "bool"),
    ("a number", "number"), ("a selector, or a list of selectors", "selectors"), ("a selector", "selector"),
    ("a name", "name"), ("one of ", ""), ("[Bounds](#shots-and-overlays)", _BOX),
    ("[SolverBounds](#solvers-of-deformable-bodies)", _BOX),
)  # fmt: skip


_FORMS = {
    "region": " of what deforms: a part of it, as `{edge: left}`, `{corner: [left, front]}`",
    "change_from": " (a time)",
    "so_far": " (max, min, range up to then)",
}
"""Explanations of fields with unclear names."""


def of_deformables(model: type[BaseModel]) -> bool:
    """Return whether a kind of measure is about deformable bodies."""
    return model.__module__ == soft_measures.__name__


def plain(text: str) -> str:
    """Strip links and table rules from Markdown."""
    return _RULE.sub("", _LINK.sub(r"\1", text))


def first_sentence(text: str) -> str:
    """Return the first sentence without its full stop."""
    return text.partition(". ")[0].removesuffix(".")


def section_brief(section: ReferenceSection, only: Collection[str] | None = None, *, intro: bool = True) -> str:
    """Return a condensed page.

    Args:
        section: Section of the language.
        only: Kinds or model names to describe; other kinds are only named. Default: all.
        intro: Whether to include the page's introduction.
    """
    lines = [f"## {section.title}"]
    if intro and section.intro:
        lines += [plain(section.intro).strip()]
    if isinstance(section.models, tuple):
        for model in section.models:
            if only is None or model.__name__ in only:
                name = f"**{model.__name__}.** " if len(section.models) > 1 else ""
                lines += [name + model_doc(model), *_fields(model, ())]
        lines += [_example(text) for text in load_examples().get(section.examples, {}).values()]
        return "\n".join(lines)
    kinds = section_kinds(section.models)
    described = [kind for kind in kinds if only is None or kind in only]
    lines += kinds_brief(section, described)
    if rest := [f"`{kind}`" for kind in kinds if kind not in described]:
        lines.append(("Other kinds: " if described else "Kinds: ") + ", ".join(rest))
    return "\n".join(lines)


def kinds_line_by_line(section: ReferenceSection) -> str:
    """Return a page with a line and an example for each kind; deformable kinds have the example only."""
    examples = load_examples().get(section.examples, {})
    lines = [f"## {section.title}", plain(section.intro).strip(), "Written `NAME: {kind: KIND, …}`:"]
    models = section_kinds(section.models)
    bases, deforming = shared_bases(list(models.values())), []
    for base in bases:
        having = [f"`{kind}`" for kind, model in models.items() if issubclass(model, base)]
        inherited = [other for other in bases if other is not base and issubclass(base, other)]
        names = ", ".join(f"`{key}`{_FORMS.get(key, '')}" for key, *_ in field_rows(base, inherited))
        if names:
            lines.append(f"{', '.join(having) if len(having) < len(models) else f'every {section.noun}'}: {names}")
    regions: set[str] = set()
    for kind, model in models.items():
        alike = [other for other, its in models.items() if its is model]
        if kind != alike[0]:
            continue
        # The fields of the example without its kind, such as `{of: ball, axis: z}`.
        text = " ".join(examples.get(kind, "").strip().partition("}\n")[0].split()).partition(": ")[2]
        text = text.replace(f"kind: {kind}, ", "").replace(f"kind: {kind}", "")
        text += "}" * (text.count("{") - text.count("}"))
        own = [f"`{key}`" for key, _, default, _ in field_rows(model, shared_bases(list(models.values())))
               if default != "required" and f"{key}:" not in text]  # fmt: skip
        more = f"; also {', '.join(own)}" if own else ""
        if (region := _REGION.search(text)) and region[1] in regions:  # a form that an example has shown
            text = text.replace(region[0], "region: {…}")
        regions |= {region[1]} if region else set()
        if of_deformables(model):
            deforming.append(f"`{kind}` `{text}`")
        else:
            names = ", ".join(f"`{other}`" for other in alike)
            lines.append(f"- {names}: {first_sentence(model_doc(model))}. `{text}`{more}")
    if deforming:
        lines.append(f"- of what deforms, with more by `read`: {', '.join(deforming)}")
    return "\n".join(lines)


def kinds_brief(section: ReferenceSection, described: Collection[str]) -> list[str]:
    """Describe the kinds `told` of a page and their fields; shared fields are listed once."""
    kinds = {kind: model for kind, model in section_kinds(section.models).items() if kind in described}
    everybody = list(section_kinds(section.models).values())
    shared = shared_bases(everybody)
    lines = []
    for base in shared:
        having = [f"`{kind}`" for kind, model in kinds.items() if issubclass(model, base)]
        if having:
            who = f"every {section.noun}" if all(issubclass(model, base) for model in everybody) else ", ".join(having)
            inherited = [other for other in shared if other is not base and issubclass(base, other)]
            rows, head = _fields(base, inherited), f"Besides its own fields, {who} has:"
            lines += [*([head] if head not in lines else []), *rows] if rows else []
    examples = load_examples().get(section.examples, {})
    for kind, model in kinds.items():
        lines += [f"- `{kind}`: {model_doc(model)}", *(f"  {row}" for row in _fields(model, shared))]
        if kind in examples:
            lines.append(_example(examples[kind]))
    return lines


def prefab_gist(prefab: Definition) -> str:
    """Return what a prefab is."""
    return first_sentence(" ".join(prefab.model.doc.split()))


def prefab_brief(prefab: Definition, *, explained: bool) -> str:
    """Describe a prefab, its parameters and how it is used; if `explained`, what each parameter means."""
    line = f"- `{prefab.name}`: {prefab_gist(prefab)}. `with`: " + " ".join(
        f"`{row.name}` ({row.takes}; {row.default or 'required'})" + (f" {row.doc}" if explained else "")
        for row in param_rows(prefab)
    )
    if several := parts_of(prefab):
        line += f" Bodies: {', '.join(f'NAME_{part}' for part in several)}."
    return f"{line}\n  ```yaml\n{indent(usage(prefab), '  ')}  ```"


def fields_named(
    section: ReferenceSection, words: Collection[str], only: Collection[str], whole: Collection[str] = ()
) -> list[str]:
    """Return the rows of those fields of a page's models that are named by some words.

    Args:
        section: Section of the language.
        words: The words.
        only: Models to search.
        whole: Lower-case names of models whose fields are all described.
    """
    models = section.models if isinstance(section.models, tuple) else ()
    found = []
    for name, model in ((model.__name__, model) for model in models):
        if name.lower() in whole:
            found.append((name, _fields(model, ())))
        elif name in only:
            found.append((name, _fields(model, (), words)))
    return [row for name, rows in found if rows for row in (f"{name}:", *rows)]


def _fields(
    model: type[BaseModel], without: Iterable[type[BaseModel]], only: Collection[str] | None = None
) -> list[str]:
    """One row per field; `*` marks required ones."""
    rows = []
    for key, takes, default, doc in field_rows(model, list(without)):
        if only is not None and key not in only:
            continue
        takes = _MAGNITUDES.sub("greater than 0", takes)
        for long, short in _SHORTER:
            takes = takes.replace(long, short)
        star = "*" if default == "required" else ""
        given = f"; {default.strip('`')}" if default and not star else ""
        rows.append(f"- `{key}`{star} ({plain(takes)}{given}): {plain(doc)}".removesuffix(": "))
    return rows


def _example(text: str) -> str:
    """An example, inline if it is a single line."""
    text = text.strip("\n")
    return f"  e.g. `{text}`" if "\n" not in text else f"```yaml\n{text}\n```"
