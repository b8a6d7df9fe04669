"""Conversation with models: call a model, parse its answer into a type, and return faults to it a few times."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from threading import Lock
from time import monotonic
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from text2sim.agents.journal import Emit
from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.models.endpoint import Endpoint
from text2sim.agents.models.exchange import Image, Message, ModelRequest, StoppedError
from text2sim.agents.models.fences import with_last_fence
from text2sim.agents.models.mailbox import Mailbox
from text2sim.agents.models.parsing import ReplyError, read_reply
from text2sim.agents.models.tokens import PromptPrefixes
from text2sim.runtime.progress import duration_text
from text2sim.spec_schema.errors import RunError, nearest

T = TypeVar("T")

MAX_ANSWERS = 3
"""Largest number of answers to one question."""
MAX_PAGE_REQUESTS = 2
"""Largest number of requests for pages before an answer."""
MAX_REQUESTED_PAGES = 20
"""Largest number of pages in one request."""
MAX_QUOTED_ANSWER = 40_000
"""Characters of a refused answer that are sent back with its faults: a mechanism takes 27,000."""
MAX_LISTED_FAULTS = 12
"""Largest number of faults that are sent back."""
CHANGES_KEY = "changes"
"""Key of an answer that contains only the differences from the refused one."""
MIN_LENGTH_FOR_CHANGES = 2_000
"""Length from which a refused answer may be corrected by its differences [characters]."""
IN_FULL = "Answer again, in full, in one fenced ```yaml block."
ANSWER_WITH_CHANGES = (
    "Answer in one fenced ```yaml block with the one key `changes`, and under it only the keys that change, each at "
    "its place: mappings are merged, any other value, lists too, takes the place of the old one (so does an "
    "expectation that names its `measure` or `event`), and null removes a key. (Or answer again, in full.)"
)


class Wrong(Exception):
    """An answer that cannot be used.

    Attributes:
        reasons: Its faults, worded for the model that wrote it.
    """

    def __init__(self, reasons: Sequence[str]) -> None:
        self.reasons = list(reasons)
        super().__init__("; ".join(self.reasons))


class RoleFailed(RunError):
    """Error: a role gave no usable answer."""

    def __init__(self, role: str, reasons: Sequence[str]) -> None:
        self.role, self.reasons = role, list(reasons)
        super().__init__(f"the {role} gave no usable answer in {MAX_ANSWERS} tries: {'; '.join(self.reasons[:3])}")


class BudgetSpent(RunError):
    """Error: the budget is used up."""


class Conversation:
    """Questions to models: the endpoint of each role, the log of earlier calls, and their cost.

    Args:
        endpoints: Endpoint by role; the entry "" serves all other roles.
        log: Finished calls, which are never made twice.
        account: Tokens and cost of the calls.
        budget: Limits of tokens, cost and time.
        emit: Callback for journal events.
        stop: Polled; returns whether to give up.
    """

    def __init__(
        self,
        endpoints: Mapping[str, Endpoint],
        log: CallLog,
        account: Account,
        budget: Budget,
        emit: Emit,
        stop: Callable[[], bool] = lambda: False,
    ) -> None:
        self._endpoints, self._log, self.account, self._budget = endpoints, log, account, budget
        self._emit, self._stop = emit, stop
        self._numbers: Counter[str] = Counter()
        self._lock, self._prefixes = Lock(), PromptPrefixes()
        self.attempt = 0
        """Number of the attempt that calls are charged to."""
        self._overtime = 0.0

    @contextmanager
    def overtime(self, minutes: float) -> Iterator[None]:
        """Allow questions for so many minutes beyond the limit of time."""
        self._overtime = minutes
        try:
            yield
        finally:
            self._overtime = 0.0

    def vision(self, role: str) -> bool:
        """Whether the endpoint of a role accepts images."""
        return self._endpoint(role).vision

    def ask(
        self,
        role: str,
        system: str,
        question: str,
        read: Callable[[Any], T],
        images: Sequence[Image] = (),
        rounds: int = MAX_ANSWERS,
        read_pages: Callable[[list[str]], str] | None = None,
        number: int | None = None,
    ) -> T:
        """Ask a role a question, and return its parsed answer.

        Args:
            role: Name of the role.
            system: System prompt.
            question: User prompt.
            read: Parses the data of an answer; raises `Wrong` with the faults that the model has to fix.
            images: Images that accompany the question.
            rounds: Largest number of answers.
            read_pages: Returns pages by name. With it, the role may first answer `read: [name, …]`; the pages follow in
                the next message.
            number: Reserved number of the question; the next free one if None.

        Raises:
            RoleFailed: If no answer is usable.
            BudgetSpent: If the budget is used up.
            ModelError: If the model cannot be reached.
        """
        messages = [Message("system", system), Message("user", question, tuple(images))]
        reasons: list[str] = []
        before: Any = None
        looks = round_ = 0
        while round_ < rounds:
            reply, number = self.reply(role, messages, number), None
            try:
                data = read_reply(reply)[0]
                if read_pages is not None and (names := _requested_pages(data)):
                    looks += 1
                    if looks > MAX_PAGE_REQUESTS:
                        raise Wrong([f"/read: pages are served {MAX_PAGE_REQUESTS} times, and have been; answer now"])
                    pages = read_pages(names) + ANSWER_NOW + (LAST_PAGES if looks == MAX_PAGE_REQUESTS else "")
                    messages += [Message("assistant", _echo(reply)), Message("user", pages)]
                    continue
                if isinstance(before, dict) and isinstance(data, dict) and set(data) == {CHANGES_KEY}:
                    data = _corrected(before, data[CHANGES_KEY])
                before = data
                return read(data)
            except ReplyError as error:
                reasons, before = [str(error)], None
            except Wrong as error:
                reasons = error.reasons
            round_ += 1
            self._emit("answer_refused", role=role, round=round_, reasons=reasons[:MAX_LISTED_FAULTS])
            remedy = (
                ANSWER_WITH_CHANGES if isinstance(before, dict) and len(reply) > MIN_LENGTH_FOR_CHANGES else IN_FULL
            )
            messages += [Message("assistant", _echo(reply)), Message("user", _complaint(reasons, remedy))]
        raise RoleFailed(role, reasons)

    def close(self, ending: str) -> None:
        """Tell those who watch a mailbox that no question follows, and how the program ended."""
        for endpoint in self._endpoints.values():
            if isinstance(endpoint, Mailbox):
                endpoint.close(ending)

    def reserve(self, role: str) -> int:
        """Return the next number of a role's calls, so that concurrent ones are numbered in order."""
        with self._lock:
            self._numbers[role] += 1
            return self._numbers[role]

    def reply(self, role: str, messages: Sequence[Message], number: int | None = None) -> str:
        """Return a role's raw reply to messages.

        Args:
            role: Name of the role.
            messages: The messages.
            number: Reserved number of the call; the next free one if None.

        Raises:
            BudgetSpent: If the budget is used up, or its time is over before the reply comes.
            ModelError: If the model cannot be reached.
        """
        if (spent := self._budget.exceeded(self.account, self._overtime)) is not None:
            raise BudgetSpent(spent)
        number = number or self.reserve(role)
        self._emit("asked", live=True, role=role, number=number)
        request = ModelRequest(role=role, messages=tuple(messages), number=number)
        begun = monotonic()
        try:
            reply = self._log.ask(self._endpoint(role), request, self._gives_up, attempt=self.attempt)
        except StoppedError:
            if not self._stop() and (over := self._budget.over(self._overtime)) is not None:
                waited = duration_text(monotonic() - begun)
                raise BudgetSpent(f"{over}, and no reply to {request.stem} came within {waited}") from None
            raise
        with self._lock:
            again = self._prefixes.cached_tokens(self._endpoint(role).name, request)
        self.account.add(role, self.attempt, reply, again)
        tokens = reply.tokens_in + reply.tokens_out
        self._emit("answered", live=True, role=role, number=number, tokens=tokens, seconds=reply.seconds)
        return reply.text if reply.truncated else with_last_fence(reply.text)

    def _gives_up(self) -> bool:
        return self._stop() or self._budget.over(self._overtime) is not None

    def _endpoint(self, role: str) -> Endpoint:
        return self._endpoints.get(role) or self._endpoints[""]


