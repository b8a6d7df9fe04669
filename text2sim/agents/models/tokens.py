"""Token estimates for texts and images, where the provider does not report them.

Text: tokens of the encoding cl100k if it is available offline, else a quarter of the characters.
Images: one token per 750 pixels, at most 1,600. Each message adds four.
Prompt caches: providers cache the prefix of a conversation from 1,024 tokens on, in steps of 128.
"""

import importlib.util
import math
import os
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from threading import Lock
from typing import Any

from text2sim.agents.models.exchange import Image, ModelRequest

TOKENS_PER_MESSAGE = 4
PIXELS_PER_TOKEN = 750
MAX_IMAGE_TOKENS = 1_600
CACHED_FROM, CACHED_STEP = 1_024, 128
"""Shortest cached prefix, and the steps in which it grows [tokens]."""
PIECE_LENGTH = 2_000
"""Length of the pieces that are encoded [characters]; the encoder is quadratic in the length of text without spaces."""
_CL100K = "9b5ad71b2ce5302211f9c61530b329a4922fc6a4"
"""Name of tiktoken's file with the table of cl100k: the hash of its URL."""
_lock = Lock()


def text_tokens(text: str) -> int:
    """Return the number of tokens of a text."""
    with _lock:
        encoding = _encoding()
    if encoding is None:
        return math.ceil(len(text) / 4)
    pieces = [text[i : i + PIECE_LENGTH] for i in range(0, len(text), PIECE_LENGTH)]
    return sum(len(encoding.encode_ordinary(piece)) for piece in pieces)


def image_tokens(image: Image) -> int:
    """Return the number of tokens of an image, from its size alone."""
    from PIL import Image as Picture

    try:
        with Picture.open(BytesIO(image.data)) as picture:  # reads the header only
            width, height = picture.size
    except (OSError, ValueError, SyntaxError, Picture.DecompressionBombError):
        return MAX_IMAGE_TOKENS
    return min(math.ceil(width * height / PIXELS_PER_TOKEN), MAX_IMAGE_TOKENS)


def request_tokens(request: ModelRequest) -> int:
    """Return the number of tokens of all messages of a request, including images."""
    return sum(
        TOKENS_PER_MESSAGE + text_tokens(message.text) + sum(map(image_tokens, message.images))
        for message in request.messages
    )


class PromptPrefixes:
    """Requests sent to each model so far, to estimate cached prefixes.

    An image ends a prefix, so the estimate is a lower bound.
    """

    def __init__(self) -> None:
        self._sent: dict[str, list[str]] = {}

    def cached_tokens(self, model: str, request: ModelRequest) -> int:
        """Return the tokens of a request's prefix that this model has seen before; remember the request."""
        text = ""
        for message in request.messages:
            text += f"{message.role}\n{message.text}\n"
            if message.images:
                break
        earlier = self._sent.setdefault(model, [])
        shared = text[: max((common_prefix_length(text, other) for other in earlier), default=0)]
        earlier.append(text)
        tokens = text_tokens(shared) if len(shared) >= CACHED_FROM else 0
        return tokens // CACHED_STEP * CACHED_STEP if tokens >= CACHED_FROM else 0


def common_prefix_length(one: str, other: str) -> int:
    """Return the length of the common prefix of two texts [characters], by bisection, which is fast in Python."""
    low, high = 0, min(len(one), len(other))
    while low < high:
        middle = (low + high + 1) // 2
        if one[low:middle] == other[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low


@lru_cache(maxsize=1)
def _encoding() -> Any:
    """The encoding; None if its table is not on this machine, because tiktoken would download it."""
    if importlib.util.find_spec("tiktoken") is None:
        return None
    folders = [os.environ.get("TIKTOKEN_CACHE_DIR", "")]
    found = importlib.util.find_spec("litellm")  # ships the table; no import needed
    if found is not None and found.origin is not None:
        folders.append(str(Path(found.origin).parent / "litellm_core_utils" / "tokenizers"))
    folder = next((f for f in folders if f and (Path(f) / _CL100K).is_file()), None)
    if folder is None:
        return None
    import tiktoken

    before = os.environ.get("TIKTOKEN_CACHE_DIR")
    os.environ["TIKTOKEN_CACHE_DIR"] = folder
    try:
        return tiktoken.get_encoding("cl100k_base")
    except (OSError, ValueError):
        return None
    finally:
        if before is None:
            del os.environ["TIKTOKEN_CACHE_DIR"]
        else:
            os.environ["TIKTOKEN_CACHE_DIR"] = before
