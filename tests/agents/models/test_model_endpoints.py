"""A real client against a real server that speaks the protocol."""

import subprocess
import sys
import threading
import time
from io import BytesIO
from pathlib import Path
from typing import get_args

import pytest
from chat_server import Answer, ChatServer, completion, refusal
from PIL import Image as Picture

from text2sim.agents.models.endpoint import (
    ANSWERED_IN_FOLDERS,
    ENDPOINT_FORMS,
    endpoint_of,
    in_subfolder,
    never_stop,
    parse_name,
)
from text2sim.agents.models.exchange import Image, Message, ModelError, ModelRequest, Reply, StoppedError
from text2sim.cli.generate import Model

pytest.importorskip("litellm")

from text2sim.agents.models.litellm_client import OWN_KEY, LiteLLMEndpoint  # noqa: E402

KEY = "sk-not-a-real-key-0123456789"


@pytest.fixture(autouse=True)
def keys(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.delenv(OWN_KEY, raising=False)
    monkeypatch.delenv("ANTHROPIC_API_KEY", raising=False)
    for name in ("OPENAI_BASE_URL", "OPENAI_API_BASE"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def picture() -> Image:
    stream = BytesIO()
    Picture.new("RGB", (8, 8)).save(stream, "PNG")
    return Image("frame_1.png", "image/png", stream.getvalue())


def ask(
    server: ChatServer, request: ModelRequest | None = None, *, options: str = "", stop=never_stop, **limits
) -> Reply:
    name = parse_name(f"openai/org/small@{server.url}{options}")
    endpoint = LiteLLMEndpoint(name, **({"first_wait": 0.02, "tries": 3, "timeout": 20.0} | limits))
    return endpoint.complete(request or ModelRequest("planner", (Message("user", "hello"),)), stop)


def fail(*answers: Answer, **more) -> tuple[ModelError, ChatServer]:
    with ChatServer(*answers) as server, pytest.raises(ModelError) as caught:
        ask(server, **more)
    return caught.value, server


def test_a_reply_comes_with_its_usage() -> None:
    with ChatServer(completion("fine", tokens=(120, 34))) as server:
        reply = ask(server, ModelRequest("planner", (Message("system", "s"), Message("user", "u")), max_tokens=77))
    assert (reply.text, reply.tokens_in, reply.tokens_out) == ("fine", 120, 34)
    assert (reply.cost, reply.estimated, reply.truncated) == (None, False, False)
    assert reply.model == f"org/small@{server.url}"
    sent = server.requests[0]
    assert server.paths == ["/v1/chat/completions"]
    assert sent["model"] == "org/small"
    assert sent["messages"] == [{"role": "system", "content": "s"}, {"role": "user", "content": "u"}]
    assert sent["max_tokens"] == 77
    assert "temperature" not in sent


def test_a_provider_is_reached_with_its_key_and_priced(monkeypatch: pytest.MonkeyPatch) -> None:
    with ChatServer(completion("fine", tokens=(1000, 100))) as server:
        monkeypatch.setenv("OPENAI_BASE_URL", server.url)
        endpoint = endpoint_of("openai/gpt-4o-mini")
        reply = endpoint.complete(ModelRequest("planner", (Message("user", "u"),), temperature=0.5), never_stop)
    assert endpoint.vision
    assert server.keys == [f"Bearer {KEY}"]
    assert server.requests[0]["temperature"] == 0.5
    assert reply.cost is not None
    assert 0 < reply.cost < 0.01


def test_a_providers_key_never_goes_to_another_address(monkeypatch: pytest.MonkeyPatch) -> None:
    with ChatServer(completion("fine")) as server:
        ask(server)
        monkeypatch.setenv(OWN_KEY, "own-key-of-the-server")
        ask(server)
    assert server.keys == ["Bearer none", "Bearer own-key-of-the-server"]


def test_missing_usage_is_counted_by_us_and_a_cut_reply_says_so() -> None:
    with ChatServer(completion("some words", tokens=None, reason="length")) as server:
        reply = ask(server)
    assert reply.estimated
    assert reply.truncated
    assert reply.tokens_in > 0
    assert reply.tokens_out == 2


def test_429_waits_as_long_as_it_is_asked_to() -> None:
    with ChatServer(refusal(429, "slow down", Retry_After="0.6"), completion("fine")) as server:
        reply = ask(server)
    assert (reply.text, len(server.requests)) == ("fine", 2)
    assert reply.seconds > 0.55


def test_a_time_to_wait_that_is_none_is_ignored() -> None:
    never = "Thu, 01 Jan 2026 00:00:00 +99999999999999999999"
    with ChatServer(refusal(429, "slow down", Retry_After=never), completion("fine")) as server:
        assert ask(server).text == "fine"


def test_a_pause_that_is_too_long_is_not_waited_for() -> None:
    error, server = fail(refusal(429, "slow down", Retry_After="9999"))
    assert error.retryable
    assert "asks to wait 9999 s" in str(error)
    assert len(server.requests) == 1


@pytest.mark.parametrize(
    "answer", [refusal(500, "boom"), refusal(503, "busy"), (200, {}, b"<html>"), (200, {}, b'{"choices": []}')]
)
def test_what_may_pass_is_tried_a_few_times(answer: Answer) -> None:
    error, server = fail(answer)
    assert error.retryable
    assert "(after 3 tries)" in str(error)
    assert len(server.requests) == 3


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (refusal(401, f"Incorrect API key provided: {KEY}"), "does not accept the key"),
        (refusal(401, "Incorrect API key provided: sk-not-a***6789, Bearer abc"), "[key]"),
        (refusal(404, "no such model"), "no such model"),
        (refusal(400, "context is too long"), "context is too long"),
        (refusal(429, "You exceeded your current quota"), "quota"),
    ],
)
def test_what_will_not_pass_is_asked_once_and_shows_no_key(answer: Answer, words: str) -> None:
    error, server = fail(answer)
    assert not error.retryable
    assert words in str(error)
    assert "sk-" not in str(error)
    assert "abc" not in str(error)
    assert len(server.requests) == 1


