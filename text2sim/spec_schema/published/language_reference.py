"""The language reference, `docs/language.md`: made from the models, their docstrings and the examples.

Write it with `python -m text2sim.spec_schema.published.language_reference > docs/language.md`.
"""

from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_origin

from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from text2sim.spec_schema.arithmetic.expressions import MAX_DEPTH, MAX_LENGTH
from text2sim.spec_schema.arithmetic.functions import FUNCTIONS
from text2sim.spec_schema.arithmetic.values import MAX_NUMBER
from text2sim.spec_schema.models.base import Model
from text2sim.spec_schema.models.bodies import Joint
from text2sim.spec_schema.models.colors import NAMED, PALETTES
from text2sim.spec_schema.models.sweep_models import MAX_RUNS
from text2sim.spec_schema.published.reference_prose import INTRODUCTION
from text2sim.spec_schema.published.reference_sections import SECTIONS, ReferenceSection
from text2sim.spec_schema.reuse.prefabs import MAX_DEPTH as NESTED
from text2sim.spec_schema.reuse.prefabs import MAX_USES
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import read_source
from text2sim.spec_schema.text.writing import scalar
from text2sim.spec_schema.vocabulary.docstrings import field_docs, model_doc
from text2sim.spec_schema.vocabulary.slots import meant
from text2sim.spec_schema.vocabulary.words import (
    LanguageSlot,
    carried_by,
    describe,
    fields_of,
    is_model,
    magnitudes,
    slot_of,
)

GREATER = " greater than 0"
_HEADER = """\
<!-- Made by `python -m text2sim.spec_schema.published.language_reference`: change the models or the examples, not this
page. -->
# The language

"""


def language_reference() -> str:
    """Return the text of the language reference."""
    limits = {
        "@FUNCTIONS@": " ".join(f"`{name}`" for name in FUNCTIONS),
        "@LENGTH@": str(MAX_LENGTH),
        "@DEPTH@": str(MAX_DEPTH),
        "@NUMBER@": f"{MAX_NUMBER:g}",
        "@RUNS@": str(MAX_RUNS),
        "@USES@": str(MAX_USES),
        "@NESTED@": str(NESTED),
    }
    text = INTRODUCTION + "\n" + "\n".join(section_text(section) for section in SECTIONS)
    for word, value in limits.items():
        text = text.replace(word, value)
    return _HEADER + text + _colors()


@cache
def load_examples() -> dict[str, dict[str, str]]:
    """Return the YAML of an example for every kind, by section and kind."""
    return parse_document(read_source(Path(__file__).with_name("examples.yaml"))).data


def section_text(section: ReferenceSection) -> str:
    """Return the text of one section."""
    lines = [f"{'#' * section.level} {section.title}", ""]
    if section.intro:
        lines += [section.intro, ""]
    examples = load_examples().get(section.examples, {})
    if isinstance(section.models, tuple):
        for model in section.models:
            name = f"**{model.__name__}.** " if len(section.models) > 1 else ""
            lines += [name + model_doc(model), "", *_table(model, [])]
        for title, text in examples.items():
            lines += [f"{title[0].upper()}{title[1:]}:", "", *_yaml(text)]
        return "\n".join(lines)
    kinds = section_kinds(section.models)
    shared = shared_bases(list(kinds.values()))
    for base in sorted(shared, key=lambda model: len(model.__mro__)):
        having = [f"`{kind}`" for kind, model in kinds.items() if issubclass(model, base)]
        who = f"every {section.noun} has" if len(having) == len(kinds) else f"{', '.join(having)} have"
        above = [other for other in shared if other is not base and issubclass(base, other)]
        lines += [f"Besides its own fields, {who}:", "", *_table(base, above)]
    for kind, model in kinds.items():
        lines += [f"{'#' * (section.level + 1)} `{kind}`", "", model_doc(model), ""]
        lines += _table(model, shared) + _yaml(examples[kind])
    return "\n".join(lines)


def shared_bases(models: list[type[BaseModel]]) -> list[type[BaseModel]]:
    """Return classes from which several models of a union have fields: those are said once."""
    several = [base for model in models for base in model.__mro__[1:] if sum(issubclass(m, base) for m in models) > 1]
    bases = [base for base in dict.fromkeys(several) if issubclass(base, Model) and base not in (Model, *models)]
    return [base for base in bases if base.__dict__.get("__annotations__")]


