"""JSON Schema of the language, for editors and for language models.

It is generated from the models, in draft-07, which language servers support. Wherever the language accepts a number, a
boolean, a list or one of several words, it also accepts an expression: text that contains `${…}`.
"""

import json
from itertools import chain, count
from typing import Any, get_args, get_origin

from pydantic import BaseModel

from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.prefab_models import PrefabFile, Use
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.models.sweep_models import Sweep
from text2sim.spec_schema.vocabulary.docstrings import field_docs, model_doc
from text2sim.spec_schema.vocabulary.slot_path import ROOTS
from text2sim.spec_schema.vocabulary.slots import ENTRY, content_slot
from text2sim.spec_schema.vocabulary.words import LanguageSlot, bounds_of, fields_of, is_model, kinds_of, slot_of

Schema = dict[str, Any]

EXPRESSION = r"^.*\$\{.*\}.*$"
_OVERLAYS = {(Case, "variants"), (Sweep, "points")}
"""Fields whose values are changes to a case."""
_BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}


def build_schema() -> Schema:
    """Return the JSON Schema of a case and of a prefab file, which its key `prefab` identifies."""
    definitions: dict[str, Schema] = {}
    builder = _Builder(definitions, {})
    case, prefab = builder.model(Case), builder.model(PrefabFile)
    definitions |= {"Case": case, "PrefabFile": prefab}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "text2sim",
        "description": case["description"],
        "type": "object",
        "if": {"required": ["prefab"]},
        "then": {"$ref": "#/definitions/PrefabFile"},
        "else": {"$ref": "#/definitions/Case"},
        "definitions": {name: definitions[name] for name in sorted(definitions)},
    }


def schema_text() -> str:
    """Return the content of `case.schema.json`, without the indentation that would be a third of it."""
    return json.dumps(build_schema(), indent=0, ensure_ascii=False) + "\n"


