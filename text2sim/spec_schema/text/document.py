"""YAML document as plain data, with the position of every key and value."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce
from operator import getitem
from typing import Any

import yaml

from text2sim.spec_schema.errors import Problem, Severity, SpecError, sort_problems
from text2sim.spec_schema.text.masking import MARK, mask, unmask
from text2sim.spec_schema.text.nodes import Node, Origin, Path, Step
from text2sim.spec_schema.text.scalars import Scalar, resolve
from text2sim.spec_schema.text.source import Source
from text2sim.spec_schema.text.syntax import LOOK_ALIKE, syntax_problem, taken_for_text

MAX_NODES = 300_000
MAX_DEPTH = 40
MAX_SCALAR = 20_000

# libyaml, if available: ten times as fast, with the same events.
open_parser: Any = getattr(yaml, "CBaseLoader", yaml.BaseLoader)


@dataclass(frozen=True)
class Document:
    """A parsed document.

    Attributes:
        source: Its text.
        data: Its content, with `${…}` as text.
        root: Positions.
        sites: Every scalar with `${` in it, by path.
        composed: Paths of composed expressions, which may be longer than written ones.
    """

    source: Source
    data: Any
    root: Node
    sites: dict[Path, str]
    composed: frozenset[Path] = frozenset()

    def place(self, path: Path, *, key: bool = False) -> tuple[int, int]:
        """Return the line and column of a value, or of its key; of its nearest existing ancestor, if it is missing."""
        *above, node = nodes = list(self._nodes(path))
        if key and above and isinstance(above[-1].children, dict):
            return above[-1].keys[str(path[len(nodes) - 2])]
        return node.line, node.column

    def origin(self, path: Path) -> Origin | None:
        """Return where a value comes from, if it is not in the file itself."""
        return [*self._nodes(path)][-1].origin

    def _nodes(self, path: Path) -> Iterator[Node]:
        """Yield the nodes along a path, as far as they exist."""
        node = self.root
        yield node
        for step in path:
            children: Any = node.children
            if isinstance(children, dict) and step in children:
                node = children[step]
            elif isinstance(children, list) and isinstance(step, int) and step < len(children):
                node = children[step]
            else:
                return
            yield node

    def problem(
        self,
        path: Path,
        message: str,
        *,
        key: bool = False,
        rule: str,
        hint: str | None = None,
        severity: Severity = "error",
    ) -> Problem:
        """Return a problem at a position of the document.

        Args:
            path: Path of the value.
            message: What is wrong.
            key: Whether to point at the key instead of the value.
            rule: Id of the rule.
            hint: The nearest valid word.
            severity: `error` or `warning`.
        """
        line, column = self.place(path, key=key)
        origin = self.origin(path)
        if origin is not None:
            message += f" ({origin})"
        return Problem(pointer(path), message, line, column, self.source.file, hint, rule, severity)


def pointer(path: Path) -> str:
    """Return the JSON Pointer (RFC 6901) of a path."""
    return "".join("/" + str(step).replace("~", "~0").replace("/", "~1") for step in path)


_INDEX = re.compile(r"0|[1-9][0-9]{0,8}")
"""Not every word of digits: `007` and `²` are keys."""


def parse_pointer(text: str) -> Path:
    """Return the path of a JSON Pointer; steps that can be indices of a list are integers."""
    if text in ("", "/"):
        return ()
    steps = text.removeprefix("/").split("/")
    return tuple(int(s) if _INDEX.fullmatch(s) else s.replace("~1", "/").replace("~0", "~") for s in steps)


def sites_of(data: Any, root: Path = ()) -> dict[Path, str]:
    """Return every scalar with `${` in it, by path."""
    return {path: value for path, value in leaves(data, root) if isinstance(value, str) and "${" in value}


def leaves(data: Any, root: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield scalars and empty collections, by path below `root`."""
    stack: list[tuple[Path, Any]] = [(root, data)]
    while stack:
        path, value = stack.pop()
        if isinstance(value, dict) and value:
            stack += [((*path, key), item) for key, item in reversed(value.items())]
        elif isinstance(value, list) and value:
            stack += [((*path, index), item) for index, item in reversed(list(enumerate(value)))]
        else:
            yield path, value


def value_at(data: Any, path: Path) -> Any:
    """Return the value at an existing path of plain data."""
    return reduce(getitem, path, data)


