"""Extraction of the data of a reply: from a fenced block, or bare between prose."""

import re
from dataclasses import dataclass

DATA_MARKS = frozenset({"yaml", "yml", "json", "jsonc", "json5"})
"""Marks of blocks that contain data; unmarked blocks come second."""

_LINES = re.compile(r"\r\n|\r|\n")
_FENCE = re.compile(r"( *)(`{3,}|~{3,})(.*)")
_THOUGHT = re.compile(r"\s*<(think|thinking|reasoning)>.*?</\1>", re.DOTALL)
_TOP_KEY = re.compile(r"(?:[A-Za-z_]\w*|\"[^\"]{1,200}\")\s*:(?:\s|$)")
_LIST_ITEM = re.compile(r"- \S")
_INLINE = re.compile(r"\{\s*\"|\[\s*[{\[\"]")


@dataclass(frozen=True)
class FencedBlock:
    """A part of a reply that may be data."""

    text: str
    mark: str = ""
    """The word after the fence, in lower case."""
    line: int = 1
    """Line of the reply in which it starts."""
    closed: bool = True


def without_thoughts(reply: str) -> str:
    """Remove the visible reasoning of a model before its answer."""
    match = _THOUGHT.match(reply)
    return reply[match.end() :] if match else reply


def fenced_blocks(reply: str) -> list[FencedBlock]:
    """Return all fenced blocks in order. The last one may be unclosed, if the reply was cut off."""
    blocks: list[FencedBlock] = []
    lines: list[str] = []
    opened: tuple[str, str, str, int] | None = None  # indentation, fence, mark, line
    for number, line in enumerate(_LINES.split(reply), 1):
        if opened is None:
            match = _FENCE.fullmatch(line)
            if match is not None and not (match[2][0] == "`" and "`" in match[3]):  # else it is inline code
                words = match[3].strip().lower().split("{")[0].split()
                opened, lines = (match[1], match[2], words[0] if words else "", number + 1), []
            continue
        indent, fence, mark, start = opened
        # A fence that is indented more than the one that opened the block is text in the block.
        stripped = line.strip()
        if len(stripped) >= len(fence) and not stripped.strip(fence[0]) and line.startswith((indent + fence, fence)):
            blocks.append(FencedBlock("\n".join(lines), mark, start))
            opened = None
        else:
            lines.append(line.removeprefix(indent))
    if opened is not None:
        blocks.append(FencedBlock("\n".join(lines), opened[2], opened[3], closed=False))
    return blocks


def with_last_fence(reply: str) -> str:
    """Return a complete reply with the fence that its last block lacks; models forget it at the end."""
    answer = without_thoughts(reply)
    blocks = fenced_blocks(answer)
    if not blocks or blocks[-1].closed:
        return reply
    opened = _FENCE.fullmatch(_LINES.split(answer)[blocks[-1].line - 2])
    return f"{reply.rstrip()}\n{opened[1]}{opened[2]}" if opened is not None else reply


def bare_block(reply: str) -> FencedBlock | None:
    """Return the data of a reply without fences: the lines left after removing prose before and after."""
    lines = _LINES.split(reply)
    start = next((i for i, line in enumerate(lines) if _starts_data(line)), None)
    if start is not None and lines[start].rstrip().endswith(":"):
        after = next((i for i in range(start + 1, len(lines)) if lines[i].strip()), start)
        start = after if lines[after][0] in "{[" else start  # a line such as `Well:` before a bracket is prose
    if start is None:
        inline = _INLINE.search(reply)
        end = _closing_index(reply[inline.start() :]) if inline is not None else None
        if inline is None or end is None:
            return None
        text = reply[inline.start() : inline.start() + end]
        return FencedBlock(text, line=len(_LINES.findall(reply[: inline.start()])) + 1)
    text = "\n".join(lines[start:])
    if text.lstrip()[0] in "{[":
        end = _closing_index(text)
        return FencedBlock(text[:end] if end is not None else text, line=start + 1, closed=end is not None)
    end = len(lines)
    while end > start + 1 and not _is_data(lines[end - 1]):
        end -= 1
    return FencedBlock("\n".join(lines[start:end]), line=start + 1)


def looks_like_json(text: str) -> bool:
    """Whether a collection begins like JSON rather than like a YAML flow collection: with a quote or a comment."""
    return text.lstrip()[:1] in ("{", "[") and text.lstrip(" \t\r\n{[")[:1] in ('"', "/")


def plain_json(text: str) -> str:
    """Turn lenient JSON into YAML with the same lines: comments become blanks, surrogate pairs one character."""
    pieces: list[str] = []
    done = 0
    for match in _JSON_PART.finditer(text):
        pieces.append(text[done : match.start()])
        part = match[0]
        pieces.append(_SURROGATES.sub(_join_surrogates, part) if part[0] == '"' else re.sub(r"[^\n]", " ", part))
        done = match.end()
    return "".join([*pieces, text[done:]])


# The last two patterns also match unterminated, up to the end of the text, so that nothing is searched twice.
_JSON_PART = re.compile(r'"(?:[^"\\\n]|\\.)*"?|//[^\n]*|/\*(?:[^*]|\*(?!/))*(?:\*/)?')
_SURROGATES = re.compile(r"(?<!\\)((?:\\\\)*)\\u([dD][89abAB][0-9a-fA-F]{2})\\u([dD][c-fC-F][0-9a-fA-F]{2})")


def _join_surrogates(match: re.Match[str]) -> str:
    high, low = int(match[2], 16) - 0xD800, int(match[3], 16) - 0xDC00
    return f"{match[1]}\\U{0x10000 + high * 0x400 + low:08X}"


def _starts_data(line: str) -> bool:
    return line.lstrip()[:1] in ("{", "[") or bool(_TOP_KEY.match(line)) or bool(_LIST_ITEM.match(line))


def _is_data(line: str) -> bool:
    """Whether a line can be the last one of block YAML: it is indented, a key, an item or a comment."""
    return line[:1] in (" ", "#", "}", "]") and bool(line.strip()) or _starts_data(line)


def _closing_index(text: str) -> int | None:
    """Index after the bracket that closes the first one; None if none does."""
    depth = 0
    for match in re.finditer(r'"(?:[^"\\\n]|\\.)*"?|[{}\[\]]', text):
        if match[0] in ("{", "["):
            depth += 1
        elif match[0] in ("}", "]"):
            depth -= 1
            if depth == 0:
                return match.end()
    return None
