"""A real Chromium without a window, driven over a pipe by its debugging protocol."""

import base64
import itertools
import json
import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")


def find() -> str | None:
    """Return the path of a Chromium, if there is one."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


class Chromium:
    """One page."""

    def __init__(self, profile: Path, drawing: str = "--disable-gpu") -> None:
        down, up = os.pipe(), os.pipe()
        flags = f"--headless=new --no-sandbox {drawing} --no-first-run --remote-debugging-pipe --mute-audio"

        def wire() -> None:  # the browser reads from 3 and writes to 4
            reading, writing = os.dup(down[0]), os.dup(up[1])
            os.dup2(reading, 3)
            os.dup2(writing, 4)

        self._process = subprocess.Popen(
            [str(find()), *flags.split(), "--autoplay-policy=no-user-gesture-required", "--window-size=1300,850",
             f"--user-data-dir={profile}", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=wire, close_fds=False,
            start_new_session=True,
        )  # fmt: skip
        os.close(down[0])
        os.close(up[1])
        self._out, self._in = os.fdopen(down[1], "wb", buffering=0), os.fdopen(up[0], "rb")
        self._numbers = itertools.count(1)
        self._session: str | None = None
        pages = [t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page"]
        self._session = self.call("Target.attachToTarget", targetId=pages[0]["targetId"], flatten=True)["sessionId"]

    def go(self, url: str) -> None:
        """Open a page."""
        self.call("Page.navigate", url=url)

    def ask(self, expression: str) -> Any:
        """Evaluate JavaScript in the page; a promise is waited for."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def wait(self, expression: str, timeout: float = 20.0) -> Any:
        """Wait until an expression is true; return its value."""
        until = time.monotonic() + timeout
        while not (value := self.ask(expression)):
            assert time.monotonic() < until, f"never true: {expression}\n{self.ask('document.body.innerText')}"
            time.sleep(0.05)
        return value

    def shoot(self, path: Path) -> None:
        """Write a picture of the page."""
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot")["data"]))

    def leave(self) -> None:
        """Close it as people do: what belongs to its profile is written."""
        self.call("Browser.close")
        self._process.wait(20)

    def close(self) -> None:
        """End it."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, 9)
            self._process.wait()

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """Send a command of the protocol, and return its answer."""
        number = next(self._numbers)
        message: dict[str, Any] = {"id": number, "method": method, "params": params}
        if self._session is not None:
            message["sessionId"] = self._session
        self._out.write(json.dumps(message).encode() + b"\0")
        while True:
            answer = json.loads(self._read())
            if answer.get("id") == number:
                assert "error" not in answer, answer
                return answer["result"]

    def _read(self) -> bytes:
        data = bytearray()
        while (byte := self._in.read(1)) not in (b"\0", b""):
            data += byte
        assert data, "the browser is gone"
        return bytes(data)