def find_value(data: Any, path: Path, missing: Any = None) -> Any:
    """Return the value at a path of plain data.

    Args:
        data: The data.
        path: The path.
        missing: What is returned if there is nothing at the path.
    """
    for step in path:
        if isinstance(data, dict) and step in data:
            data = data[step]
        elif isinstance(data, list) and isinstance(step, int) and step < len(data):
            data = data[step]
        else:
            return missing
    return data


def parse_document(source: Source, *, aliases: bool = False) -> Document:
    """Parse one YAML document.

    Args:
        source: The text.
        aliases: Whether to put what an anchor marks in the place of its aliases, as far as the largest number of values
            allows.

    Raises:
        SpecError: If it is not valid YAML, has a duplicate key, or uses a part of YAML that the language excludes:
            anchors and aliases, unless they are allowed, tags, several documents, numbers that are not finite.
    """
    try:
        return _Composer(source, aliases=aliases).compose()
    except yaml.YAMLError as error:
        raise SpecError([syntax_problem(source, error)]) from None


class _Composer:
    """Conversion of the parser's events to data and positions in one pass, without recursion."""

    def __init__(self, source: Source, *, aliases: bool = False) -> None:
        self.source, self.aliases = source, aliases
        self.problems: list[Problem] = []
        self.sites: dict[Path, str] = {}
        # One frame for each open collection: its data and its node; and the key that awaits a value.
        self.frames: list[tuple[Any, Node]] = []
        self.keys: list[Any] = []
        self.cache: dict[str, Scalar] = {}

    def compose(self) -> Document:
        parser = open_parser(mask(self.source.text))
        if self.aliases:
            parser = _Repeating(parser)
        data: Any = None
        root: Node | None = None
        count = 0
        frames, keys = self.frames, self.keys
        while True:
            event = parser.get_event()
            if event is None or isinstance(event, yaml.StreamEndEvent):
                break
            if isinstance(event, yaml.ScalarEvent):
                mark = event.start_mark
                if frames and keys[-1] is _KEY:
                    keys[-1] = self._key(event)
                    continue
                value: Any = self._scalar(event)
                node = Node(mark.line + 1, mark.column + 1)
            elif isinstance(event, yaml.CollectionStartEvent):
                mark = event.start_mark
                node = Node(mark.line + 1, mark.column + 1)
                if frames and keys[-1] is _KEY:
                    raise self._fatal(mark, "a key must be a word, not a collection; expressions are ${…}", "key")
                self._refuse(event)
                mapping = isinstance(event, yaml.MappingStartEvent)
                value = {} if mapping else []
                node.children = {} if mapping else []
            elif isinstance(event, yaml.CollectionEndEvent):
                frames.pop()
                keys.pop()
                continue
            elif isinstance(event, yaml.AliasEvent):
                message = f"aliases (`*{event.anchor}`) are not part of the language; use params or repeat"
                if self.aliases:
                    message = f"no value before is marked as `&{event.anchor}`"
                raise self._fatal(event.start_mark, message, "alias")
            elif isinstance(event, yaml.DocumentStartEvent) and root is not None:
                raise self._fatal(event.start_mark, "a file has one document; a second one starts here", "documents")
            else:
                continue

            count += 1
            if count > MAX_NODES:
                raise self._fatal(mark, f"the document has more than {MAX_NODES} values", "too-large")
            if not frames:
                data, root = value, node
            else:
                self._put(value, node)
            if node.children is not None:
                if len(frames) >= MAX_DEPTH:
                    raise self._fatal(mark, f"the document is nested more than {MAX_DEPTH} deep", "too-deep")
                frames.append((value, node))
                keys.append(_KEY if isinstance(value, dict) else None)

        if self.problems:
            raise SpecError(sort_problems(self.problems))
        if root is None:
            raise SpecError([Problem("", "the file is empty", file=self.source.file, rule="empty")])
        return Document(self.source, data, root, self.sites)

    def _put(self, value: Any, node: Node) -> None:
        data, parent = self.frames[-1]
        if isinstance(data, list):
            data.append(value)
            assert isinstance(parent.children, list)
            parent.children.append(node)
            return
        key, line, column = self.keys[-1]
        self.keys[-1] = _KEY
        if key in data:
            first = parent.keys[key]
            message = f"the key `{key}` is already in line {first[0]}"
            path = pointer((*self._path(), key))
            self.problems.append(Problem(path, message, line, column, self.source.file, rule="duplicate-key"))
            return
        data[key] = value
        assert isinstance(parent.children, dict)
        parent.children[key] = node
        parent.keys[key] = (line, column)

    def _path(self) -> Path:
        """Return the path of the innermost open collection."""
        path: list[Step] = []
        for data, _ in self.frames[:-1]:
            path.append(len(data) - 1 if isinstance(data, list) else next(reversed(data)))
        return tuple(path)

    def _key(self, event: Any) -> tuple[str, int, int]:
        self._refuse(event)
        mark = event.start_mark
        if event.style in _PLAIN and (alike := LOOK_ALIKE.search(event.value)):
            line, column = mark.line + 1, mark.column + alike.start() + 1
            text = f"not valid YAML: {taken_for_text(alike[0])}"
            self.problems.append(Problem("", text, line, column, self.source.file, rule="syntax"))
        return self._text(event), mark.line + 1, mark.column + 1

    def _scalar(self, event: Any) -> Scalar:
        self._refuse(event)
        text = event.value
        if event.style in _PLAIN and MARK not in text:
            if text in self.cache:
                return self.cache[text]
            try:
                value = resolve(unmask(text))
            except ValueError as error:
                self._add(event.start_mark, str(error), "number")
                return None
            self.cache[text] = value
            if not isinstance(value, str):
                return value
        value = self._text(event)
        if "${" in value:
            step: Step = ""
            path: Path = ()
            if self.frames:
                data = self.frames[-1][0]
                step = len(data) if isinstance(data, list) else self.keys[-1][0]
                path = (*self._path(), step)
            self.sites[path] = value
        return value

    def _text(self, event: Any) -> str:
        text = event.value
        if len(text) > MAX_SCALAR:
            raise self._fatal(event.start_mark, f"the text is longer than {MAX_SCALAR} characters", "too-large")
        if event.style == '"':
            written = self.source.text[event.start_mark.index : event.end_mark.index]
            if "\\" in written and (_ESCAPED.search(written) or _CONTROL.search(text)):
                self._add(event.start_mark, "the text has an escape for a character that is not allowed", "character")
        return unmask(text)

    def _refuse(self, event: Any) -> None:
        if event.anchor is not None and not self.aliases:
            message = f"anchors (`&{event.anchor}`) are not part of the language; use params or repeat"
            raise self._fatal(event.start_mark, message, "alias")
        if event.tag is not None:
            raise self._fatal(event.start_mark, f"tags (`{event.tag}`) are not part of the language", "tag")

    def _add(self, mark: Any, message: str, rule: str) -> None:
        self.problems.append(Problem("", message, mark.line + 1, mark.column + 1, self.source.file, rule=rule))

    def _fatal(self, mark: Any, message: str, rule: str) -> SpecError:
        self._add(mark, message, rule)
        return SpecError(self.problems)


