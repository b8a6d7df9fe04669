"""Operations of a patch: their form and their values."""

import re
from collections.abc import Callable
from math import isfinite
from typing import Any

from text2sim.spec_schema.arithmetic.values import MAX_NUMBER, MIN_NUMBER
from text2sim.spec_schema.errors import SpecError, nearest
from text2sim.spec_schema.text.document import MAX_DEPTH, MAX_SCALAR, pointer
from text2sim.spec_schema.text.source import Source, check_source

Operation = dict[str, Any]
"""Members `op`, `path`, and `value` or `from`."""
Steps = tuple[str, ...]
MAX_POINTER = 2000
_BAD_TILDE = re.compile(r"~(?![01])")

MEMBERS: dict[str, tuple[str, ...]] = {
    "add": ("op", "path", "value"),
    "remove": ("op", "path"),
    "replace": ("op", "path", "value"),
    "move": ("op", "from", "path"),
    "copy": ("op", "from", "path"),
    "test": ("op", "path", "value"),
}


class Refusal(Exception):
    """An operation that is refused because of its `member`."""

    def __init__(self, reason: str, member: str = "path", hint: str | None = None) -> None:
        self.member = member
        super().__init__(f"{reason}; did you mean `{hint}`?" if hint else reason)


def split_pointer(text: object) -> Steps:
    """Return the steps of a JSON Pointer (RFC 6901).

    Raises:
        ValueError: If it is not a pointer.
    """
    if not isinstance(text, str) or len(text) > MAX_POINTER:
        raise ValueError("a path is a text such as /bodies/ball/shape/radius")
    if text and not text.startswith("/"):
        raise ValueError(f"a path starts with `/`: `/{text.replace('.', '/')[:80]}`")
    if _BAD_TILDE.search(text):
        raise ValueError("in a path, `~` is written `~0` and a `/` inside a name is written `~1`")
    return tuple(step.replace("~1", "/").replace("~0", "~") for step in text.split("/")[1:])


def checked_form(operation: Any) -> str:
    """Return the `op` of an operation with the members it needs, and no others.

    Raises:
        Refusal: If members are missing, unknown or invalid.
    """
    if not isinstance(operation, dict):
        raise Refusal('an operation is a mapping such as {"op": "remove", "path": "/bodies/ball"}', "op")
    if "op" not in operation:
        raise Refusal(f"`op` is missing: one of {', '.join(MEMBERS)}", "op")
    op = operation["op"]
    if not isinstance(op, str) or op not in MEMBERS:
        raise Refusal(f"unknown op `{str(op)[:40]}`; there are {', '.join(MEMBERS)}", "op", nearest(op, MEMBERS))
    for name in operation:
        if name not in MEMBERS[op]:
            hint = nearest(name, [word for word in MEMBERS[op] if word not in operation])
            message = f"unknown member `{str(name)[:40]}`; `{op}` takes {', '.join(MEMBERS[op])}"
            raise Refusal(message, str(name), hint)
    for name in MEMBERS[op]:
        if name not in operation:
            raise Refusal(f"`{name}` is missing: `{op}` takes {', '.join(MEMBERS[op])}", "op")
    return op


def steps_of(operation: Operation, member: str) -> Steps:
    """Return the steps of the pointer in a member of an operation.

    Raises:
        Refusal: If it is not a pointer.
    """
    try:
        return split_pointer(operation[member])
    except ValueError as error:
        raise Refusal(str(error), member) from None


def index_of(path: Steps, items: list[Any], last: int, member: str = "path") -> int:
    """Return the index in a list from the last step of a path.

    Args:
        path: The path.
        items: The list.
        last: Largest allowed index.
        member: Member of the operation with the path, for the message.

    Raises:
        Refusal: If the step is not an index, or too large.
    """
    step, place = path[-1], place_of(path[:-1])
    if step == "-":
        raise Refusal(f"`-` means an item to add; {place} has {len(items)} items", member)
    if not (step.isascii() and step.isdigit()) or (step[0] == "0" and len(step) > 1):
        raise Refusal(f"{place} is a list: its items are counted from 0, without leading zeros", member)
    if len(step) > 9 or int(step) > last:
        many = f"has {len(items)} item{'' if len(items) == 1 else 's'}" if items else "is empty"
        raise Refusal(f"{place} {many}, counted from 0; there is no item {step[:9]}", member)
    return int(step)


def place_of(path: Steps) -> str:
    """Return a path for a message."""
    return pointer(path)[:200] or "the document"


def common_ends(a: list[Any], b: list[Any], equal: Callable[[Any, Any], bool]) -> tuple[int, int]:
    """Return the number of equal items at the start and at the end of two lists.

    Args:
        a: A list.
        b: Another list.
        equal: Whether two items are equal.
    """
    least = min(len(a), len(b))
    first = next((i for i in range(least) if not equal(a[i], b[i])), least)
    last = next((i for i in range(least - first) if not equal(a[-1 - i], b[-1 - i])), least - first)
    return first, last


def measure(value: Any, depth: int = 0) -> tuple[int, int]:
    """Return the number of values in a value, and their depth.

    Raises:
        Refusal: If the language cannot write it.
    """
    if depth > MAX_DEPTH:
        raise Refusal(f"it is nested more than {MAX_DEPTH} deep", "value")
    if isinstance(value, dict | list):
        rows = value.values() if isinstance(value, dict) else value
        for name in value if isinstance(value, dict) else ():
            check_text(name, "value")
        inner = [measure(row, depth + 1) for row in rows]
        return 1 + sum(size for size, _ in inner), 1 + max((deep for _, deep in inner), default=0)
    if isinstance(value, str):
        check_text(value, "value")
    elif value is not None and not isinstance(value, bool | int | float):
        raise Refusal(f"a case cannot contain {type(value).__name__}", "value")
    elif isinstance(value, float) and not isfinite(value):
        raise Refusal(f"{value} is not a finite number", "value")
    elif value is not None and abs(value) > MAX_NUMBER:
        raise Refusal(f"a number is too large: they go up to {MAX_NUMBER:g}", "value")
    elif value is not None and 0 < abs(value) < MIN_NUMBER:
        raise Refusal("a number is too small: write 0", "value")
    return 1, 0


def check_text(text: object, member: str) -> None:
    """Check that a case can contain a key or text.

    Raises:
        Refusal: If it cannot.
    """
    if not isinstance(text, str):
        raise Refusal(f"a key is a text (got {text!r:.40})", member)
    if len(text) > MAX_SCALAR:
        raise Refusal(f"a text is longer than {MAX_SCALAR} characters", member)
    try:
        check_source(Source(text))
    except SpecError as error:
        raise Refusal(error.problems[0].message, member) from None
