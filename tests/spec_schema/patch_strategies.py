"""Operations of patches, and random patches that can be applied to given data."""

import copy
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st

from text2sim.spec_schema.changes.patch import PatchError, apply_operations
from text2sim.spec_schema.text.document import Path, pointer

_SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-1000, 1000),
    st.floats(-1e6, 1e6, allow_nan=False).map(lambda x: x + 0.0 if abs(x) >= 1e-30 else 0.0),
    st.sampled_from(
        ["steel", "${rows * 2}", "ball[3]", "yes", "1.5", "", " x", "a: b # c", "two\nlines\n", "ü\u2028", "~"]
    ),
    st.text(st.characters(codec="utf-8", exclude_categories=["C", "Co", "Cs"], exclude_characters="\x85"), max_size=12),
    st.just("so long a text that it does not fit on one line " * 4),
)
_KEYS = st.sampled_from(["ball", "look", "kind", "material", "pose", "on", "x y", "a/b", "m~n", "1", "null", "bodies"])
VALUES = st.recursive(
    _SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(_KEYS, inner, max_size=4), max_leaves=8
)


def op(name: str, path: str, value: Any = ..., *, source: str | None = None) -> dict[str, Any]:
    """Return an operation of a patch."""
    row: dict[str, Any] = {"op": name, "path": path}
    if value is not ...:
        row["value"] = value
    if source is not None:
        row["from"] = source
    return row


def paths_of(data: Any, path: Path = ()) -> Iterator[Path]:
    """Paths of everything in some data."""
    yield path
    rows = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for step, item in rows:
        yield from paths_of(item, (*path, step))


@st.composite
def patches(draw: st.DrawFn, data: Any, most: int = 4) -> list[dict[str, Any]]:
    """A patch that can be applied to some data."""
    operations: list[dict[str, Any]] = []
    now = copy.deepcopy(data)
    for _ in range(draw(st.integers(1, most))):
        operation = draw(_operations(now))
        try:
            now = apply_operations(now, [operation])
        except PatchError:
            continue
        operations.append(operation)
    return operations


@st.composite
def _operations(draw: st.DrawFn, data: Any) -> dict[str, Any]:
    places = list(paths_of(data))
    op = draw(st.sampled_from(["add", "add", "remove", "replace", "replace", "move", "copy"]))
    place = draw(st.sampled_from(places))
    if op == "remove":
        return {"op": op, "path": pointer(place)}
    if op == "replace":
        return {"op": op, "path": pointer(place), "value": draw(VALUES)}
    target: Any = data
    for step in place:
        target = target[step]
    if isinstance(target, list):
        step = draw(st.sampled_from(["-", *range(len(target) + 1)]))
    else:
        step = draw(_KEYS)
    path = pointer((*place, step))
    if op == "add":
        return {"op": op, "path": path, "value": draw(VALUES)}
    return {"op": op, "from": pointer(draw(st.sampled_from(places))), "path": path}