def typed_parser(model: type[BaseModel], check: Callable[[Any], None] | None = None) -> Callable[[Any], Any]:
    """Return a parser of answers of one type, for `Conversation.ask`.

    Args:
        model: The type of the answer.
        check: Further check of a parsed answer; raises `Wrong`.
    """

    def read(data: Any) -> Any:
        try:
            answer = model.model_validate(data)
        except ValidationError as error:
            raise Wrong(_describe_errors(error, model)) from None
        if check is not None:
            check(answer)
        return answer

    return read


LAST_PAGES = " No more pages are served."
ANSWER_NOW = "\n\nNow answer the question above."


def _requested_pages(data: Any) -> list[str]:
    """Names of the pages that an answer asks for; empty for any other answer."""
    names = data.get("read") if isinstance(data, dict) and len(data) == 1 else None
    if isinstance(names, str):
        names = [names]
    return [str(name)[:80] for name in names[:MAX_REQUESTED_PAGES]] if isinstance(names, list) else []


def _echo(reply: str) -> str:
    """A rejected answer as it is sent back; shortened, so that a huge one is not paid for three times."""
    return (
        reply
        if len(reply) <= MAX_QUOTED_ANSWER
        else f"{reply[: MAX_QUOTED_ANSWER // 2]}\n[…]\n{reply[-MAX_QUOTED_ANSWER // 2 :]}"
    )


