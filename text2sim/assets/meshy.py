"""Client of Meshy's REST API for text to 3D: a preview of the shape, then its texture.

The API (docs.meshy.ai, text to 3D, version 2): `POST /openapi/v2/text-to-3d` returns the id of a task, `GET` with an
id its status, `GET` without one the latest tasks. A task goes from PENDING and IN_PROGRESS to SUCCEEDED, FAILED,
CANCELED or EXPIRED. Links to results are valid for some days.
"""

import json
import os
import re
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from text2sim.assets.foreign_files import printable_line
from text2sim.assets.meshy_ledger import MeshyTask, Order, OrderLedger, Stage
from text2sim.spec_schema.errors import AssetError, MachineError, RunError

if TYPE_CHECKING:
    import httpx

BASE_URL = "https://api.meshy.ai"
API_PATH = "/openapi/v2/text-to-3d"
KEY_VARIABLE = "MESHY_API_KEY"
"""Environment variable of the key. The key is only sent to Meshy, never printed or stored."""
PRICES = {"meshy-5": 5}
PREVIEW_CREDITS, REFINE_CREDITS = 20, 10
"""Credits of a preview (of models that `PRICES` does not list), and of its texture."""
MAX_PROMPT = 600
MAX_GLB = 64 * 1024 * 1024
MAX_JSON = 1024 * 1024
MAX_TRIES = 6
"""Number of attempts at a request while network or server fail."""
FIRST_POLL, LONGEST_POLL = 2.0, 20.0
"""Seconds between two polls of a task: the first, and the longest."""
MAX_CLOCK_DIFFERENCE = 120_000
"""Largest difference [ms] between our clock and Meshy's when a lost task is searched."""
PENDING_STATES = ("PENDING", "IN_PROGRESS")
_ID = re.compile(r"[A-Za-z0-9_-]{1,100}")


@dataclass(frozen=True)
class Order3D:
    """Specification of a mesh."""

    prompt: str
    """Description, at most 600 characters."""
    refine: bool = True
    """Whether it gets a texture; the shape alone costs less."""
    model: str = "latest"
    """Name of Meshy's model."""
    triangles: int = 30_000
    """Approximate number of triangles."""

    def __post_init__(self) -> None:
        text = self.prompt
        if not text.strip() or len(text) > MAX_PROMPT or not text.isprintable():
            raise AssetError(f"a prompt is one line of 1 to {MAX_PROMPT} characters (got {len(text)})")
        if not _ID.fullmatch(self.model.replace(".", "_")):
            raise AssetError(f"`{self.model[:40]}` is not the name of a model")
        if not 100 <= self.triangles <= 300_000:
            raise AssetError(f"{self.triangles} triangles are not possible: Meshy makes 100 to 300000")

    def price(self, stage: Stage) -> int:
        """Return the credits of a stage according to the public price list."""
        return REFINE_CREDITS if stage == "refine" else PRICES.get(self.model, PREVIEW_CREDITS)


