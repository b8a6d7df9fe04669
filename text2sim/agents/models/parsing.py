"""Parsing of the data in a model's reply; nothing in it is executed, opened or followed."""

from typing import Any, NamedTuple

from text2sim.agents.models.commas import rejoined
from text2sim.agents.models.fences import (
    DATA_MARKS,
    FencedBlock,
    bare_block,
    fenced_blocks,
    looks_like_json,
    plain_json,
    without_thoughts,
)
from text2sim.spec_schema.errors import Problem, SpecError, format_problems
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source, check_source

MAX_REPLY_LENGTH = 1_000_000
"""Longest reply that is read [characters]."""
MAX_EXPRESSIONS = 5_000
"""Largest number of `${` in a reply."""
ON_A_LINE = 500
"""Largest number of `${` on one line, since the parser scans the rest of the line for each of them."""
MAX_SHOWN_PROBLEMS = 10
"""Largest number of problems that are sent back to the model."""
MAX_KEPT_PROBLEMS = 100
"""Largest number of problems that are kept."""
FILE = "reply"
MERGE = "<<"


class Parsed(NamedTuple):
    """Parsed data of a reply."""

    data: Any
    """A mapping or a list of plain values."""
    text: str
    """The block that contains it."""


class ReplyError(SpecError):
    """Error: a reply holds no usable data. Its message is short and can be sent back to the model."""

    def __init__(self, problems: list[Problem], source: Source | None = None) -> None:
        super().__init__(problems)
        shown = format_problems(self.problems[:MAX_SHOWN_PROBLEMS], source)
        more = len(self.problems) - MAX_SHOWN_PROBLEMS
        self.feedback = f"{shown}\n… and {more} more problems" if more > 0 else shown

    def __str__(self) -> str:
        return self.feedback


def read_reply(text: str) -> Parsed:
    """Return the data of a reply.

    The data is in a fenced block (the last complete one marked as YAML or JSON, else the last unmarked one), or bare,
    with or without prose around it. JSON may contain comments and trailing commas. Anchors, aliases and merge
    keys are read, although cases have none: who describes three alike fingers uses them.

    Raises:
        ReplyError: If it holds no data, or data that is incomplete or invalid, has duplicate keys, tags or
            unknown aliases, or is too deep or too large. Line numbers refer to the whole reply.
    """
    if len(text) > MAX_REPLY_LENGTH:
        raise _error(f"the reply has {len(text):,} characters; {MAX_REPLY_LENGTH:,} are read", "too-large")
    block = _choose(text.replace("\ufeff", ""))
    # Blank lines replace those before the block, so that line numbers are those of the reply.
    content = block.text + "\n"
    if looks_like_json(content):
        content = plain_json(content)
    source = Source("\n" * (block.line - 1) + content, FILE)
    _bound_expressions(source, block.line)
    text, lost = rejoined(source.text)
    if lost:
        message = f"`{lost[0][1][:60]}` has no value: in {{…}} a comma ends a value; quote text that has one"
        raise _error(message, "no-value", lost[0][0] + 1)
    source = Source(text, FILE)
    try:
        data = _merged(parse_document(check_source(source), aliases=True).data)
    except SpecError as error:
        raise ReplyError(error.problems[:MAX_KEPT_PROBLEMS], source) from None
    if not isinstance(data, dict | list):
        raise _error("the block holds no mapping and no list", "no-data", block.line)
    return Parsed(data, block.text)


def _merged(data: Any) -> Any:
    """Return data with merge keys (`<<: *base`) applied: a mapping's own keys take the place of merged ones."""
    if isinstance(data, list):
        return [_merged(row) for row in data]
    if not isinstance(data, dict):
        return data
    own = {key: _merged(value) for key, value in data.items()}
    bases = own.pop(MERGE, {})
    rows = bases if isinstance(bases, list) else [bases]
    if not all(isinstance(row, dict) for row in rows):
        return {**own, MERGE: bases}
    return {key: value for row in [*reversed(rows), own] for key, value in row.items()}


def _choose(text: str) -> FencedBlock:
    answer = without_thoughts(text)
    skipped = text[: len(text) - len(answer)].count("\n")
    blocks = fenced_blocks(answer)
    marked = [block for block in blocks if block.mark in DATA_MARKS] or [block for block in blocks if not block.mark]
    complete = [block for block in marked if block.closed and block.text.strip()]
    block = complete[-1] if complete else None
    if block is None and marked and not marked[-1].closed:
        line = marked[-1].line - 1 + skipped
        raise _error("the block that starts here is not closed; send it again, whole", "not-closed", line)
    if block is None and not blocks:
        block = bare_block(answer)
        if block is not None and not block.closed:
            raise _error("the brackets that open here are not closed; send it again, whole", "not-closed", block.line)
    if block is None:
        message = "the reply is empty" if not text.strip() else "the reply has no block of data"
        raise _error(f"{message}; answer with one fenced ```yaml block", "no-data")
    return FencedBlock(block.text, block.mark, block.line + skipped)


def _bound_expressions(source: Source, first: int) -> None:
    total = source.text.count("${")
    if total > MAX_EXPRESSIONS:
        raise _error(f"the block has {total:,} expressions; {MAX_EXPRESSIONS:,} are read", "too-large", first)
    for number, line in enumerate(source.lines, 1):
        if line.count("${") > ON_A_LINE:
            raise _error(f"the line has more than {ON_A_LINE} expressions", "too-large", number)


def _error(message: str, rule: str, line: int = 1) -> ReplyError:
    return ReplyError([Problem("", message, line, 1, FILE, rule=rule)])