class _Repeating:
    """A parser that yields the events of what an anchor marks again for each alias."""

    def __init__(self, parser: Any) -> None:
        self._parser = parser
        self._known: dict[str, list[Any]] = {}
        self._open: list[tuple[list[Any], int]] = []
        """Of each marked collection that is open: its events so far, and the depth outside of it."""
        self._depth = 0
        self._waiting: list[Any] = []

    def get_event(self) -> Any:
        event = self._waiting.pop() if self._waiting else self._parser.get_event()
        if isinstance(event, yaml.AliasEvent) and event.anchor in self._known:
            self._waiting += reversed(self._known[event.anchor])
            return self.get_event()
        for events, _ in self._open:
            events.append(event)
        if isinstance(event, yaml.ScalarEvent) and event.anchor is not None:
            self._known[event.anchor] = [event]
        elif isinstance(event, yaml.CollectionStartEvent):
            if event.anchor is not None:
                self._open.append(([event], self._depth))
            self._depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            self._depth -= 1
            if self._open and self._open[-1][1] == self._depth:
                events, _ = self._open.pop()
                self._known[events[0].anchor] = events
        return event


_KEY = object()
"""Marks a mapping that awaits its next key."""
_PLAIN = (None, "")
# Escapes for the private use area would be read as masks, those for control characters hide text.
_ESCAPED = re.compile(r"\\u[eE][0-9a-fA-F]{3}|\\U0000[eE]|\\U000[fF]|\\U0010")
_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\u202a-\u202e\u2066-\u2069\ufeff]")


def mapping_at(data: Any, key: Any) -> dict[str, Any]:
    """Return the mapping under a key of data, or an empty one."""
    value = data.get(key) if isinstance(data, dict) else None
    return value if isinstance(value, dict) else {}
