"""Expanded form of a case: an equivalent case without variants, sweeps and prefabs."""

from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.reuse.substitution import bind, fill
from text2sim.spec_schema.reuse.trees import LocatedValue, put
from text2sim.spec_schema.text.canonical import dump_case


def expanded_text(loaded: LoadedCase) -> str:
    """Return the canonical text of a case with its overlays applied and its prefabs expanded.

    Loaded from the same folder, it is the same case. Composed expressions that exceed the limits of written ones
    contain the values of parameters.
    """
    tree = LocatedValue(loaded.raw, loaded.document.root)
    values = loaded.data.get("params") or {}
    for path in loaded.document.composed:
        text = loaded.document.sites[path]
        try:
            parse_interpolation(text)
        except ExpressionError:
            value, _ = fill(text, {name: bind(value) for name, value in values.items()})
            tree = put(tree, path, LocatedValue(value, loaded.document.root))
    return dump_case(tree.data)
