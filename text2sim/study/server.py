"""Page on which people compare films; its addresses, headers and text do not reveal the methods.

A random number in a cookie identifies a person. There is a single address, which shows the next comparison of that
person. Films are requested by comparison and side.
"""

import secrets
import socket
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.base import BaseHTTPMiddleware
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route

from text2sim.evidence.page import render_page
from text2sim.study.answers import Answers
from text2sim.study.build import FILMS, read_study
from text2sim.watching.access_control import HEADERS, admitted_path, content_security_policy

LEVELS = {
    "-2": "A much better",
    "-1": "A better",
    "0": "no difference",
    "1": "B better",
    "2": "B much better",
    "none": "cannot judge",
}
COOKIE = "person"
MONTH = 30 * 24 * 3600
MAX_FORM_SIZE = 10_000
"""Largest size of a submitted form [bytes]."""


class StudyPage:
    """Serves a study.

    Args:
        folder: The folder of the study.
        hosts: Values of the `Host` header that are accepted, `name:port`.
    """

    def __init__(self, folder: Path, hosts: frozenset[str]) -> None:
        self._folder, self._hosts, self._study = folder, hosts, read_study(folder)
        self.answers = Answers(folder, self._study)
        routes = [
            Route("/{token}/", self._show_page, methods=["GET"]),
            Route("/{token}/", self._submit, methods=["POST"]),
            Route("/{token}/film/{trial:int}/{side}", self._send_film, methods=["GET"]),
        ]
        guard = Middleware(BaseHTTPMiddleware, dispatch=self._guard)
        self.app = Starlette(routes=routes, middleware=[guard], exception_handlers={404: _not_found, 405: _not_found})

    async def _guard(self, request: Request, call: Callable[[Request], Awaitable[Response]]) -> Response:
        path = request.scope["raw_path"].decode("ascii", "replace")
        if admitted_path(path, request.headers, self._hosts, self.answers.token) is None:
            return await _not_found(request)
        answer = await call(request)
        for name, value in {"Cache-Control": "no-store", **HEADERS}.items():
            answer.headers.setdefault(name, value)
        return answer

    def _position(self, request: Request) -> tuple[str, int, int] | None:
        """The person, the assignment, and the number of the current comparison; None for an unknown person."""
        person = request.cookies.get(COOKIE, "")
        found = self.answers.position(person)
        return None if found is None else (person, *found)

    async def _show_page(self, request: Request) -> Response:
        place = self._position(request)
        if place is None:
            return _render("consent", consent=self._study.consent)
        return self._show_comparison(*place[1:])

    def _show_comparison(self, assignment: int, number: int, missing: tuple[str, ...] = ()) -> Response:
        trials = self._study.assignments[assignment]
        if number == len(trials):
            return _render("end")
        return _render(
            "trial", 422 if missing else 200, number=number, count=len(trials), questions=self._study.questions,
            prompt=self._study.prompts[trials[number].task], levels=LEVELS, missing=missing,
        )  # fmt: skip

    async def _submit(self, request: Request) -> Response:
        if int(request.headers.get("Content-Length", MAX_FORM_SIZE + 1)) > MAX_FORM_SIZE:
            return PlainTextResponse("too large\n", 413)
        form = {name: rows[-1] for name, rows in parse_qs((await request.body()).decode("utf-8", "replace")).items()}
        place = self._position(request)
        redirect = RedirectResponse(request.url.path, 303)
        if place is None:
            if form.get("agree") == "yes":
                person = self.answers.begin()
                if person is None:
                    return _render("full")
                redirect.set_cookie(COOKIE, person, max_age=MONTH, path=request.url.path, httponly=True, samesite="lax")
            return redirect
        person, assignment, number = place
        finished = number == len(self._study.assignments[assignment])
        if finished or form.get("number") != str(number):  # submitted twice, or from an old page
            return redirect
        missing = tuple(name for name in self._study.questions if form.get(name) not in LEVELS)
        if missing:
            return self._show_comparison(assignment, number, missing)
        levels = {name: form[name] for name in self._study.questions}
        self.answers.give(person, number, {k: None if v == "none" else int(v) for k, v in levels.items()})
        return redirect

    async def _send_film(self, request: Request) -> Response:
        place, number, side = self._position(request), request.path_params["trial"], request.path_params["side"]
        if place is None or side not in ("a", "b"):
            return await _not_found(request)
        trials = self._study.assignments[place[1]]
        if not 0 <= number < len(trials):
            return await _not_found(request)
        film = self._folder / FILMS / f"{self._study.film(trials[number], side)}.mp4"
        # The page prefetches the films of the next comparison, so the browser must cache them.
        return FileResponse(film, media_type="video/mp4", headers={"Cache-Control": "private, max-age=86400"})


def _render(state: str, status: int = 200, **contents: Any) -> Response:
    nonce = secrets.token_urlsafe(12)
    page = render_page("study", "page.html.j2", {"state": state, "nonce": nonce, **contents})
    # With `no-referrer`, browsers submit a form with the origin `null`, which `admitted_path` could not check.
    headers = {"Content-Security-Policy": content_security_policy(nonce, "'self'"), "Referrer-Policy": "same-origin"}
    return HTMLResponse(page, status, headers)


async def _not_found(request: Request, error: Exception | None = None) -> Response:
    return PlainTextResponse("there is nothing here\n", 404)


def serve(folder: Path, address: str, port: int, tell: Callable[[str], None]) -> None:
    """Serve a study until it is interrupted.

    Args:
        folder: The folder of the study.
        address: Address to listen at.
        port: Port; 0 chooses a free one.
        tell: Called with the URL of the page.

    Raises:
        OSError: If it cannot listen at this address and port.
    """
    listening = socket.create_server((address, port))
    port = listening.getsockname()[1]
    page = StudyPage(folder, frozenset({f"{address}:{port}", f"localhost:{port}"}))
    tell(f"http://{address}:{port}/{page.answers.token}/")
    config = uvicorn.Config(page.app, log_level="warning", server_header=False, access_log=False)
    try:
        uvicorn.Server(config).run(sockets=[listening])
    finally:
        page.answers.close()
