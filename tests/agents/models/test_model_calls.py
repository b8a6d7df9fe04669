"""Finished calls are kept, counted and never paid for twice."""

import json
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from math import inf
from pathlib import Path
from typing import Any

import pytest
from PIL import Image as Picture

from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.models.endpoint import never_stop
from text2sim.agents.models.exchange import MAX_IMAGE, Image, Message, ModelError, ModelRequest, Reply
from text2sim.agents.models.tokens import image_tokens, request_tokens, text_tokens
from text2sim.spec_schema.errors import AssetError


class Echo:
    """Answers with the question, and counts."""

    vision = True

    def __init__(self, name: str = "echo", *, cacheable: bool = True, cost: float | None = 0.5) -> None:
        self.name, self.cacheable, self.cost = name, cacheable, cost
        self.asked = 0

    def complete(self, request: ModelRequest, stop: Callable[[], bool]) -> Reply:
        self.asked += 1
        time.sleep(0.02)
        return Reply(f"re: {request.messages[-1].text}", 10, 5, self.cost, 2.0, self.name)


def png(width: int = 75, height: int = 10) -> bytes:
    stream = BytesIO()
    Picture.new("RGB", (width, height)).save(stream, "PNG")
    return stream.getvalue()


def request(text: str = "hello", number: int = 1, role: str = "planner", **more) -> ModelRequest:
    return ModelRequest(role, (Message("user", text),), number=number, **more)


def test_a_digest_covers_what_the_model_sees_and_nothing_else() -> None:
    plain = request()
    image = Image("a.png", "image/png", png())
    other = Image("a.png", "image/png", png(80))
    seen = [
        plain,
        request("hullo"),
        request(schema={"type": "object"}),
        request(max_tokens=5),
        request(temperature=0.5),
        request(role="critic"),
        ModelRequest("planner", (Message("user", "hello", (image,)),)),
        ModelRequest("planner", (Message("user", "hello", (other,)),)),
    ]
    assert len({r.digest() for r in seen}) == len(seen)
    assert request(number=7).digest() == plain.digest()
    assert request(schema={"a": 1, "b": 2}).digest() == request(schema={"b": 2, "a": 1}).digest()


@pytest.mark.parametrize(
    ("name", "media", "data"),
    [
        ("../a.png", "image/png", png()),
        ("a/b.png", "image/png", png()),
        ("a.svg", "image/svg+xml", b"<svg/>"),
        ("a.png", "image/png", b"GIF89a"),
        ("a.jpg", "image/jpeg", png()),
        ("a.png", "image/png", png() + b"\0" * MAX_IMAGE),
    ],
)
def test_pictures_are_small_png_and_jpeg_with_plain_names(name: str, media: str, data: bytes) -> None:
    with pytest.raises(AssetError):
        Image(name, media, data)


def test_tokens_follow_the_stated_rule() -> None:
    assert text_tokens("hello world") == 2, "cl100k, which comes with litellm"
    assert text_tokens("<|endoftext|>") > 1, "marks of control are text like any other"
    image = Image("a.png", "image/png", png(750, 10))
    assert image_tokens(image) == 10
    assert image_tokens(Image("a.png", "image/png", png(4000, 4000))) == 1600
    assert image_tokens(Image("a.png", "image/png", png()[:20])) == 1600
    assert request_tokens(ModelRequest("r", (Message("user", "hello world", (image,)),))) == 4 + 2 + 10


def test_a_log_on_the_same_folder_asks_nothing_again(tmp_path: Path) -> None:
    model = Echo()
    first = CallLog(tmp_path / "calls").ask(model, request(), attempt=3)
    assert (first.text, first.cached, model.asked) == ("re: hello", False, 1)
    kept = (tmp_path / "calls" / "planner-01.json").read_text("utf-8")
    assert '"attempt": 3' in kept
    assert '"text": "hello"' in kept

    log = CallLog(tmp_path / "calls")  # as after a kill
    again = log.ask(model, request(number=4))
    assert model.asked == 1
    assert again == replace(first, cached=True)
    assert log.ask(model, request()).free, "counted once already"
    assert log.ask(Echo("another"), request()).cached is False, "another model may answer otherwise"
    assert sorted(p.name for p in (tmp_path / "calls").iterdir()) == ["planner-01-2.json", "planner-01.json"]


def test_a_call_that_failed_leaves_nothing_behind(tmp_path: Path) -> None:
    class Broken(Echo):
        def complete(self, request: ModelRequest, stop: Callable[[], bool]) -> Reply:
            raise ModelError("gone", retryable=True)

    log = CallLog(tmp_path)
    with pytest.raises(ModelError, match="gone"):
        log.ask(Broken(), request())
    assert list(tmp_path.iterdir()) == []
    assert log.ask(Echo(), request()).text == "re: hello"


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"key": 1}', "\0\0", "[" * 100_000])
def test_a_damaged_file_is_asked_for_again_and_kept(tmp_path: Path, damage: str) -> None:
    CallLog(tmp_path).ask(Echo(), request())
    (tmp_path / "planner-01.json").write_text(damage)
    model = Echo()
    assert CallLog(tmp_path).ask(model, request()).cached is False
    assert model.asked == 1
    assert (tmp_path / "planner-01.json").read_text() == damage
    assert CallLog(tmp_path).ask(model, request()).cached


