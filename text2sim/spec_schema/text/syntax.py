"""Messages for errors of the YAML parser."""

import re
from unicodedata import name

import yaml

from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.text.masking import find_unclosed, unmask
from text2sim.spec_schema.text.source import Source

# Messages of the parser, and ours for authors.
_SYNTAX = (
    ("expected node content", "a value is missing here, or a bracket is closed that was not opened"),
    ("found character '\\t'", "tabs cannot indent; use spaces"),
    ("could not find expected ':'", "a key needs a colon and a space after it"),
    ("mapping values are not allowed", "a second `: ` in one line; quote the text, or start a new line"),
    ("did not find expected key", "this does not fit the indentation of the lines above"),
    ("did not find expected ',' or '}'", "a comma or a closing `}` is missing"),
    ("did not find expected ',' or ']'", "a comma or a closing `]` is missing"),
    ("did not find expected '-' indicator", "this does not fit the indentation of the list above"),
    ("found unexpected end of stream", "the quote that starts here is never closed"),
    ("found undefined tag handle", "tags are not part of the language"),
    ("block sequence entries are not allowed", "a list entry cannot start here"),
)


_COLOR = re.compile(r"[:,\[]\s+(#[0-9a-fA-F]{3,8})\b")
_KEY = re.compile(r"\s*[\w.]+\s*:(\s|$)")


def _comment_color(source: Source, before: int) -> tuple[int, int] | None:
    """Return the position of the last colour like `#ff8800` without quotes, which is a comment, up to a line."""
    for line in range(before, max(0, before - 12), -1):
        found = _COLOR.search(source.lines[line - 1])
        if found is not None:
            return line, found.start(1) + 1
    return None


def _bare_line(source: Source, line: int) -> int | None:
    """Return the line above, if it lacks a colon or the space after it, and this line has a key."""
    above = next((n for n in range(line - 1, 0, -1) if source.lines[n - 1].strip()), None)
    if above is None or not _KEY.match(source.lines[line - 1]):
        return None
    text = source.lines[above - 1].split(" #")[0].strip()
    return above if re.fullmatch(r"[A-Za-z_]\w*(:|\s)\s*\S.*", text) and not _KEY.match(text) else None


LOOK_ALIKE = re.compile("[\u00a0\u2000-\u200a\u202f\u205f\u3000\uff1a\uff0c\uff3b\uff3d\uff5b\uff5d\u2018-\u201f]")
"""Special spaces, wide punctuation and curly quotes, as from word processors and chats."""


def _look_alike(source: Source, line: int) -> tuple[int, int, str] | None:
    """Return line, column and character of a look-alike on the line of an error or on the line before it."""
    for number in (line - 1, line):
        found = LOOK_ALIKE.search(source.lines[number - 1].partition(" #")[0]) if number > 0 else None
        if found is not None:
            return number, found.start() + 1, found[0]
    return None


def taken_for_text(character: str) -> str:
    """Return the message about a character that looks like one of YAML's."""
    return f"`{character}` is {name(character, 'no ASCII')}, which YAML reads as text; type the ASCII character"


def syntax_problem(source: Source, error: yaml.YAMLError) -> Problem:
    """Return the problem of a parser error, at the position of its cause."""
    mark = getattr(error, "problem_mark", None)
    unclosed = find_unclosed(source.text)
    if unclosed is not None and (mark is None or unclosed < mark.index):
        line, column = source.place(unclosed)
        rest = source.lines[line - 1][column - 1 :]
        where = "on its line" if "}" not in rest else "where its text ends"
        return Problem("", f"`${{` has no closing brace {where}", line, column, source.file, rule="expression")
    text = unmask(str(getattr(error, "problem", None) or error))
    if any(words in str(getattr(error, "context", "")) for words in ("quoted scalar", "simple key")):
        mark = getattr(error, "context_mark", None) or mark
    line, column = (mark.line + 1, mark.column + 1) if mark is not None else (1, 1)
    line = min(line, len(source.lines))
    if (alike := _look_alike(source, line)) is not None:
        line, column, character = alike
        return Problem("", f"not valid YAML: {taken_for_text(character)}", line, column, source.file, rule="syntax")
    message = next((plain for words, plain in _SYNTAX if words in text), None)
    rest = source.lines[line - 1][column - 1 :]
    opened = getattr(error, "context_mark", None)
    if "flow" in str(getattr(error, "context", "")) or "expected node content" in text:
        if (color := _comment_color(source, line)) is not None:
            line, column = color
            message = "`#` begins a comment; put the colour in quotes"
        elif opened is not None and opened.line + 1 < line and message is not None:
            message += f" (opened in line {opened.line + 1}, column {opened.column + 1})"
    elif "mapping values are not allowed" in text and (bare := _bare_line(source, line)) is not None:
        line, column = bare, 1 + len(source.lines[bare - 1]) - len(source.lines[bare - 1].lstrip())
        message = "a key needs a colon and a space after it"
    if rest.startswith("\t"):
        message = "tabs cannot indent; use spaces"
    elif message is None:
        message = " ".join(text.split())
        if rest[:1] in ("@", "`", "%"):
            message = f"text cannot start with `{rest[0]}`; quote it"
    return Problem("", f"not valid YAML: {message}", line, column, source.file, rule="syntax")
