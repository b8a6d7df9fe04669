"""A server on this machine that speaks Meshy's protocol for text to 3D, with faults on demand."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

PATH = "/openapi/v2/text-to-3d"
KEY = "msy_test_key_that_must_not_leak"


class MeshyServer:
    """Tasks, and what was asked for."""

    def __init__(self, glb: bytes) -> None:
        self.glb = glb
        self.tasks: dict[str, dict[str, Any]] = {}
        self.log: list[str] = []
        self.faults: list[int | str] = []
        """What the next requests are answered with: a status, `drop` (obeyed, no answer), `garbage`."""
        self.polls = 1
        """How often a task is still in progress."""
        self.ends = "SUCCEEDED"
        self.downloads_with_key = 0
        self.base = ""

    def posted(self) -> list[str]:
        """The tasks that were made, by mode."""
        return [task["mode"] for task in self.tasks.values()]

    def create(self, body: dict[str, Any]) -> str:
        name = f"018a-{len(self.tasks):04d}"
        prompt = body.get("prompt") or self.tasks[body["preview_task_id"]]["prompt"]
        self.tasks[name] = {
            "id": name, "mode": body["mode"], "prompt": prompt, "created_at": int(time.time() * 1000),
            "looked": 0, "body": body,
        }  # fmt: skip
        return name

    def look(self, name: str) -> dict[str, Any]:
        task = self.tasks[name]
        task["looked"] += 1
        done = task["looked"] > self.polls
        found = {key: task[key] for key in ("id", "mode", "prompt", "created_at")}
        found |= {"status": self.ends if done else "IN_PROGRESS", "progress": 100 if done else 40}
        found |= {"model_urls": {"glb": f"{self.base}/files/{name}.glb"}, "task_error": {"message": ""}}
        if done:
            found["consumed_credits"] = 20 if task["mode"] == "preview" else 10
            if self.ends == "FAILED":
                found |= {"task_error": {"message": "the\x1b[2J shape collapsed"}, "consumed_credits": 0}
        return found


class _Handler(BaseHTTPRequestHandler):
    server: Any
    protocol_version = "HTTP/1.1"

    def log_message(self, format: str, *args: object) -> None:
        pass

    def do_GET(self) -> None:
        self._serve(lambda state, body: self._get(state))

    def do_POST(self) -> None:
        self._serve(lambda state, body: (202, {"result": state.create(body)}))

    def _serve(self, work: Callable[[MeshyServer, dict[str, Any]], tuple[int, Any]]) -> None:
        state: MeshyServer = self.server.state
        body = json.loads(self.rfile.read(int(self.headers.get("content-length", 0))) or b"{}")
        if self.path.startswith("/files/"):
            state.downloads_with_key += "authorization" in self.headers
            self._answer(200, state.glb)
            return
        state.log.append(f"{self.command} {self.path.split('?')[0]}")
        if self.headers.get("authorization") != f"Bearer {KEY}":
            self._answer(401, {"message": "Invalid API key"})
            return
        fault = state.faults.pop(0) if state.faults else None
        if isinstance(fault, int):
            self._answer(fault, {"message": f"fault {fault}"}, {"retry-after": "7"} if fault == 429 else {})
            return
        answer = work(state, body)
        if fault == "drop":
            self.close_connection = True
            self.connection.close()
        elif fault == "garbage":
            self._answer(200, b"<html>")
        else:
            self._answer(*answer)

    def _get(self, state: MeshyServer) -> tuple[int, Any]:
        name = self.path.removeprefix(PATH).split("?")[0].strip("/")
        if not name:
            return 200, [state.look(name) for name in reversed(state.tasks)]
        return (200, state.look(name)) if name in state.tasks else (404, {"message": "no such task"})

    def _answer(self, status: int, body: Any, headers: dict[str, str] | None = None) -> None:
        content = body if isinstance(body, bytes) else json.dumps(body).encode()
        self.send_response(status)
        for key, value in (headers or {}).items():
            self.send_header(key, value)
        self.send_header("content-length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)


@contextmanager
def meshy_server(glb: bytes) -> Iterator[MeshyServer]:
    """A server that runs for the time being."""
    state = MeshyServer(glb)
    server: Any = ThreadingHTTPServer(("127.0.0.1", 0), _Handler)
    server.state = state
    state.base = f"http://127.0.0.1:{server.server_address[1]}"
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield state
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
