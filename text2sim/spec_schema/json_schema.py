"""The language as a JSON Schema, for editors and for language models.

It is made from the models directly and keeps to draft-07, which is what language servers know. Where the
language takes a number, a boolean, a list or one of some words, it takes an expression as well: text with
`${…}` in it.
"""

import json
from typing import Any, get_args, get_origin

from pydantic import BaseModel

from text2sim.spec_schema.case import Case
from text2sim.spec_schema.docstrings import field_docs, model_doc
from text2sim.spec_schema.words import Slot, bounds_of, fields_of, is_model, kinds_of, slot_of

Schema = dict[str, Any]

EXPRESSION = r"^.*\$\{.*\}.*$"
_BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}


def build_schema() -> Schema:
    """Make the JSON Schema of a case."""
    definitions: dict[str, Schema] = {}
    root = _model(Case, definitions)
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "A text2sim case",
        **root,
        "definitions": {name: definitions[name] for name in sorted(definitions)},
    }


def schema_text() -> str:
    """The JSON Schema as it is kept in `case.schema.json`."""
    return json.dumps(build_schema(), indent=1, ensure_ascii=False) + "\n"


def _model(model: type[BaseModel], definitions: dict[str, Schema]) -> Schema:
    docs = field_docs(model)
    properties: dict[str, Schema] = {}
    required = []
    for key, (attribute, slot) in fields_of(model).items():
        field = model.model_fields[attribute]
        schema = _slot(slot, definitions)
        if key == "kind" and field.is_required():
            schema = {"description": model_doc(model), "enum": list(kinds_of(model))}
        elif attribute in docs:
            schema = {"description": docs[attribute], **schema}
        default = _plain(field.default)
        if field.is_required():
            required.append(key)
        elif default is not None:
            schema = {**schema, "default": default}
        properties[key] = schema
    return {
        "description": model_doc(model),
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


def _slot(slot: Slot, definitions: dict[str, Schema]) -> Schema:
    if slot.discriminator is not None:
        return {"oneOf": [_reference(model, definitions) for model in dict.fromkeys(slot.models.values())]}
    if len(slot.members) > 1:
        return {"anyOf": [_slot(member, definitions) for member in slot.members]}
    bounds = bounds_of(slot)
    origin, arguments = get_origin(slot.base), get_args(slot.base)
    if is_model(slot.base):
        return _reference(slot.base, definitions)
    if origin is dict:
        return _mapping(arguments, bounds, definitions)
    if origin in (list, tuple):
        length = (
            {"minItems": len(arguments), "maxItems": len(arguments)} if origin is tuple else _length(bounds, "Items")
        )
        # All items of a vector are alike.
        return _or_expression({"type": "array", "items": _slot(slot_of(arguments[0]), definitions), **length})
    if slot.base in (int, float):
        limits = {word: bounds[name] for name, word in _BOUNDS.items() if name in bounds}
        return _or_expression({"type": "integer" if slot.base is int else "number", **limits})
    if slot.base is bool:
        return _or_expression({"type": "boolean"})
    if slot.base is str:
        pattern = {"pattern": f"({bounds['pattern']})|({EXPRESSION})"} if "pattern" in bounds else {}
        return {"type": "string", **pattern, **_length(bounds, "Length")}
    if arguments and all(isinstance(word, str) for word in arguments):
        return {"anyOf": [{"enum": list(arguments)}, {"type": "string", "pattern": EXPRESSION}]}
    return {"enum": list(arguments)} if arguments else {}


def _or_expression(schema: Schema) -> Schema:
    """Take an expression, too: `pattern` says nothing about what is not text, nor `minimum` about text."""
    return {**schema, "type": [schema["type"], "string"], "pattern": EXPRESSION}


def _mapping(arguments: tuple[Any, ...], bounds: dict[str, Any], definitions: dict[str, Schema]) -> Schema:
    names = bounds_of(slot_of(arguments[0])).get("pattern")
    rule = {"propertyNames": {"pattern": names}} if names else {}
    values = _slot(slot_of(arguments[1]), definitions) if arguments[1] is not Any else {}
    return {"type": "object", **rule, "additionalProperties": values or True, **_length(bounds, "Properties")}


def _length(bounds: dict[str, Any], what: str) -> Schema:
    names = {"min_length": f"min{what}", "max_length": f"max{what}"}
    return {word: bounds[name] for name, word in names.items() if name in bounds}


def _reference(model: type[BaseModel], definitions: dict[str, Schema]) -> Schema:
    name = model.__name__
    if name not in definitions:
        definitions[name] = {}  # a shape may hold shapes
        definitions[name] = _model(model, definitions)
    return {"$ref": f"#/definitions/{name}"}


def _plain(value: Any) -> Any:
    """A default as JSON, None for those that are left out."""
    if isinstance(value, tuple):
        return list(value)
    return value if isinstance(value, bool | int | float | str) else None


if __name__ == "__main__":
    print(schema_text(), end="")
