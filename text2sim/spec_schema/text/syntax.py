"""Errors of the YAML parser in plain words."""

import yaml

from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.text.masking import find_unclosed, unmask
from text2sim.spec_schema.text.source import Source

# What the parser says, and what it means to someone who writes a case.
_SYNTAX = (
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


def syntax_problem(source: Source, error: yaml.YAMLError) -> Problem:
    """Say what the parser stumbled over, at the place where an author would look for it."""
    mark = getattr(error, "problem_mark", None)
    unclosed = find_unclosed(source.text)
    if unclosed is not None and (mark is None or unclosed < mark.index):
        line, column = source.place(unclosed)
        return Problem("", "`${` has no closing brace on its line", line, column, source.file, rule="expression")
    text = unmask(str(getattr(error, "problem", None) or error))
    if "quoted scalar" in str(getattr(error, "context", "")):
        mark = getattr(error, "context_mark", None) or mark
    line, column = (mark.line + 1, mark.column + 1) if mark is not None else (1, 1)
    line = min(line, len(source.lines))
    message = next((plain for words, plain in _SYNTAX if words in text), None)
    rest = source.lines[line - 1][column - 1 :]
    if rest.startswith("\t"):
        message = "tabs cannot indent; use spaces"
    elif message is None:
        message = " ".join(text.split())
        if rest[:1] in ("@", "`", "%"):
            message = f"text cannot start with `{rest[0]}`; quote it"
    return Problem("", f"not valid YAML: {message}", line, column, source.file, rule="syntax")
