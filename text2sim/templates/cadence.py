"""The pictures of a film: its shots, and for every picture the camera, the simulated time and the exposure.

    reels(film)                 file name -> shots, for each film
    frames(film, reel, last)    the pictures of one film

A *film* is a dictionary of the constants of `render.py`, with lower-case keys. `read_film` parses it from the text
without running it. The preview and the path tracer both take their pictures from here, so they show the same film.
"""

import ast
from typing import NamedTuple

MAIN = "video"
"""Name of the main film; the others are `video_<camera>`."""

BACK = 0.25
"""Least time [s of film] by which a shot goes back to count as a replay."""


class Frame(NamedTuple):
    """One picture of a film."""

    k: int
    """Number of the picture, from 0."""
    camera: str
    t: float
    """Simulated time [s]."""
    part: float
    """Progress of a camera that moves over its take, 0 to 1."""
    open: float
    """Simulated time [s] at which the shutter opens."""
    close: float
    """Simulated time [s] at which the shutter closes; equal to `open` without motion blur."""
    pace: float
    """Change of `part` per simulated second."""
    speed: float
    """Simulated seconds per second of film."""
    again: bool = False
    """Whether it belongs to a replay."""

    def moments(self, n: int) -> list[tuple[float, float]]:
        """Return (time [s], part) at the middles of n equal spans of the exposure."""
        if n < 2 or self.close <= self.open:
            return [(self.t, self.part)]
        span = self.close - self.open
        times = [self.open + span * (i + 0.5) / n for i in range(n)]
        return [(t, self.part + (t - self.t) * self.pace) for t in times]


def read_film(text: str) -> dict:
    """Return the constants in the text of a `render.py`, by lower-case name.

    Raises:
        ValueError: If they are not plain constants, or there are no cameras.
    """
    film = {}
    try:
        for statement in ast.parse(text).body:
            if not isinstance(statement, ast.Assign):
                continue
            value = ast.literal_eval(statement.value)
            if isinstance(target := statement.targets[0], ast.Name):
                film[target.id.lower()] = value
            elif isinstance(target, ast.Tuple):  # START, END = 0.0, 2.0
                film |= {name.id.lower(): one for name, one in zip(target.elts, value, strict=True)}
    except (SyntaxError, ValueError, TypeError, MemoryError, RecursionError) as error:
        raise ValueError(f"render.py does not hold plain constants: {error}") from error
    if "cameras" not in film:
        raise ValueError("render.py names no CAMERAS")
    return film


def film_of(module) -> dict:
    """Return the constants of an imported `render` module, by lower-case name."""
    return {name.lower(): value for name, value in vars(module).items() if name.isupper()}


def reels(film: dict) -> dict[str, list[dict]]:
    """Return the shots of each film by file name without suffix, the main film first.

    The main film consists of the shots, or of the first camera's view if there are none. Every camera that it does not
    use gets a film of its own.
    """
    whole = {"from": film["start"], "to": film["end"], "speed": film["speed"], "hold": 0.0}
    names = list(film["cameras"])
    main = film["shots"] or [{"camera": names[0], **whole}]
    used = {shot["camera"] for shot in main}
    others = {f"{MAIN}_{name}": [{"camera": name, **whole}] for name in names if name not in used}
    return {MAIN: main, **others}


def frames(film: dict, reel: list[dict], last: float) -> list[Frame]:
    """Return the pictures of a film.

    Args:
        film: Constants of `render.py`.
        reel: Shots of the film, a value of `reels`.
        last: Last recorded time [s]; the film ends there.
    """
    found, seen = [], -float("inf")
    for shot in _recorded(reel, last):
        # A cut that goes back by less than BACK is no replay; a replay ends where the shot shows something new.
        until = seen if shot["from"] < seen - BACK * shot["speed"] else shot["from"]
        seen = max(seen, shot["to"])
        step = shot["speed"] / film["fps"]
        blur = film["motion_blur"] * step / 2
        for i in range(max(1, round((shot["to"] - shot["from"]) / step))):
            t = min(shot["from"] + i * step, shot["to"])
            shutter = max(t - blur, shot["from"]), min(t + blur, shot["to"])
            found.append((shot["camera"], t, *shutter, step, t < until))
        held = (shot["camera"], *[shot["to"]] * 3, step, shot["from"] < until >= shot["to"])
        found += [held] * round(shot["hold"] * film["fps"])
    pictures = []
    for first, end in _takes([row[0] for row in found]):
        whole = max(end - first - 1, 1)
        for k in range(first, end):
            camera, t, opened, closed, step, again = found[k]
            part, pace = (k - first) / whole, 1 / (whole * step)
            pictures.append(Frame(k, camera, t, part, opened, closed, pace, step * film["fps"], again))
    return pictures


def _recorded(reel: list[dict], last: float) -> list[dict]:
    """Return the shots, cut at the last recorded time; they give at least one picture."""
    shots = [shot | {"hold": shot["hold"] * (shot["to"] <= last + 1e-9)} for shot in reel if shot["from"] <= last]
    shots = shots or [reel[0] | {"from": last, "hold": 0.0}]
    return [shot | {"to": max(min(shot["to"], last), shot["from"])} for shot in shots]


def _takes(cameras: list[str]) -> list[tuple[int, int]]:
    """Return the takes: spans of pictures (first, end) between changes of the camera."""
    cuts = [k for k in range(len(cameras)) if k == 0 or cameras[k] != cameras[k - 1]]
    return list(zip(cuts, [*cuts[1:], len(cameras)], strict=True))