def _describe_errors(error: ValidationError, model: type[BaseModel]) -> list[str]:
    rows = []
    for problem in error.errors(include_url=False, include_input=False)[:MAX_LISTED_FAULTS]:
        where, message = "/" + "/".join(map(str, problem["loc"])), problem["msg"]
        if problem["type"] == "extra_forbidden":
            message = _unknown_field(str(problem["loc"][-1]), model, problem["loc"][:-1])
        rows.append(f"{where}: {message}")
    return rows


def _unknown_field(name: str, model: type[BaseModel], path: Sequence[Any]) -> str:
    """Message about an unknown field, with the known fields and the nearest one."""
    for step in path:
        inner = model.model_fields.get(str(step))
        found = _models_in(inner.annotation) if inner is not None else []
        model = found[0] if found else model
    fields = list(model.model_fields)
    hint = nearest(name, fields)
    return f"the form has no such field{f'; did you mean `{hint}`?' if hint else ''}; it has {', '.join(fields)}"


def _models_in(kind: Any) -> list[type[BaseModel]]:
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return [kind]
    return [model for part in get_args(kind) for model in _models_in(part)]


def _corrected(before: dict[str, Any], changes: Any) -> Any:
    """Return a refused answer with changes, which may leave out the one key of a section."""
    if len(before) == 1 and isinstance(changes, dict):
        key, section = next(iter(before.items()))
        if isinstance(section, dict) and key not in changes:
            changes = {key: changes}
    return apply_merge_patch(before, changes)


def apply_merge_patch(data: Any, changes: Any) -> Any:
    """Return data with a JSON Merge Patch applied (RFC 7396): null removes a key.

    Unlike there, an expectation that says what it is about takes the place of the old one: left in, its old `on` or
    `during` would change the meaning of the new one without a fault to show for it.
    """
    if not isinstance(changes, dict):
        return changes
    made = dict(data) if isinstance(data, dict) else {}
    for key, value in changes.items():
        if value is None:
            made.pop(key, None)
            continue
        old = made.get(key)
        if key == "expect" and isinstance(old, dict) and isinstance(value, dict):
            old = {name: row for name, row in old.items() if not _is_whole_expectation(value.get(name))}
        made[key] = apply_merge_patch(old, value)
    return made


def _is_whole_expectation(row: Any) -> bool:
    return isinstance(row, dict) and bool({"measure", "event"} & set(row))


def _complaint(reasons: Sequence[str], remedy: str) -> str:
    rows = "\n".join(f"- {' '.join(reason.split())[:600]}" for reason in reasons[:MAX_LISTED_FAULTS])
    more = f"\n- … and {len(reasons) - MAX_LISTED_FAULTS} more" if len(reasons) > MAX_LISTED_FAULTS else ""
    return f"This cannot be used:\n\n{rows}{more}\n\n{remedy}\n"
