"""Messages to a model and its replies, as plain values."""

import json
import re
from dataclasses import dataclass
from hashlib import sha256
from typing import Any, Literal

from text2sim.spec_schema.errors import AssetError, Text2SimError

MAX_IMAGE = 4_000_000
"""Largest picture [bytes] that is sent to a model."""
MEDIA_TYPES = {"image/png": ("png", b"\x89PNG\r\n\x1a\n"), "image/jpeg": ("jpg", b"\xff\xd8\xff")}
"""Media types that every provider accepts, with file extension and first bytes."""

Speaker = Literal["system", "user", "assistant"]

_ROLE = re.compile(r"[a-z][a-z0-9_-]{0,39}")
_IMAGE_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.@-]{0,99}")


class ModelError(Text2SimError):
    """Error: a model gave no reply.

    Attributes:
        retryable: Whether the same request may succeed later.
    """

    def __init__(self, message: str, *, retryable: bool = False) -> None:
        self.retryable = retryable
        super().__init__(message)


class StoppedError(ModelError):
    """Error: a call was given up at the caller's request."""


@dataclass(frozen=True)
class Image:
    """An image for a model.

    Raises:
        AssetError: If it is not a PNG or JPEG, too large, or its name is not a plain file name.
    """

    name: str
    """Its name in the text, such as `frame_03.png`."""
    media_type: str
    """`image/png` or `image/jpeg`."""
    data: bytes

    def __post_init__(self) -> None:
        if not _IMAGE_NAME.fullmatch(self.name) or ".." in self.name:
            raise AssetError(f"{self.name[:100]!r} is not a plain file name for a picture")
        if self.media_type not in MEDIA_TYPES:
            raise AssetError(f"{self.name}: models get PNG and JPEG, not {self.media_type[:60]!r}")
        if not self.data.startswith(MEDIA_TYPES[self.media_type][1]):
            raise AssetError(f"{self.name}: the content is not {self.media_type}")
        if len(self.data) > MAX_IMAGE:
            raise AssetError(f"{self.name}: {len(self.data):,} bytes; a picture may have {MAX_IMAGE:,}")

    @property
    def ending(self) -> str:
        """Its file extension, without the dot."""
        return MEDIA_TYPES[self.media_type][0]

    @property
    def digest(self) -> str:
        """SHA-256 of its bytes."""
        return sha256(self.data).hexdigest()


@dataclass(frozen=True)
class Message:
    """One turn of a conversation."""

    role: Speaker
    text: str
    images: tuple[Image, ...] = ()


@dataclass(frozen=True)
class ModelRequest:
    """Input of one model call."""

    role: str
    """Role that asks, such as `planner`: a lower-case word, part of file names."""
    messages: tuple[Message, ...]
    schema: dict[str, Any] | None = None
    """JSON Schema of the answer, for models that support it; the text must describe the form as well."""
    max_tokens: int = 16_000
    """Longest reply."""
    temperature: float | None = None
    """None for the provider's default."""
    number: int = 1
    """Number of this call among those of its role, from 1; part of the file names in a mailbox."""

    def __post_init__(self) -> None:
        if not _ROLE.fullmatch(self.role):
            raise ValueError(f"{self.role!r} is not the name of a role")
        if self.number < 1 or not self.messages:
            raise ValueError("a request has messages, and a number from 1 on")

    @property
    def stem(self) -> str:
        """Prefix of its file names, such as `planner-01`."""
        return f"{self.role}-{self.number:02}"

    def as_dict(self) -> dict[str, Any]:
        """Return everything that the model is sent as plain data, with images by name, size and SHA-256."""
        return {
            "role": self.role,
            "messages": [
                {
                    "role": message.role,
                    "text": message.text,
                    "images": [
                        {"name": i.name, "media_type": i.media_type, "bytes": len(i.data), "sha256": i.digest}
                        for i in message.images
                    ],
                }
                for message in self.messages
            ],
            "schema": self.schema,
            "max_tokens": self.max_tokens,
            "temperature": self.temperature,
        }

    def digest(self) -> str:
        """Return the SHA-256 of everything that the model is sent; `number` and the order of keys do not matter."""
        text = json.dumps(self.as_dict(), sort_keys=True, ensure_ascii=True, allow_nan=False)
        return sha256(text.encode()).hexdigest()


@dataclass(frozen=True)
class Reply:
    """A model's reply and its cost."""

    text: str
    tokens_in: int
    tokens_out: int
    cost: float | None
    """Cost [US$]; None if unknown."""
    seconds: float
    model: str
    cached: bool = False
    """Whether it was stored, so that the model was not called."""
    free: bool = False
    """Whether another case paid for it, or it was counted before."""
    estimated: bool = False
    """Whether we counted the tokens instead of the provider."""
    truncated: bool = False
    """Whether it ended at `max_tokens`."""


@dataclass(frozen=True)
class ModelName:
    """A model's name on the command line, parsed."""

    model: str
    """`provider/model`, or the model's name at `url`."""
    url: str | None = None
    """Root of an OpenAI-compatible API; None for the provider's own."""
    vision: bool | None = None
    """Whether it accepts images; None to ask litellm."""
    schema: bool | None = None
    """Whether it supports JSON Schema; None to ask litellm."""
