"""The page on which people compare films: nothing in its addresses, headers and text tells who made which.

A person is a random number in a cookie. There is one address; what it shows depends on how far the person is. A film is
asked for by comparison and side.
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
from text2sim.watching.admission import HEADERS, admitted, policy

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
LARGEST = 10_000
"""Bytes of a form that is sent."""


class StudyPage:
    """Serves a study.

    Args:
        folder: Of the study.
        hosts: Names with ports under which browsers ask.
    """

    def __init__(self, folder: Path, hosts: frozenset[str]) -> None:
        self._folder, self._hosts, self._study = folder, hosts, read_study(folder)
        self.answers = Answers(folder, self._study)
        routes = [
            Route("/{token}/", self._page, methods=["GET"]),
            Route("/{token}/", self._sent, methods=["POST"]),
            Route("/{token}/film/{trial:int}/{side}", self._film, methods=["GET"]),
        ]
        guard = Middleware(BaseHTTPMiddleware, dispatch=self._guard)
        self.app = Starlette(routes=routes, middleware=[guard], exception_handlers={404: _nothing, 405: _nothing})

    async def _guard(self, request: Request, call: Callable[[Request], Awaitable[Response]]) -> Response:
        path = request.scope["raw_path"].decode("ascii", "replace")
        if admitted(path, request.headers, self._hosts, self.answers.token) is None:
            return await _nothing(request)
        answer = await call(request)
        for name, value in {"Cache-Control": "no-store", **HEADERS}.items():
            answer.headers.setdefault(name, value)
        return answer

    def _place(self, request: Request) -> tuple[str, int, int] | None:
        """Who asks, the assignment, and the comparison at which they are."""
        person = request.cookies.get(COOKIE, "")
        found = self.answers.position(person)
        return None if found is None else (person, *found)

    async def _page(self, request: Request) -> Response:
        place = self._place(request)
        if place is None:
            return _shown("consent", consent=self._study.consent)
        return self._comparison(*place[1:])

    def _comparison(self, assignment: int, number: int, missing: tuple[str, ...] = ()) -> Response:
        trials = self._study.assignments[assignment]
        if number == len(trials):
            return _shown("end")
        return _shown(
            "trial", 422 if missing else 200, number=number, count=len(trials), questions=self._study.questions,
            prompt=self._study.prompts[trials[number].task], levels=LEVELS, missing=missing,
        )  # fmt: skip

    async def _sent(self, request: Request) -> Response:
        if int(request.headers.get("Content-Length", LARGEST + 1)) > LARGEST:
            return PlainTextResponse("too large\n", 413)
        given = {name: rows[-1] for name, rows in parse_qs((await request.body()).decode("utf-8", "replace")).items()}
        place = self._place(request)
        back = RedirectResponse(request.url.path, 303)
        if place is None:
            if given.get("agree") == "yes":
                person = self.answers.begin()
                if person is None:
                    return _shown("full")
                back.set_cookie(COOKIE, person, max_age=MONTH, path=request.url.path, httponly=True, samesite="lax")
            return back
        person, assignment, number = place
        over = number == len(self._study.assignments[assignment])
        if over or given.get("number") != str(number):  # sent twice, or from an old page
            return back
        missing = tuple(name for name in self._study.questions if given.get(name) not in LEVELS)
        if missing:
            return self._comparison(assignment, number, missing)
        levels = {name: given[name] for name in self._study.questions}
        self.answers.give(person, number, {k: None if v == "none" else int(v) for k, v in levels.items()})
        return back

    async def _film(self, request: Request) -> Response:
        place, number, side = self._place(request), request.path_params["trial"], request.path_params["side"]
        if place is None or side not in ("a", "b"):
            return await _nothing(request)
        trials = self._study.assignments[place[1]]
        if not 0 <= number < len(trials):
            return await _nothing(request)
        film = self._folder / FILMS / f"{self._study.film(trials[number], side)}.mp4"
        # Kept by the browser, so that the next comparison's are there when it is shown.
        return FileResponse(film, media_type="video/mp4", headers={"Cache-Control": "private, max-age=86400"})


def _shown(state: str, status: int = 200, **contents: Any) -> Response:
    nonce = secrets.token_urlsafe(12)
    page = render_page("study", "page.html.j2", {"state": state, "nonce": nonce, **contents})
    # Without any referrer a form is sent from the origin `null`, which is everybody's.
    headers = {"Content-Security-Policy": policy(nonce, "'self'"), "Referrer-Policy": "same-origin"}
    return HTMLResponse(page, status, headers)


async def _nothing(request: Request, error: Exception | None = None) -> Response:
    return PlainTextResponse("there is nothing here\n", 404)


def serve(folder: Path, address: str, port: int, tell: Callable[[str], None]) -> None:
    """Serve a study until somebody stops it.

    Args:
        folder: Of the study.
        address: Of this machine, at which to listen.
        port: 0 takes one that is free.
        tell: Told the address of the page.

    Raises:
        OSError: If it cannot listen there.
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