@pytest.mark.parametrize("change", [{"text": None}, {"cost": "1"}, {"cost": -1}, {"model": 1}, {"seconds": inf}])
def test_a_reply_with_impossible_values_is_asked_for_again(tmp_path: Path, change: dict[str, Any]) -> None:
    CallLog(tmp_path).ask(Echo(), request())
    file = tmp_path / "planner-01.json"
    data = json.loads(file.read_text())
    file.write_text(json.dumps(data | {"reply": data["reply"] | change}))
    assert CallLog(tmp_path).ask(Echo(), request()).cached is False


def test_two_threads_with_one_question_ask_once(tmp_path: Path) -> None:
    log, model = CallLog(tmp_path), Echo()
    replies: list[Reply] = []
    threads = [threading.Thread(target=lambda: replies.append(log.ask(model, request()))) for _ in range(8)]
    threads += [
        threading.Thread(target=lambda n=n: replies.append(log.ask(model, request(f"q{n}", n)))) for n in range(2, 10)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert model.asked == 9
    assert len(replies) == 16
    assert sum(not reply.cached for reply in replies) == 9
    assert len(list(tmp_path.glob("*.json"))) == 9


def test_a_cache_is_shared_by_cases_but_not_for_mailboxes(tmp_path: Path) -> None:
    model, cache = Echo(), tmp_path / "cache"
    CallLog(tmp_path / "one", cache).ask(model, request())
    reply = CallLog(tmp_path / "two", cache).ask(model, request())
    assert (model.asked, reply.cached, reply.free) == (1, True, True)
    again = CallLog(tmp_path / "two", cache).ask(model, request())
    assert again.free, "it stays another case's"

    person = Echo("mailbox", cacheable=False)
    for case in ("three", "four"):
        CallLog(tmp_path / case, cache).ask(person, request())
    assert person.asked == 2


def test_an_account_tells_now_from_before_and_sums_by_role_and_attempt(tmp_path: Path) -> None:
    CallLog(tmp_path).ask(Echo(), request())
    log, account = CallLog(tmp_path), Account()
    for text, role, attempt in (("hello", "planner", 0), ("hello", "planner", 0), ("look", "critic", 1)):
        account.add(role, attempt, log.ask(Echo(), request(text, role=role), attempt=attempt))
    total = account.total()
    assert (total.calls, total.cached) == (1, 2)
    assert (total.tokens, total.tokens_before) == (30, 15)
    assert (total.cost, total.cost_before, total.seconds) == (1.0, 0.5, 4.0)
    assert account.by_role()["critic"].tokens == 15
    assert [spent.tokens for spent in account.by_attempt().values()] == [15, 15]
    account.add("critic", 2, Reply("", 1_000, 0, None, 1.0, "mailbox", estimated=True))
    table = account.table()
    assert table[1][0] == "critic", "whoever took most comes first"
    assert table[-1] == ("all", "2", "2", "~1,020", "~0", "~10", "$1.0000 + ?", "5 s")
    assert [row[0] for row in table[3:-1]] == ["attempt 0", "attempt 1", "attempt 2"]
    assert account.as_dict()["roles"]["planner"]["tokens_before"] == 15


def test_a_budget_says_which_bound_is_reached() -> None:
    account = Account()
    account.add("planner", 0, Reply("", 90, 10, 0.25, 1.0, "m"))
    assert Budget().exceeded(account) is None
    assert Budget(tokens=101, cost=0.26, minutes=1).exceeded(account) is None
    assert Budget(tokens=100).exceeded(account) == "100 of 100 tokens are spent"
    assert Budget(cost=0.25).exceeded(account) == "$0.25 of $0.25 are spent"
    assert Budget(minutes=2, minutes_before=2.1).exceeded(account) == "2 minutes are over"
    assert Budget(minutes=2, minutes_before=2.1).exceeded(account, overtime=5) is None


def test_stop_is_handed_to_the_endpoint(tmp_path: Path) -> None:
    class Asks(Echo):
        def complete(self, request: ModelRequest, stop: Callable[[], bool]) -> Reply:
            return Reply(str(stop()), 1, 1, None, 0.0, "m")

    log = CallLog(tmp_path)
    assert log.ask(Asks(), request("a"), never_stop).text == "False"
    assert log.ask(Asks(), request("b"), lambda: True).text == "True"