def section_kinds(union: Any) -> dict[str, type[BaseModel]]:
    """Return the models of a union on `kind`, which may stand beside a plain type."""
    return {kind: model for member in slot_of(union).members for kind, model in member.models.items()} or slot_of(
        union
    ).models


def _table(model: type[BaseModel], without: list[type[BaseModel]]) -> list[str]:
    """Table of a model's fields, but for those of some of its base classes."""
    rows = [f"| `{key}` | {takes} | {default} | {doc} |" for key, takes, default, doc in field_rows(model, without)]
    return ["| field | takes | if left out | meaning |", "|---|---|---|---|", *rows, ""] if rows else []


def field_rows(model: type[BaseModel], without: Collection[type[BaseModel]] = ()) -> list[tuple[str, str, str, str]]:
    """Return name, what it takes, what holds if it is left out, and meaning of a model's fields.

    Args:
        model: The model.
        without: Base classes whose fields are left out.
    """
    docs = field_docs(model)
    left_out = {name for base in without if issubclass(model, base) for name in base.model_fields}
    rows = []
    for key, (attribute, slot) in fields_of(model).items():
        field = model.model_fields[attribute]
        if attribute in left_out or (key == "kind" and field.is_required() and attribute not in docs):
            continue
        default = "required" if field.is_required() else _default(field.default)
        rows.append((key, _type(meant(model, key, slot)), default, docs.get(attribute, "")))
    return rows


def _type(slot: LanguageSlot) -> str:
    """What a field takes, with links to what has a section of its own."""
    if slot.base is Any:
        return "anything that an expression can use"
    if slot.discriminator is not None:
        return _link(slot)
    if len(slot.members) > 1:
        return ", or ".join(dict.fromkeys(_type(member) for member in slot.members))
    if is_model(slot.base):
        return f"[{slot.base.__name__}](#{_TITLES[slot.base.__name__]})"
    if get_origin(slot.base) is dict:
        return f"{_type(slot_of(get_args(slot.base)[1]))}, by name"
    return _with_magnitudes(slot, describe(slot))


def _with_magnitudes(slot: LanguageSlot, said: str) -> str:
    """Say which magnitudes a quantity with a unit, or every number of several, may have."""
    inner = [slot_of(item) for item in get_args(slot.base)] if get_origin(slot.base) in (tuple, list) else []
    found = next((carried for one in (slot, *inner) if (carried := carried_by(one)) is not None), None)
    if found is None or not found.unit or not said.endswith(GREATER):
        return said
    return f"{said.removesuffix(GREATER)} {magnitudes(found)}"


def _link(slot: LanguageSlot) -> str:
    models = set(slot.models.values())
    for section in SECTIONS:
        if not isinstance(section.models, tuple) and models <= set(section_kinds(section.models).values()):
            return f"[{section.noun}](#{_anchor(section.title)})"
    if models == set(slot_of(Joint).models.values()):
        return f"[joint](#{_anchor('Mounts')})"
    raise LookupError(f"no section of the reference has {', '.join(slot.models)}")


def _anchor(title: str) -> str:
    """The name that GitHub gives to a heading."""
    kept = "".join(c for c in title.lower() if c.isalnum() or c in " -_")
    return kept.replace(" ", "-")


_TITLES = {
    model.__name__: _anchor(section.title)
    for section in SECTIONS
    if isinstance(section.models, tuple)
    for model in section.models
}


def _default(value: Any) -> str:
    if value is None or value is PydanticUndefined or isinstance(value, BaseModel):
        kind = getattr(value, "kind", None)
        return f"`{kind}`" if isinstance(kind, str) else ""
    if isinstance(value, tuple):
        return "`[" + ", ".join(_number(item) for item in value) + "]`"
    return f"`{_number(value)}`" if value != "" else ""


def _number(value: Any) -> str:
    if isinstance(value, float) and value == int(value):
        return str(int(value))
    return scalar(value, flow=True)


def _yaml(text: str) -> list[str]:
    return ["```yaml", text, "```", ""]


def _colors() -> str:
    names = ", ".join(sorted(NAMED))
    palettes = "\n".join(f"- `{name}`: {', '.join(colors)}" for name, colors in PALETTES.items())
    return (
        f"\n## Colours\n\n`#rrggbb`, three numbers from 0 to 1 (sRGB), or one of these names: {names}.\n\n"
        f"Palettes, for `look: {{color: {{palette: okabe_ito}}}}`:\n\n{palettes}\n"
    )


if __name__ == "__main__":
    print(language_reference(), end="")
