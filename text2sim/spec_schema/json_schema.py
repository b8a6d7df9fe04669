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
from text2sim.spec_schema.prefab_models import Use
from text2sim.spec_schema.reach import ROOTS
from text2sim.spec_schema.scene import Static
from text2sim.spec_schema.slots import ENTRY, meant
from text2sim.spec_schema.sweep_models import Sweep
from text2sim.spec_schema.words import Slot, bounds_of, fields_of, is_model, kinds_of, slot_of

Schema = dict[str, Any]

EXPRESSION = r"^.*\$\{.*\}.*$"
_OVERLAYS = {(Case, "variants"), (Sweep, "points")}
"""Fields that hold what is laid over a case."""
_BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}


def build_schema() -> Schema:
    """Make the JSON Schema of a case."""
    definitions: dict[str, Schema] = {}
    root = _Maker(definitions).model(Case)
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "A text2sim case",
        **root,
        "definitions": {name: definitions[name] for name in sorted(definitions)},
    }


def schema_text() -> str:
    """The JSON Schema as it is kept in `case.schema.json`."""
    return json.dumps(build_schema(), indent=1, ensure_ascii=False) + "\n"


class _Maker:
    """Makes the schema of things as they are written in full, or (`loose`) of what is laid over them."""

    def __init__(self, definitions: dict[str, Schema], *, loose: bool = False) -> None:
        self.definitions = definitions
        self.loose = loose

    def model(self, model: type[BaseModel]) -> Schema:
        docs = field_docs(model)
        properties: dict[str, Schema] = {}
        required = []
        for key, (attribute, slot) in fields_of(model).items():
            if self.loose and model is Case and key not in ROOTS:
                continue
            field = model.model_fields[attribute]
            inner = _Maker(self.definitions, loose=True) if (model, key) in _OVERLAYS else self
            schema = inner.slot(meant(model, key, slot))
            if self.loose:
                schema = {"anyOf": [schema, {"type": "null"}]}
            if key == "kind" and field.is_required() and attribute not in docs:
                schema = {"description": model_doc(model), "enum": list(kinds_of(model))}
            elif attribute in docs:
                schema = {"description": docs[attribute], **schema}
            default = _plain(field.default)
            if field.is_required():
                required.append(key)
            elif default is not None and not self.loose:
                schema = {**schema, "default": default}
            properties[key] = schema
        return {
            "description": model_doc(model),
            "type": "object",
            "properties": properties,
            "required": [] if self.loose else required,
            "additionalProperties": False,
        }

    def slot(self, slot: Slot) -> Schema:
        if slot.discriminator is not None:
            models = [self.reference(model) for model in dict.fromkeys(slot.models.values())]
            if slot == ENTRY:
                models.append(self.use())
            # Without a kind, what is laid over something may be meant for several.
            return {"anyOf" if self.loose else "oneOf": models}
        if len(slot.members) > 1:
            return {"anyOf": [self.slot(member) for member in slot.members]}
        bounds = bounds_of(slot)
        origin, arguments = get_origin(slot.base), get_args(slot.base)
        if slot.base is Static:
            return {"anyOf" if self.loose else "oneOf": [self.reference(Static), self.use()]}
        if is_model(slot.base):
            return self.reference(slot.base)
        if origin is dict:
            return self.mapping(arguments, bounds)
        if origin in (list, tuple):
            length = (
                {"minItems": len(arguments), "maxItems": len(arguments)}
                if origin is tuple
                else _length(bounds, "Items")
            )
            # All items of a vector are alike.
            return _or_expression({"type": "array", "items": self.slot(slot_of(arguments[0])), **length})
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

    def mapping(self, arguments: tuple[Any, ...], bounds: dict[str, Any]) -> Schema:
        names = bounds_of(slot_of(arguments[0])).get("pattern")
        rule = {"propertyNames": {"pattern": names}} if names else {}
        values = self.slot(slot_of(arguments[1])) if arguments[1] is not Any else {}
        if self.loose:
            values = {"anyOf": [values, {"type": "null"}]} if values else {}
        return {"type": "object", **rule, "additionalProperties": values or True, **_length(bounds, "Properties")}

    def reference(self, model: type[BaseModel]) -> Schema:
        name = model.__name__ + ("Changes" if self.loose else "")
        if name not in self.definitions:
            self.definitions[name] = {}  # a shape may hold shapes
            self.definitions[name] = self.model(model)
        return {"$ref": f"#/definitions/{name}"}

    def use(self) -> Schema:
        """What uses a prefab: beside its own keys stand changes to the body, or to parts of it by name."""
        name = "UseChanges" if self.loose else "Use"
        if name not in self.definitions:
            self.definitions[name] = {}
            own, loose = self.model(Use), _Maker(self.definitions, loose=True)
            bodies = [model for model in dict.fromkeys(ENTRY.models.values())]
            for model in bodies:
                for key, schema in loose.model(model)["properties"].items():
                    own["properties"].setdefault(key, schema)
            own["additionalProperties"] = {"anyOf": [*(loose.reference(model) for model in bodies), {"type": "null"}]}
            self.definitions[name] = own
        return {"$ref": f"#/definitions/{name}"}


def _or_expression(schema: Schema) -> Schema:
    """Take an expression, too: `pattern` says nothing about what is not text, nor `minimum` about text."""
    return {**schema, "type": [schema["type"], "string"], "pattern": EXPRESSION}


def _length(bounds: dict[str, Any], what: str) -> Schema:
    names = {"min_length": f"min{what}", "max_length": f"max{what}"}
    return {word: bounds[name] for name, word in names.items() if name in bounds}


def _plain(value: Any) -> Any:
    """A default as JSON, None for those that are left out."""
    if isinstance(value, tuple):
        return list(value)
    return value if isinstance(value, bool | int | float | str) else None


if __name__ == "__main__":
    print(schema_text(), end="")
