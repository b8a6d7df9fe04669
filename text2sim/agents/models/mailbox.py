"""Mailbox: a folder in which a person or agent plays a model. Requests and replies are files.

`docs/models.md` describes the protocol.
"""

import os
import re
import stat
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Lock

from text2sim.agents.models.exchange import MEDIA_TYPES, ModelError, ModelRequest, Reply, StoppedError
from text2sim.agents.models.files import UnfitFileError, read_plain, write_durably
from text2sim.agents.models.tokens import request_tokens, text_tokens
from text2sim.spec_schema.plain import plain_line

REPLY_SUFFIXES = ("md", "yaml", "yml", "json", "txt")
"""File extensions of a reply, in order of precedence."""
FINISHED = "finished.md"
"""Name of the file that says how the program ended, and that no request follows."""
MAX_REPLY_SIZE = 10_000_000
"""Largest reply [bytes]."""
POLL_INTERVAL = 0.2
MIN_REPLY_AGE = 2.0
"""Age at which a reply is complete [s]; a newer one is complete if it has not changed since the last look."""
_DIGEST = re.compile(r"^- digest: ([0-9a-f]{64})$", re.MULTILINE)
_HEAD = 2_000


class Mailbox:
    """Endpoint that a person or agent answers, who reads requests in a folder and writes replies beside them."""

    name = "mailbox"
    vision = True
    cacheable = False

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock = Lock()

    def complete(self, request: ModelRequest, stop: Callable[[], bool]) -> Reply:
        """Write the request and wait for its reply until `stop` returns true; see `Endpoint.complete`."""
        start = time.monotonic()
        with self._lock:
            self._post(request)
        text = self._await(request, stop)
        return _reply(request, text, self.name, time.monotonic() - start)

    def close(self, ending: str) -> None:
        """Write the file that says that no request follows; a request that comes nevertheless removes it.

        Args:
            ending: How the program ended, in words; its first line.
        """
        line = plain_line(" ".join(ending.split()))
        text = f"{line}\n\nThe program has ended. No request follows, and no reply is read.\n"
        with self._lock, suppress(OSError, UnfitFileError):  # the outcome does not depend on it
            write_durably(self._folder / FINISHED, text)

    def _post(self, request: ModelRequest) -> None:
        """Write the request, unless an identical one exists, whose reply may exist, too."""
        path = self._folder / f"{request.stem}.request.md"
        try:
            (self._folder / FINISHED).unlink(missing_ok=True)
            head = read_plain(path, MAX_REPLY_SIZE * 2)[:_HEAD] if path.exists() or path.is_symlink() else ""
            found = _DIGEST.search(head)
            if found is not None and found[1] == request.digest():
                return
            self._supersede(request)
            for name, image in zip(_picture_names(request), _pictures(request), strict=True):
                write_durably(self._folder / name, image.data)
            write_durably(path, letter(request))
        except UnfitFileError as error:
            raise ModelError(f"{path}: {error}") from None
        except OSError as error:
            raise ModelError(f"{error.filename or self._folder}: {error.strerror or error}") from None

    def _supersede(self, request: ModelRequest) -> None:
        """Move the files of an earlier request with this number away."""
        endings = [f"reply.{e}" for e in REPLY_SUFFIXES] + ["request.md"]
        old = [self._folder / f"{request.stem}.{ending}" for ending in endings]
        pictures = "|".join(ending for ending, _ in MEDIA_TYPES.values())
        picture = re.compile(rf"{re.escape(request.stem)}\.\d+\.({pictures})")
        if self._folder.is_dir():
            old += [path for path in sorted(self._folder.iterdir()) if picture.fullmatch(path.name)]
        old = [path for path in old if path.exists() or path.is_symlink()]
        if not old:
            return
        count, away = 1, self._folder / "superseded" / f"{request.stem}.1"
        while away.exists():
            count += 1
            away = away.with_name(f"{request.stem}.{count}")
        away.mkdir(parents=True)
        for path in old:
            os.replace(path, away / path.name)

    def _await(self, request: ModelRequest, stop: Callable[[], bool]) -> str:
        seen: tuple[Path, int, int] | None = None
        while True:
            for path in _reply_paths(self._folder, request):
                with suppress(FileNotFoundError):
                    state = path.lstat()
                    if state.st_size == 0 and stat.S_ISREG(state.st_mode):  # created, and about to be written
                        continue
                    now = (path, state.st_size, state.st_mtime_ns)
                    if now == seen or time.time() - state.st_mtime > MIN_REPLY_AGE:
                        return _read(path)
                    seen = now
                    break
            if stop():
                raise StoppedError(f"stopped while waiting for {self._folder / request.stem}.reply.md")
            time.sleep(POLL_INTERVAL)


class MailboxReplay:
    """Endpoint that replays a finished mailbox by role and number, whatever the request."""

    name = "replay"
    vision = True
    cacheable = False

    def __init__(self, folder: Path) -> None:
        if not folder.is_dir():
            raise ModelError(f"{folder}: there is no such folder to replay")
        self._folder = folder

    def complete(self, request: ModelRequest, stop: Callable[[], bool]) -> Reply:
        """Return the stored reply to the call of this role and number; see `Endpoint.complete`.

        Raises:
            StoppedError: If the user stopped it.
            ModelError: If there is no stored reply.
        """
        if stop():
            raise StoppedError("the replay was stopped")
        path = next(iter(_reply_paths(self._folder, request)), None)
        if path is None:
            raise ModelError(f"the replay ends here: there is no {self._folder / request.stem}.reply.md")
        return _reply(request, _read(path), self.name, 0.0)


def letter(request: ModelRequest) -> str:
    """Return the text of a request as shown to the person or agent that answers it."""
    names = iter(_picture_names(request))
    head = [
        f"# {request.role} {request.number:02}",
        "",
        f"- role: {request.role}",
        f"- number: {request.number}",
        f"- digest: {request.digest()}",
        f"- reply: write your answer, and nothing else, into `{request.stem}.reply.md` in this folder, as UTF-8.",
        f"  Write it under another name and rename it when it is complete. At most {request.max_tokens:,} tokens.",
        "- You see nothing but this file and the pictures it names. It is what a language model would be sent.",
    ]
    body: list[str] = []
    for count, message in enumerate(request.messages, 1):
        body += ["", f"## Message {count} of {len(request.messages)}: {message.role}", "", message.text.rstrip("\n")]
        for image in message.images:
            body += ["", f"Picture `{image.name}`: see the file `{next(names)}` in this folder."]
    return "\n".join([*head, *body, ""])


def _pictures(request: ModelRequest) -> list:
    return [image for message in request.messages for image in message.images]


def _picture_names(request: ModelRequest) -> list[str]:
    return [f"{request.stem}.{count}.{image.ending}" for count, image in enumerate(_pictures(request), 1)]


def _reply_paths(folder: Path, request: ModelRequest) -> list[Path]:
    """Candidate reply files; a dangling link counts as existing, so that it is reported."""
    paths = [folder / f"{request.stem}.reply.{ending}" for ending in REPLY_SUFFIXES]
    return [path for path in paths if path.exists() or path.is_symlink()]


def _read(path: Path) -> str:
    try:
        return read_plain(path, MAX_REPLY_SIZE)
    except UnfitFileError as error:
        raise ModelError(f"{path} is not a reply: {error}") from None
    except OSError as error:
        raise ModelError(f"{path} is not a reply: {error.strerror or error}") from None


def _reply(request: ModelRequest, text: str, model: str, seconds: float) -> Reply:
    return Reply(text, request_tokens(request), text_tokens(text), None, seconds, model, estimated=True)
