"""Endpoints that answer requests, and their names on the command line."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Protocol
from urllib.parse import urlsplit

from text2sim.agents.models.exchange import ModelError, ModelName, ModelRequest, Reply

ENDPOINT_FORMS = (
    "PROVIDER/MODEL, openai/MODEL@http://HOST:PORT/v1, mailbox:FOLDER or replay:FOLDER; "
    "a model may be followed by ,vision=yes|no and ,schema=yes|no"
)
"""Names that `endpoint_of` accepts, for help and messages."""

ANSWERED_IN_FOLDERS = ("mailbox", "replay")
"""Kinds of endpoints whose name ends with a folder."""
_SPLIT = re.compile(r"@(?=https?://)")
_MODEL = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.:@/+-]{0,199}")
_SWITCH = {"yes": True, "no": False}


class Endpoint(Protocol):
    """A model, or a person or agent in its place; called from several threads at once."""

    @property
    def name(self) -> str:
        """Its name in records, independent of the case folder."""
        ...

    @property
    def vision(self) -> bool:
        """Whether it accepts images."""
        ...

    @property
    def cacheable(self) -> bool:
        """Whether cases may share its replies."""
        ...

    def complete(self, request: ModelRequest, stop: Callable[[], bool]) -> Reply:
        """Answer a request.

        Args:
            request: The request.
            stop: Polled a few times a second; returns whether to give up.

        Raises:
            StoppedError: If `stop` returned true.
            ModelError: If there is no reply.
        """
        ...


def never_stop() -> bool:
    """Return False: the `stop` of callers that never give up."""
    return False


def endpoint_of(spec: str) -> Endpoint:
    """Return the endpoint for a name; see `ENDPOINT_FORMS`.

    Raises:
        ModelError: If the name is invalid, its provider unknown, its key not in the environment, or its folder missing.
    """
    kind, _, rest = spec.partition(":")
    if kind in ANSWERED_IN_FOLDERS:
        from text2sim.agents.models.mailbox import Mailbox, MailboxReplay

        if not rest.strip():
            raise ModelError(f"`{kind}:` needs a folder after it")
        folder = Path(rest.strip()).expanduser().absolute()
        return Mailbox(folder) if kind == "mailbox" else MailboxReplay(folder)
    name = parse_name(spec)
    from text2sim.agents.models.litellm_client import LiteLLMEndpoint

    return LiteLLMEndpoint(name)


def in_subfolder(spec: str, path: str) -> str:
    """Return the name of an endpoint with a folder of its own inside that of `spec`; other names as they are.

    Args:
        spec: Name of an endpoint.
        path: The subfolder.
    """
    folder = spec.startswith(tuple(f"{kind}:" for kind in ANSWERED_IN_FOLDERS))
    return f"{spec.rstrip('/')}/{path}" if folder else spec


def parse_name(spec: str) -> ModelName:
    """Parse the name of a model.

    Raises:
        ModelError: If the name is invalid.
    """
    text, *options = spec.strip().split(",")
    switches: dict[str, bool] = {}
    for option in options:
        key, _, value = option.partition("=")
        if key not in ("vision", "schema") or value not in _SWITCH:
            raise ModelError(f"`{option[:60]}` is not an option of a model; there are vision=yes|no and schema=yes|no")
        switches[key] = _SWITCH[value]
    model, *rest = _SPLIT.split(text, maxsplit=1)
    if not _MODEL.fullmatch(model) or (not rest and "/" not in model):
        raise ModelError(f"`{spec[:100]}` does not name a model; write {ENDPOINT_FORMS}")
    url = _checked_url(rest[0]) if rest else None
    return ModelName(model.removeprefix("openai/") if url else model, url, **switches)


def _checked_url(url: str) -> str:
    try:
        parts = urlsplit(url)
        sound = bool(parts.hostname) and parts.port != 0
    except ValueError:
        sound, parts = False, urlsplit("")
    if not sound or parts.query or parts.fragment:
        raise ModelError("the address after `@` is not valid; write http://HOST:PORT/v1")
    if parts.username is not None or parts.password is not None:
        raise ModelError("no password in an address: put the key into TEXT2SIM_API_KEY")
    return url.rstrip("/")