def test_nobody_listens() -> None:
    with ChatServer(completion("x")) as server:
        pass
    with pytest.raises(ModelError, match="after 3 tries") as caught:
        ask(server)
    assert caught.value.retryable


def slow() -> Answer:
    time.sleep(1.5)
    return completion("late")


def test_a_try_has_an_end() -> None:
    start = time.monotonic()
    error, _ = fail(slow, timeout=0.3, tries=2)  # type: ignore[arg-type]
    assert error.retryable
    assert time.monotonic() - start < 3


def test_stop_ends_a_call_and_a_pause() -> None:
    stop = threading.Event()
    threading.Timer(0.3, stop.set).start()
    with ChatServer(slow) as server, pytest.raises(StoppedError):
        ask(server, stop=stop.is_set)
    with ChatServer(refusal(500, "boom")) as server, pytest.raises(StoppedError):
        ask(server, stop=lambda: bool(server.requests), first_wait=60.0)


def test_pictures_go_along_where_they_are_seen(picture: Image) -> None:
    request = ModelRequest("critic", (Message("user", "look", (picture,)),))
    with ChatServer(completion("fine")) as server:
        ask(server, request)
        ask(server, request, options=",vision=yes")
    blind, seeing = (sent["messages"][0]["content"] for sent in server.requests)
    assert blind == "look\n\n[Pictures are left out, since you see none: `frame_1.png`]"
    assert [part["type"] for part in seeing] == ["text", "text", "image_url"]
    assert seeing[1]["text"] == "Picture `frame_1.png`:"
    assert seeing[2]["image_url"]["url"].startswith("data:image/png;base64,iVBOR")


def test_a_schema_goes_along_where_it_is_kept_to() -> None:
    schema = {"type": "object", "properties": {"a": {"type": "number"}}}
    request = ModelRequest("planner", (Message("user", "u"),), schema=schema)
    with ChatServer(completion("{}")) as server:
        ask(server, request)
        ask(server, request, options=",schema=yes")
    assert "response_format" not in server.requests[0]
    assert server.requests[1]["response_format"]["json_schema"]["schema"] == schema


def test_a_schema_that_is_refused_is_left_out() -> None:
    request = ModelRequest("planner", (Message("user", "u"),), schema={"type": "object"})
    with ChatServer(refusal(400, "response_format is not supported"), completion("{}")) as server:
        assert ask(server, request, options=",schema=yes").text == "{}"
    assert ["response_format" in sent for sent in server.requests] == [True, False]


def test_calls_from_several_threads_do_not_mix() -> None:
    replies: list[str] = []
    with ChatServer(completion("fine")) as server:
        threads = [threading.Thread(target=lambda: replies.append(ask(server).text)) for _ in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert replies == ["fine"] * 6


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("", "does not name a model"),
        ("gpt-4o", "does not name a model"),
        ("openai/a b", "does not name a model"),
        ("openai/m@http://user:secret@host/v1", "no password in an address"),
        ("openai/m@http://", "address"),
        ("openai/m@http://host:port/v1", "address"),
        ("openai/m@http://host:0/v1", "address"),
        ("openai/m,vision=maybe", "not an option"),
        ("mailbox:", "needs a folder"),
        ("replay:/no/such/folder", "no such folder"),
        ("nobody/model", "no provider `nobody`"),
        ("anthropic/claude-sonnet-4-5", "set ANTHROPIC_API_KEY"),
    ],
)
def test_a_name_that_is_none_is_told(spec: str, words: str) -> None:
    with pytest.raises(ModelError, match=words) as caught:
        endpoint_of(spec)
    assert "secret" not in str(caught.value)


def test_an_at_sign_in_the_name_of_a_model_is_no_address() -> None:
    assert parse_name("vertex_ai/claude@20250101").url is None
    assert parse_name("openai/a@http://h:1/v1/").url == "http://h:1/v1"


def test_the_package_does_not_import_litellm() -> None:
    modules = ("calls", "endpoint", "exchange", "mailbox", "parsing", "provider_errors", "litellm_client", "tokens")
    imports = "; ".join(f"import text2sim.agents.models.{module}" for module in modules)
    heavy = "sorted({'litellm', 'openai', 'tiktoken', 'httpx'} & set(sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; {imports}; print({heavy})"],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert done.stdout.strip() == "[]"


def test_only_what_is_answered_in_a_folder_gets_one_of_its_own() -> None:
    assert in_subfolder("mailbox:box/", "a/b") == "mailbox:box/a/b"
    assert in_subfolder("replay:box", "a") == "replay:box/a"
    for name in ("mailbox", "openai/m@http://h:1/v1"):
        assert in_subfolder(name, "a") == name


@pytest.mark.parametrize("kind", ANSWERED_IN_FOLDERS)
def test_every_kind_is_told_of(kind: str) -> None:
    page = Path(__file__).parents[3] / "docs/models.md"
    for text in (ENDPOINT_FORMS, page.read_text("utf-8"), get_args(Model)[1].help):
        assert f"{kind}:" in text