class Meshy:
    """Makes meshes for a case.

    Args:
        case: The case's folder, which keeps the tasks.
        base: Address of Meshy.
        budget: Credits that the case may cost in total, with earlier tasks.
        timeout: Seconds that one mesh may take.
        say: Receives progress.
        pause: Waits for some seconds.
        clock: A monotonic clock [s].

    Raises:
        MachineError: if there is no key.
        AssetError: if `base` is neither https nor on this machine.
    """

    def __init__(
        self,
        case: Path,
        *,
        base: str = BASE_URL,
        budget: int = 100,
        timeout: float = 900.0,
        say: Callable[[str], None] = lambda text: None,
        pause: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        if not os.environ.get(KEY_VARIABLE, "").strip():
            raise MachineError(
                f"there is no {KEY_VARIABLE} in the environment; without a key, build the shape from the language's "
                "own shapes"
            )
        if not _is_trusted(base, base):
            raise AssetError(f"`{base[:80]}` is not an https address")
        self.base, self.budget, self.timeout, self.say = base.rstrip("/"), budget, timeout, say
        self._pause, self._clock, self._end = pause, clock, 0.0
        self._ledger = OrderLedger(case)

    def make(self, wanted: Order3D) -> bytes:
        """Return the .glb of a specification; one that was made before is only downloaded.

        Raises:
            RunError: if Meshy refuses or fails, or the budget is too small.
            MachineError: if Meshy cannot be reached or time runs out; the same call continues with the same task.
        """
        import httpx

        self._end = self._clock() + self.timeout
        key, order = self._ledger.order(
            wanted.prompt, {name: value for name, value in asdict(wanted).items() if name not in ("prompt", "refine")}
        )
        with httpx.Client(timeout=30.0, follow_redirects=False) as client:
            found = self._stage(client, "preview", wanted, key, order)
            if wanted.refine:
                found = self._stage(client, "refine", wanted, key, order)
            return self._download(client, found)

    # --- one task -----------------------------------------------------------------------------------------

    def _stage(self, client: "httpx.Client", stage: Stage, wanted: Order3D, key: str, order: Order) -> dict[str, Any]:
        """Wait for the task of a stage; start one if there is none."""
        task = order.tasks.get(stage)
        if task is not None and not task.id:
            task.id = self._find_lost_task(client, stage, wanted, task)
            if not task.id:
                del order.tasks[stage]
                task = None
        if task is None or task.over:
            task = self._ask(client, stage, wanted, key, order)
        self._ledger.write(key, order)
        found = self._wait(client, stage, task, lambda: self._ledger.write(key, order))
        if task.status != "SUCCEEDED":
            reason = _reason_in(_member(found.get("task_error"), "message"))
            because = f": {reason}" if reason else ""
            raise RunError(f"Meshy's {stage} ended as {task.status}{because}; ask again to retry")
        return found

    def _ask(self, client: "httpx.Client", stage: Stage, wanted: Order3D, key: str, order: Order) -> MeshyTask:
        price, spent = wanted.price(stage), self._ledger.spent()
        if spent + price > self.budget:
            raise RunError(
                f"a {stage} costs about {price} credits, and {spent} of the budget of {self.budget} are spent; "
                f"raise it with --budget"
            )
        if (former := order.tasks.get(stage)) is not None:
            order.former.append(former)
        task = order.tasks[stage] = MeshyTask(asked=int(time.time() * 1000), price=price)
        self._ledger.write(key, order)
        body: dict[str, Any] = {"mode": stage}
        if stage == "preview":
            body |= {"prompt": wanted.prompt, "ai_model": wanted.model, "should_remesh": True}
            body |= {"topology": "triangle", "target_polycount": wanted.triangles}
        else:
            body |= {"preview_task_id": order.tasks["preview"].id, "enable_pbr": False}
        try:
            answer = self._send(
                client, "POST", API_PATH, body, lambda: self._find_lost_task(client, stage, wanted, task)
            )
        except RunError:
            del order.tasks[stage]  # a refused task costs nothing
            self._ledger.write(key, order)
            raise
        task.id = _task_id(answer.get("result"))
        self.say(f"meshy: {stage} started, about {price} credits")
        return task

    def _wait(
        self, client: "httpx.Client", stage: Stage, task: MeshyTask, changed: Callable[[], None]
    ) -> dict[str, Any]:
        pause, last = FIRST_POLL, -1
        while True:
            found = self._send(client, "GET", f"{API_PATH}/{task.id}", missing={"status": "EXPIRED"})
            status = str(found.get("status"))
            if status not in (*PENDING_STATES, "SUCCEEDED", "FAILED", "CANCELED", "EXPIRED"):
                raise RunError(f"Meshy reports an unknown status: {printable_line(status, 40)}")
            credits = found.get("consumed_credits")
            if isinstance(credits, int) and 0 <= credits < 10_000 and status not in PENDING_STATES:
                task.credits = credits
            if status != task.status:
                task.status = status
                changed()
            if status not in PENDING_STATES:
                return found
            progress = found.get("progress")
            if isinstance(progress, int) and progress != last:
                last = progress
                self.say(f"meshy: {stage} {max(0, min(progress, 100))} %")
            self._sleep(pause)
            pause = min(pause * 1.5, LONGEST_POLL)

    def _find_lost_task(self, client: "httpx.Client", stage: Stage, wanted: Order3D, task: MeshyTask) -> str:
        """Find the id of a task whose id was never received; empty if there is no such task."""
        found = self._send(client, "GET", f"{API_PATH}?page_num=1&page_size=50&sort_by=-created_at")
        rows, known = found.get("items", []), self._ledger.known()
        for row in rows if isinstance(rows, list) else []:
            if not isinstance(row, dict) or row.get("prompt") != wanted.prompt:
                continue
            if not isinstance(name := row.get("id"), str) or name in known:
                continue
            kind = f"{row.get('mode', '')} {row.get('type', '')}".lower()
            other = "refine" if stage == "preview" else "preview"
            made = row.get("created_at")
            if other not in kind and isinstance(made, int | float) and made >= task.asked - MAX_CLOCK_DIFFERENCE:
                return _task_id(name)
        return ""

    # --- one request --------------------------------------------------------------------------------------

    def _send(
        self,
        client: "httpx.Client",
        method: str,
        path: str,
        body: dict[str, Any] | None = None,
        lost: Callable[[], str] | None = None,
        missing: dict[str, Any] | None = None,
    ) -> dict[str, Any]:
        """Send a request until there is an answer.

        Args:
            client: The connection.
            method: GET or POST.
            path: Path below the base.
            body: Body of the request.
            lost: Finds the id of the task that a request without an answer may have started.
            missing: The answer for status 404.
        """
        import httpx

        headers = {"Authorization": f"Bearer {os.environ.get(KEY_VARIABLE, '').strip()}"}
        for attempt in range(MAX_TRIES):
            wait, sent = min(FIRST_POLL * 2**attempt, LONGEST_POLL), True
            try:
                with client.stream(method, self.base + path, json=body, headers=headers) as reply:
                    if reply.status_code == 404 and missing is not None:
                        return missing
                    if reply.is_success:
                        return _plain(reply)
                    _raise_if_refused(reply)
                    sent = reply.status_code != 429
                    wait = max(wait, _retry_after(reply))
            except (httpx.ConnectError, httpx.ConnectTimeout, httpx.PoolTimeout):
                sent = False
            except httpx.TransportError:
                pass
            except (httpx.HTTPError, httpx.InvalidURL, ValueError) as error:
                raise RunError(f"Meshy cannot be asked: {type(error).__name__}") from None
            self._sleep(wait)
            if lost is not None and sent and (name := lost()):
                return {"result": name}
        raise MachineError("Meshy does not answer; nothing is lost, ask again later")

    def _download(self, client: "httpx.Client", found: dict[str, Any]) -> bytes:
        """The result of a task. The key is not sent, because results are on other machines."""
        import httpx

        url = _member(found.get("model_urls"), "glb")
        if not isinstance(url, str) or not _is_trusted(url, self.base):
            raise RunError("Meshy gives no .glb file that can be downloaded")
        for attempt in range(MAX_TRIES):
            try:
                with client.stream("GET", url) as reply:
                    if reply.status_code in (403, 404, 410):
                        raise RunError("Meshy's result no longer exists; use another prompt")
                    if reply.is_success:
                        content = _limited(reply, MAX_GLB)
                        if not content.startswith(b"glTF"):
                            raise RunError("Meshy's result is not a .glb file")
                        return content
            except httpx.InvalidURL:
                raise RunError("Meshy gives no .glb file that can be downloaded") from None
            except httpx.HTTPError:
                pass
            self._sleep(min(FIRST_POLL * 2**attempt, LONGEST_POLL))
        raise MachineError("Meshy's result cannot be downloaded; nothing is lost, ask again later")

    def _sleep(self, seconds: float) -> None:
        if self._clock() + seconds > self._end:
            raise MachineError(f"Meshy takes more than {self.timeout:g} s; nothing is lost, ask again to continue")
        self._pause(seconds)


def _raise_if_refused(reply: "httpx.Response") -> None:
    """Raise for an answer that another attempt would not change."""
    code = reply.status_code
    if code == 401:
        raise RunError(f"Meshy does not accept the key in {KEY_VARIABLE}")
    if code == 402:
        raise RunError("the Meshy account does not have enough credits")
    if code < 500 and code != 429:
        raise RunError(f"Meshy refuses ({code}): {_reason_in(_plain(reply).get('message')) or 'without a reason'}")


def _is_trusted(url: str, base: str) -> bool:
    """Whether an address is https, or on this machine like the base."""
    try:
        parts, home = urlsplit(url), urlsplit(base)
        local = parts.hostname in ("127.0.0.1", "localhost", "::1") and parts.netloc == home.netloc
    except ValueError:
        return False
    return bool(parts.hostname) and (parts.scheme == "https" or (parts.scheme == "http" and local))


def _plain(reply: "httpx.Response") -> dict[str, Any]:
    """The JSON of an answer as a mapping; a list becomes its `items`."""
    try:
        data = json.loads(_limited(reply, MAX_JSON))
    except (ValueError, RecursionError):
        return {}
    return data if isinstance(data, dict) else {"items": data}


def _limited(reply: "httpx.Response", max_bytes: int) -> bytes:
    content = bytearray()
    for block in reply.iter_bytes():
        content += block
        if len(content) > max_bytes:
            raise RunError(f"Meshy's answer is larger than {max_bytes // 2**20} MiB")
    return bytes(content)


def _retry_after(reply: "httpx.Response") -> float:
    text = reply.headers.get("retry-after", "")
    return min(float(text), 120.0) if text.isdigit() and len(text) < 6 else 0.0


def _task_id(value: Any) -> str:
    if not isinstance(value, str) or not _ID.fullmatch(value):
        raise RunError("Meshy's answer has no valid task id")
    return value


def _member(value: Any, key: str) -> Any:
    """What a mapping of an answer has under a key; None if it has nothing, or is no mapping."""
    return value.get(key) if isinstance(value, dict) else None


def _reason_in(value: Any) -> str:
    """Untrusted text as one short printable line; empty for anything else."""
    return printable_line(value, 200) if isinstance(value, str) else ""
