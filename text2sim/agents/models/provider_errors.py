"""Provider errors as messages for users, without API keys, and whether to retry."""

import os
import re
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import Any

from text2sim.agents.models.exchange import ModelError
from text2sim.assets.confined import SECRET_WORDS

MAX_MESSAGE_LENGTH = 400
"""Longest provider message that is shown [characters]."""
TRANSIENT_STATUSES = frozenset({408, 409, 425, 429, 500, 502, 503, 504, 520, 522, 524, 529})
"""HTTP status codes after which the same request may succeed."""
_FINAL_WORDS = ("insufficient_quota", "exceeded your current quota", "billing", "credit balance")
"""Words of an error that is about payment, so that waiting does not help."""
_KEYS = re.compile(r"\b(?:sk|pk|gsk|xai|AIza|hf|key)[-_][\w*.-]{6,}|\bAIza[\w-]{10,}|(?i:bearer)\s+\S+")
_NOISE = re.compile(r"^(?:litellm\.)?(?:\w+(?:Error|Exception)\s*[:-]\s*)+")
_ADVICE = {
    401: "it does not accept the key",
    403: "the key may not do this",
    404: "it knows no such model, or no such address",
    408: "it took too long",
    413: "the request is too large",
    429: "too many requests",
}


def without_keys(text: str) -> str:
    """Redact everything that is, or looks like, an API key."""
    for name, value in os.environ.items():
        if len(value) >= 8 and any(word in name.upper() for word in SECRET_WORDS):
            text = text.replace(value, "[key]")
    return _KEYS.sub("[key]", text)


def model_error(who: str, error: Exception) -> ModelError:
    """Convert an error of the client library.

    Args:
        who: Name of the endpoint.
        error: An exception with `status_code` and `message`, like those of OpenAI's client.
    """
    status = status_of(error)
    message = str(getattr(error, "message", None) or error).split(", Received response -")[0]
    message = " ".join(without_keys(_NOISE.sub("", message)).split())
    message = message if len(message) <= MAX_MESSAGE_LENGTH else message[: MAX_MESSAGE_LENGTH - 1] + "…"
    final = any(word in message.lower() for word in _FINAL_WORDS)
    retryable = (status is None or status in TRANSIENT_STATUSES) and not final
    number = f" ({status})" if status is not None else ""
    advice = f"{_ADVICE[status]}; " if status in _ADVICE and not final else ""
    return ModelError(f"{who}{number}: {advice}{message or type(error).__name__}", retryable=retryable)


def status_of(error: Exception) -> int | None:
    """Return the HTTP status of an error; None if there was no response."""
    if type(error).__name__ in ("Timeout", "APITimeoutError", "APIConnectionError"):
        return None  # litellm invents a status for these
    status = getattr(error, "status_code", None)
    return status if isinstance(status, int) else None


def wait_asked(error: Exception) -> float | None:
    """Return the waiting time [s] that a provider asks for with `Retry-After`, in either form; None without one."""
    headers: Any = getattr(getattr(error, "response", None), "headers", None)
    if not headers or "retry-after" not in headers:
        headers = getattr(error, "litellm_response_headers", None)
    value = str(headers.get("retry-after") or headers.get("Retry-After") or "") if headers else ""
    try:
        return max(0.0, float(value)) if float(value) < 1e9 else None
    except ValueError:
        pass
    try:
        return max(0.0, (parsedate_to_datetime(value) - datetime.now(UTC)).total_seconds())
    except (ValueError, TypeError, OverflowError):
        return None
