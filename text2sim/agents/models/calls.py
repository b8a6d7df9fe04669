"""Log of finished model calls, so that none is paid for twice, with their account and budget."""

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from hashlib import sha256
from math import inf
from pathlib import Path
from threading import Lock
from typing import Any

from text2sim.agents.models.endpoint import Endpoint, never_stop
from text2sim.agents.models.exchange import ModelRequest, Reply
from text2sim.agents.models.files import UnfitFileError, read_plain, write_durably

MAX_FILE_SIZE = 64_000_000
"""Largest file of a call [bytes] that is read back."""
REPLY_FIELDS = ("text", "tokens_in", "tokens_out", "cost", "seconds", "model", "estimated", "truncated")


class CallLog:
    """The calls of a case, one file each, written before the reply is used; thread-safe.

    A call whose model and request are in the log is answered from it: a resumed loop asks nothing a second time.

    Args:
        folder: Folder of the files `<role>-<NN>.json`; created when needed.
        cache: Folder shared by several cases. Replies from it were paid for by another case. Endpoints answered by
            people never use it.
    """

    def __init__(self, folder: Path, cache: Path | None = None) -> None:
        self._folder, self._cache = folder, cache
        self._lock = Lock()
        self._busy: dict[str, Lock] = {}
        self._known: dict[str, Reply] = {}
        self._counted: set[str] = set()
        for path in sorted(folder.glob("*.json")):
            found = _read(path)
            if found is not None:
                self._known.setdefault(*found)

    def ask(
        self, endpoint: Endpoint, request: ModelRequest, stop: Callable[[], bool] = never_stop, *, attempt: int = 0
    ) -> Reply:
        """Return the reply to a request; the model is called only if the reply is not stored.

        Args:
            endpoint: The model.
            request: The request.
            stop: Polled; returns whether to give up.
            attempt: Number of the attempt that the call belongs to; stored with it.

        Returns:
            The reply, `cached` if the model was not called, and `free` if it costs nothing or was counted before.

        Raises:
            ModelError: If the model gives no reply.
        """
        key = sha256(f"{endpoint.name}\n{request.digest()}".encode()).hexdigest()
        with self._lock:
            busy = self._busy.setdefault(key, Lock())
        with busy:  # of two identical concurrent calls, one waits for the other's reply
            if key in self._known:
                with self._lock:
                    free = self._known[key].free or key in self._counted
                    self._counted.add(key)
                return replace(self._known[key], cached=True, free=free)
            shared = self._cache / f"{key}.json" if self._cache is not None and endpoint.cacheable else None
            found = _read(shared) if shared is not None else None
            if found is not None and found[0] == key:
                reply = replace(found[1], cached=True, free=True)
            else:
                reply = endpoint.complete(request, stop)
            record = self._record(key, request, reply, attempt)
            self._write(request, record)
            if shared is not None and not reply.free:
                write_durably(shared, record)
            with self._lock:
                self._known[key] = reply
                self._counted.add(key)
            return reply

    def _record(self, key: str, request: ModelRequest, reply: Reply, attempt: int) -> str:
        data: dict[str, Any] = {"key": key, "digest": request.digest(), "number": request.number, "attempt": attempt}
        record = {"request": request.as_dict(), "reply": {name: getattr(reply, name) for name in REPLY_FIELDS}}
        return json.dumps(data | {"free": reply.free} | record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"

    def _write(self, request: ModelRequest, record: str) -> None:
        with self._lock:
            path, count = self._folder / f"{request.stem}.json", 1
            while path.exists():  # used by another question, before the loop took a different path
                count += 1
                path = self._folder / f"{request.stem}-{count}.json"
            write_durably(path, record)


def _read(path: Path) -> tuple[str, Reply] | None:
    """Return key and reply in a file; None if the file is invalid, so that the call is repeated."""
    try:
        data = json.loads(read_plain(path, MAX_FILE_SIZE))
        kept = {name: data["reply"][name] for name in REPLY_FIELDS}
        reply = Reply(**kept, cached=True, free=data["free"])
        cost = 0.0 if reply.cost is None else reply.cost
        sound = all(0 <= value < inf for value in (reply.tokens_in, reply.tokens_out, reply.seconds, cost))
        sound &= all(isinstance(text, str) for text in (data["key"], reply.text, reply.model))
    except (OSError, UnfitFileError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return (data["key"], reply) if sound else None


@dataclass(frozen=True)
class Spent:
    """Tokens, cost and time of some calls."""

    calls: int = 0
    """Calls made by this process."""
    cached: int = 0
    """Calls answered from stored replies."""
    tokens_in: int = 0
    tokens_out: int = 0
    again: int = 0
    """Part of `tokens_in` that a prompt cache can serve, because an earlier request began in the same way."""
    cost: float = 0.0
    """Known cost [US$]."""
    unpriced: int = 0
    """Paid calls of unknown price."""
    estimated: int = 0
    """Paid calls whose tokens are estimated."""
    seconds: float = 0.0
    """Time that models took to answer [s]."""
    tokens_before: int = 0
    """Tokens spent before this process started."""
    cost_before: float = 0.0
    """Cost before this process started [US$]."""

    @property
    def tokens(self) -> int:
        """Tokens in and out."""
        return self.tokens_in + self.tokens_out

    def __add__(self, other: "Spent") -> "Spent":
        return Spent(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(Spent)))


class Account:
    """Tokens and cost of calls, by role and attempt; thread-safe."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._spent: dict[tuple[str, int], Spent] = {}

    def add(self, role: str, attempt: int, reply: Reply, again: int = 0) -> None:
        """Add a reply. A cached one counts as spent before this process; a free one costs nothing.

        Args:
            role: Name of the role.
            attempt: Number of the attempt.
            reply: The reply.
            again: Tokens of the request that a prompt cache can serve.
        """
        spent = Spent(calls=int(not reply.cached), cached=int(reply.cached))
        if not reply.free:
            cost = reply.cost or 0.0
            spent += Spent(
                tokens_in=reply.tokens_in,
                tokens_out=reply.tokens_out,
                again=min(again, reply.tokens_in),
                cost=cost,
                unpriced=int(reply.cost is None),
                estimated=int(reply.estimated),
                seconds=reply.seconds,
                tokens_before=reply.tokens_in + reply.tokens_out if reply.cached else 0,
                cost_before=cost if reply.cached else 0.0,
            )
        with self._lock:
            self._spent[role, attempt] = self._spent.get((role, attempt), Spent()) + spent

    def total(self) -> Spent:
        """Return the totals of all calls."""
        with self._lock:
            return sum(self._spent.values(), Spent())

    def by_role(self) -> dict[str, Spent]:
        """Return the totals by role."""
        return self._sum_by(0)

    def by_attempt(self) -> dict[int, Spent]:
        """Return the totals by attempt, in order."""
        return dict(sorted(self._sum_by(1).items()))

    def table(self) -> list[tuple[str, ...]]:
        """Return the rows of a printed table: a header, the roles by tokens used, the attempts, the total."""
        head = ("", "calls", "cached", "tokens in", "of them again", "tokens out", "cost", "time")
        roles = sorted(self.by_role().items(), key=lambda row: -row[1].tokens)
        attempts = [(f"attempt {number}", spent) for number, spent in self.by_attempt().items()]
        return [head, *(_row(name, spent) for name, spent in [*roles, *attempts, ("all", self.total())])]

    def as_dict(self) -> dict[str, Any]:
        """Return the account as plain data, for `run.json`."""
        rows: dict[str, dict[Any, Spent]] = {"roles": self.by_role(), "attempts": self.by_attempt()}
        by = {name: {str(key): asdict(spent) for key, spent in row.items()} for name, row in rows.items()}
        return {"total": asdict(self.total()), **by}

    def _sum_by(self, part: int) -> dict[Any, Spent]:
        sums: dict[Any, Spent] = {}
        with self._lock:
            for key, spent in self._spent.items():
                sums[key[part]] = sums.get(key[part], Spent()) + spent
        return sums


def _row(name: str, spent: Spent) -> tuple[str, ...]:
    about = "~" if spent.estimated else ""
    paid = f"${spent.cost:.4f}" if spent.cost else ""
    if spent.unpriced:
        paid = f"{paid} + ?" if paid else "?"
    tokens = (f"{about}{spent.tokens_in:,}", f"~{spent.again:,}", f"{about}{spent.tokens_out:,}")
    return (name, str(spent.calls), str(spent.cached), *tokens, paid, f"{spent.seconds:,.0f} s")


class Budget:
    """Limits of a loop, including what it used before an interruption.

    Args:
        tokens: Input and output tokens together; None for no limit.
        cost: Cost [US$]. Calls of unknown price count as zero, so limit the tokens as well.
        minutes: Wall time from now on [min].
        minutes_before: Wall time used before an interruption [min].
    """

    def __init__(
        self,
        tokens: int | None = None,
        cost: float | None = None,
        minutes: float | None = None,
        *,
        minutes_before: float = 0.0,
    ) -> None:
        self._tokens, self._cost, self._minutes = tokens, cost, minutes
        self._start = time.monotonic() - 60 * minutes_before

    @property
    def minutes_used(self) -> float:
        """Minutes used so far, including those before an interruption."""
        return (time.monotonic() - self._start) / 60

    def minutes_left(self) -> float | None:
        """Return the minutes left; None without a limit."""
        return None if self._minutes is None else max(0.0, self._minutes - self.minutes_used)

    def exceeded(self, account: Account, overtime: float = 0.0) -> str | None:
        """Describe the limit that is reached; None if none is. The time may be exceeded by `overtime` minutes."""
        spent = account.total()
        if self._tokens is not None and spent.tokens >= self._tokens:
            return f"{spent.tokens:,} of {self._tokens:,} tokens are spent"
        if self._cost is not None and spent.cost >= self._cost:
            return f"${spent.cost:.2f} of ${self._cost:.2f} are spent"
        return self.over(overtime)

    def over(self, overtime: float = 0.0) -> str | None:
        """Describe the limit of time if it is exceeded by `overtime` minutes; None if it is not."""
        if self._minutes is not None and self.minutes_used >= self._minutes + overtime:
            return f"{self._minutes:g} minutes are over"
        return None