class _Builder:
    """Builder of schemas: of complete entries or, with `loose`, of changes to them."""

    def __init__(self, definitions: dict[str, Schema], unions: dict[Any, str], *, loose: bool = False) -> None:
        self.definitions = definitions
        self.unions = unions
        """Names of the existing union schemas, by their kinds and whether they are loose."""
        self.loose = loose

    def model(self, model: type[BaseModel]) -> Schema:
        docs = field_docs(model)
        properties: dict[str, Schema] = {}
        required = []
        for key, (attribute, slot) in fields_of(model).items():
            if self.loose and model is Case and key not in ROOTS:
                continue
            field = model.model_fields[attribute]
            inner = _Builder(self.definitions, self.unions, loose=True) if (model, key) in _OVERLAYS else self
            schema = inner.slot(content_slot(model, key, slot), key)
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

    def slot(self, slot: LanguageSlot, hint: str) -> Schema:
        if slot.discriminator is not None:
            union = self.union(slot, hint)
            return self.or_use(union) if slot == ENTRY else union
        if len(slot.members) > 1:
            return {"anyOf": [self.slot(member, hint) for member in slot.members]}
        if slot.base is Static:
            return self.or_use(self.reference(Static))
        if is_model(slot.base):
            return self.reference(slot.base)
        origin = get_origin(slot.base)
        if origin is dict:
            return self.mapping(get_args(slot.base), bounds_of(slot), hint)
        return self.sequence(slot, hint) if origin in (list, tuple) else _scalar(slot)

    def sequence(self, slot: LanguageSlot, hint: str) -> Schema:
        bounds, arguments = bounds_of(slot), get_args(slot.base)
        if get_origin(slot.base) is tuple:
            bounds = {"min_length": len(arguments), "max_length": len(arguments)}
        # Items of a vector have one type. Those of a span are `end` or a time: the schema of a number comes last, and
        # accepts both, because it accepts expressions.
        kinds = [self.slot(slot_of(item), hint) for item in dict.fromkeys(arguments)]
        return _or_expression({"type": "array", "items": kinds[-1], **_length(bounds, "Items")})

    def union(self, slot: LanguageSlot, hint: str) -> Schema:
        """Return the schema of a union, which branches on `kind` so that editors use the schema of that kind only."""
        kinds = slot.models
        docs = [model_doc(model).partition(". ")[0] for model in kinds.values()]
        name = self.name_union(tuple(kinds), hint)
        if name not in self.definitions:
            self.definitions[name] = {}  # reserve the name: shapes may contain shapes
            schema: Schema = {
                "type": "object",
                "properties": {"kind": {"enum": list(kinds), "markdownEnumDescriptions": docs}},
                "required": ["kind"],
                "allOf": [
                    {
                        "if": {"properties": {"kind": {"const": kind}}, "required": ["kind"]},
                        "then": self.reference(model),
                    }
                    for kind, model in kinds.items()
                ],
            }
            if self.loose:
                # Changes without a kind may apply to several kinds.
                any_kind = {"anyOf": [self.reference(model) for model in dict.fromkeys(kinds.values())]}
                schema = {"if": {"required": ["kind"]}, "then": schema, "else": any_kind}
            # In a prefab the kind may be an expression, whose value is unknown here.
            computed = {"properties": {"kind": {"type": "string", "pattern": EXPRESSION}}, "required": ["kind"]}
            self.definitions[name] = {"if": computed, "else": schema}
        return {"$ref": f"#/definitions/{name}"}

    def name_union(self, kinds: tuple[str, ...], hint: str) -> str:
        """Return the name of a union, after the first key at which it occurs."""
        key = (kinds, self.loose)
        if key not in self.unions:
            base = "Any" + hint.title().replace("_", "") + ("Changes" if self.loose else "")
            taken = set(self.unions.values())
            self.unions[key] = next(n for n in chain([base], (f"{base}{i}" for i in count(2))) if n not in taken)
        return self.unions[key]

    def or_use(self, schema: Schema) -> Schema:
        """Return the schema of a complete entry or a use of a prefab."""
        use = self.use()
        if self.loose:  # changes to a use need not name the prefab
            return {"anyOf": [use, schema]}
        own = self.definitions["Use"]["properties"]
        # Repeated here, so that editors suggest it in an empty entry.
        return {"properties": {"use": own["use"]}, "if": {"required": ["use"]}, "then": use, "else": schema}

    def mapping(self, arguments: tuple[Any, ...], bounds: dict[str, Any], hint: str) -> Schema:
        names = bounds_of(slot_of(arguments[0])).get("pattern")
        rule = {"propertyNames": {"pattern": names}} if names else {}
        values = self.slot(slot_of(arguments[1]), hint) if arguments[1] is not Any else {}
        if self.loose:
            values = {"anyOf": [values, {"type": "null"}]} if values else {}
        return {"type": "object", **rule, "additionalProperties": values or True, **_length(bounds, "Properties")}

    def reference(self, model: type[BaseModel]) -> Schema:
        name = model.__name__ + ("Changes" if self.loose else "")
        if name not in self.definitions:
            self.definitions[name] = {}  # reserve the name: shapes may contain shapes
            self.definitions[name] = self.model(model)
        return {"$ref": f"#/definitions/{name}"}

    def use(self) -> Schema:
        """Return the schema of a use of a prefab: its own keys, and changes to the body or to its parts by name."""
        name = "UseChanges" if self.loose else "Use"
        if name not in self.definitions:
            self.definitions[name] = {}
            own, loose = self.model(Use), _Builder(self.definitions, self.unions, loose=True)
            bodies = list(dict.fromkeys(ENTRY.models.values()))
            for model in bodies:
                for key, schema in loose.model(model)["properties"].items():
                    own["properties"].setdefault(key, schema)
            own["additionalProperties"] = {"anyOf": [*(loose.reference(model) for model in bodies), {"type": "null"}]}
            self.definitions[name] = own
        return {"$ref": f"#/definitions/{name}"}


def _scalar(slot: LanguageSlot) -> Schema:
    """Return the schema of a number, a boolean, text, or one of several words; it accepts everything else."""
    bounds, words = bounds_of(slot), get_args(slot.base)
    if slot.base in (int, float):
        limits = {word: bounds[name] for name, word in _BOUNDS.items() if name in bounds}
        return _or_expression({"type": "integer" if slot.base is int else "number", **limits})
    if slot.base is bool:
        return _or_expression({"type": "boolean"})
    if slot.base is str:
        pattern = {"pattern": f"({bounds['pattern']})|({EXPRESSION})"} if "pattern" in bounds else {}
        return {"type": "string", **pattern, **_length(bounds, "Length")}
    if words and all(isinstance(word, str) for word in words):
        return {"anyOf": [{"enum": list(words)}, {"type": "string", "pattern": EXPRESSION}]}
    return {"enum": list(words)} if words else {}


def _or_expression(schema: Schema) -> Schema:
    """Return a schema that also accepts expressions: `pattern` only applies to text, `minimum` only to numbers."""
    return {**schema, "type": [schema["type"], "string"], "pattern": EXPRESSION}


def _length(bounds: dict[str, Any], what: str) -> Schema:
    names = {"min_length": f"min{what}", "max_length": f"max{what}"}
    return {word: bounds[name] for name, word in names.items() if name in bounds}


def _plain(value: Any) -> Any:
    """Return a default as JSON; None for defaults that the schema omits."""
    if isinstance(value, tuple):
        return list(value)
    return value if isinstance(value, bool | int | float | str) else None


if __name__ == "__main__":
    print(schema_text(), end="")
