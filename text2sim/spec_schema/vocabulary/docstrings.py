"""Documentation of the models: docstrings of classes and fields.

Pydantic could collect the docstrings of fields at import (`use_attribute_docstrings`), but then every `check` would
read the source. Only schema and documentation need them, so they are read on demand.
"""

import ast
import inspect
import sys
from functools import cache

from pydantic import BaseModel


@cache
def field_docs(model: type[BaseModel]) -> dict[str, str]:
    """Return the docstring of each field of a model, including inherited ones, by attribute."""
    docs: dict[str, str] = {}
    for layer in reversed(model.__mro__):
        if issubclass(layer, BaseModel) and layer.__module__ != BaseModel.__module__:
            docs |= _module_docs(layer.__module__).get(layer.__name__, {})
    return {name: docs[name] for name in model.model_fields if name in docs}


def model_doc(model: type[BaseModel]) -> str:
    """Return the docstring of a model, on one line."""
    return _joined(model.__doc__ or "")


@cache
def _module_docs(name: str) -> dict[str, dict[str, str]]:
    tree = ast.parse(inspect.getsource(sys.modules[name]))
    return {node.name: _class_docs(node) for node in tree.body if isinstance(node, ast.ClassDef)}


def _class_docs(node: ast.ClassDef) -> dict[str, str]:
    docs = {}
    for field, text in zip(node.body, node.body[1:], strict=False):
        if not (isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)):
            continue
        if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant) and isinstance(text.value.value, str):
            docs[field.target.id] = _joined(text.value.value)
    return docs


def _joined(text: str) -> str:
    return " ".join(inspect.cleandoc(text).split())
