"""The server of the page: only browsers on this machine with its address have access."""

import http.client
import json
import re
import socket
import threading

import pytest

from text2sim.replay.page import live_page, scripts
from text2sim.watching.page_state import PageState
from text2sim.watching.server import MAX_LISTENERS, PageServer

SCENE = b'{"contents": {}, "blob": ""}'


@pytest.fixture
def state():
    state = PageState(case="drop", file="case.yaml", words="ready", tone="good")
    state.show_scene("1-1", "1", SCENE, whole=False)
    return state


@pytest.fixture
def server(state):
    server = PageServer(state)
    yield server
    server.close()


def ask(server, path="", *, method="GET", secret=True, **headers):
    """Ask for something; return status, headers and body."""
    port = int(server.url.split(":")[2].split("/")[0])
    token = server.url.rstrip("/").rpartition("/")[2]
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    target = f"/{token}/{path}" if secret else path
    connection.request(method, target, headers={name.replace("_", "-"): value for name, value in headers.items()})
    answer = connection.getresponse()
    return answer.status, answer.headers, answer.read()


def test_the_page(server):
    status, headers, body = ask(server)
    assert status == 200
    assert headers["Content-Type"] == "text/html; charset=utf-8"
    assert b"text2sim watch" in body
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    nonce = re.search(r"script-src 'nonce-([^']+)'", policy)
    assert nonce
    assert body.count(f'nonce="{nonce[1]}"'.encode()) == 3


def test_the_page_needs_nothing_from_elsewhere():
    library, script = scripts()
    page = live_page("x").replace(library, "")
    assert not re.search(r"(?i)https?://|//[\w-]+\.\w|@import|url\(", page)
    assert "innerHTML" not in script, "what comes from files goes in as text"


def test_it_listens_on_this_machine_only(server):
    assert server.url.startswith("http://127.0.0.1:")
    port = int(server.url.split(":")[2].split("/")[0])
    with pytest.raises(OSError), socket.create_connection(("127.0.0.2", port), timeout=1):
        pass


@pytest.mark.parametrize("path", ["/", "/state", "/scene/1-1", "//state", "/wrong/state", "/wrong/", "*"])
def test_nothing_without_the_secret(server, path):
    assert ask(server, path, secret=False)[0] == 404


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1"},
        {"Host": "127.0.0.1:1"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "iframe"},
    ],
    ids=str,
)
def test_nothing_for_other_sites(server, headers):
    """Also not for one whose name was made to mean this machine."""
    assert ask(server, "state", **headers)[0] == 404


def test_a_link_from_elsewhere_can_be_followed(server):
    link = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "document"}
    assert ask(server, **link)[0] == 200
    assert ask(server, Origin="http://evil.example", **link)[0] == 404, "but no form"


@pytest.mark.parametrize(
    "path",
    ["scene/../case.yaml", "scene/2-1", "scene/..%2f..%2fcase.yaml", "scene//etc/passwd", "etc/passwd", "page.html"],
)
def test_nothing_but_page_board_and_scenes(server, path):
    assert ask(server, path)[0] == 404


def test_nothing_can_be_sent_to_it(server):
    assert ask(server, "state", method="POST")[0] == 501
    assert ask(server, "state", method="PUT")[0] == 501


def test_a_scene(server):
    status, headers, body = ask(server, "scene/1-1")
    assert (status, body, headers["Content-Type"]) == (200, SCENE, "application/json")
    status, headers, body = ask(server, "scene/1-1", method="HEAD")
    assert (status, body, headers["Content-Length"]) == (200, b"", str(len(SCENE)))


def test_the_scene_before_can_still_be_read_but_no_older_one(server, state):
    state.show_scene("1-2", "1", b"two", whole=False)
    assert ask(server, "scene/1-1")[2] == SCENE
    state.show_scene("1-3", "1", b"three", whole=True)
    assert ask(server, "scene/1-1")[0] == 404
    assert ask(server, "scene/1-2")[2] == b"two"
    assert json.loads(ask(server, "state")[2])["scene"] == {"name": "1-3", "take": "1", "whole": True}


class Listener:
    """A page that follows the state."""

    def __init__(self, server):
        port = int(server.url.split(":")[2].split("/")[0])
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
        self.connection.request("GET", f"/{server.url.rstrip('/').rpartition('/')[2]}/events")
        self.answer = self.connection.getresponse()

    def news(self):
        while True:
            line = self.answer.readline()
            if line.startswith(b"data: "):
                return json.loads(line[6:])
            if not line:
                return None


def test_a_page_receives_every_change(server, state):
    listener = Listener(server)
    assert listener.answer.headers["Content-Type"] == "text/event-stream"
    assert listener.news()["words"] == "ready"
    state.show(words="simulating", progress=0.5)
    assert listener.news()["progress"] == 0.5
    state.show(words="simulating")
    state.show(words="done")
    assert listener.news()["words"] == "done", "what is no change is no news"


def test_pages_are_let_go_at_the_end(state):
    server = PageServer(state)
    listener = Listener(server)
    listener.news()
    threading.Timer(0.1, server.close).start()
    assert listener.news() is None


def test_there_are_not_more_pages_than_it_can_follow(server):
    listeners = [Listener(server) for _ in range(MAX_LISTENERS + 1)]
    assert [listener.answer.status for listener in listeners] == [200] * MAX_LISTENERS + [503]


def test_a_port_that_is_taken(server, state):
    port = int(server.url.split(":")[2].split("/")[0])
    with pytest.raises(OSError):
        PageServer(state, port)
