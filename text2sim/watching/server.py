"""Server of the page of a watched case, only for browsers on this machine.

It listens on 127.0.0.1. Every path begins with a secret that other users of the machine and pages of other sites cannot
guess. Requests with another host name (as after DNS rebinding) or from another page are refused.
"""

import re
import secrets
import threading
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from text2sim.replay.page import live_page
from text2sim.watching.access_control import HEADERS, admitted_path, content_security_policy
from text2sim.watching.page_state import PageState

HOST = "127.0.0.1"
MAX_LISTENERS = 16
"""Largest number of connected pages."""
KEEP_ALIVE = 10.0
"""Time [s] between keep-alive messages to a page."""
_SCENE = re.compile(r"scene/([\w-]{1,60})\Z")


class PageServer:
    """Serves the page of a state."""

    def __init__(self, state: PageState, port: int = 0) -> None:
        token = secrets.token_urlsafe(18)
        nonce = secrets.token_urlsafe(12)
        self._server = _Server((HOST, port), _Handler)
        self._server.state, self._server.token, self._server.nonce = state, token, nonce
        self._server.page = live_page(nonce).encode()
        self._state = state
        self.url = f"http://{HOST}:{self._server.server_port}/{token}/"
        """Address of the page."""
        self._thread = threading.Thread(target=self._server.serve_forever, name="page", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop listening."""
        self._state.close()
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False
    state: PageState
    token: str
    nonce: str
    page: bytes

    def __init__(self, *arguments: Any) -> None:
        self.listeners = threading.BoundedSemaphore(MAX_LISTENERS)
        super().__init__(*arguments)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore pages that disconnect during an answer."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server: _Server  # type: ignore[assignment]
    server_version, sys_version = "text2sim", ""
    timeout = 30.0

    def do_GET(self) -> None:
        path = self._path()
        if path is None:
            self._answer(404, b"there is nothing here\n", "text/plain; charset=utf-8")
        elif path == "":
            self._answer(200, self.server.page, "text/html; charset=utf-8")
        elif path == "state":
            self._answer(200, self.server.state.read()[1].encode(), "application/json")
        elif path == "events":
            self._follow()
        elif (match := _SCENE.match(path)) and (scene := self.server.state.scene(match[1])) is not None:
            self._answer(200, scene, "application/json")
        else:
            self._answer(404, b"there is nothing here\n", "text/plain; charset=utf-8")

    do_HEAD = do_GET

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing: the terminal is for messages about the case."""

    def _path(self) -> str | None:
        """The path below the secret; see `admitted_path`."""
        port = self.server.server_port
        headers: Any = self.headers
        return admitted_path(self.path, headers, {f"{HOST}:{port}", f"localhost:{port}"}, self.server.token)

    def _headers(self, status: int, kind: str) -> None:
        self.send_response(status)
        rows = {"Content-Type": kind, "Cache-Control": "no-store", **HEADERS}
        for name, value in (rows | {"Content-Security-Policy": content_security_policy(self.server.nonce)}).items():
            self.send_header(name, value)

    def _answer(self, status: int, body: bytes, kind: str) -> None:
        self._headers(status, kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def _follow(self) -> None:
        """Send every new version of the state until the page is closed."""
        if self.command == "HEAD" or not self.server.listeners.acquire(blocking=False):
            self._answer(503, b"too many pages\n", "text/plain; charset=utf-8")
            return
        with suppress(OSError):
            try:
                self.close_connection = True
                self._headers(200, "text/event-stream")
                self.end_headers()
                state, version = self.server.state, -1
                while not state.closed:
                    news = state.follow(version, KEEP_ALIVE)
                    if news is None:
                        self.wfile.write(b": still here\n\n")
                    else:
                        version, content = news
                        self.wfile.write(b"data: " + content.encode() + b"\n\n")
            finally:
                self.server.listeners.release()
