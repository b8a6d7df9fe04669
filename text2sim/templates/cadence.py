"""Which moments a film shows: its shots, and for every picture the camera, the simulated time and the exposure.

    reels(film)                 file name -> shots, for each film that is made
    frames(film, reel, last)    the pictures of one of them

A *film* is what `render.py` says, as a dictionary with lower-case keys; `read_film` makes it of the text, without
running anything. Whatever draws the film takes its pictures from here: a preview and a finished film show the same.
"""

import ast
from typing import NamedTuple

MAIN = "video"
"""The first film; the others are `video_<camera>`."""


BACK = 0.25
"""Time [s of film] by which a shot goes back to be a replay."""


class Frame(NamedTuple):
    """A picture of a film."""

    k: int
    """Its number, from 0."""
    camera: str
    t: float
    """Simulated time [s]."""
    part: float
    """How far a camera that moves over its shots has come, 0 to 1."""
    open: float
    """Simulated time [s] at which the shutter opens,"""
    close: float
    """and at which it closes: the same where nothing is blurred."""
    pace: float
    """Change of `part` per simulated second."""
    speed: float
    """Simulated seconds per second of film."""
    again: bool = False
    """Whether it shows once more what was shown before."""

    def moments(self, n: int) -> list[tuple[float, float]]:
        """Time [s] and part at n moments while the shutter is open, in the middle of as many equal spans."""
        if n < 2 or self.close <= self.open:
            return [(self.t, self.part)]
        span = self.close - self.open
        times = [self.open + span * (i + 0.5) / n for i in range(n)]
        return [(t, self.part + (t - self.t) * self.pace) for t in times]


def read_film(text: str) -> dict:
    """Return what the text of a `render.py` says: its constants, by lower-case name.

    Raises:
        ValueError: It has none, or says them by computing.
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
    """Return what an imported `render` says: its constants, by lower-case name."""
    return {name.lower(): value for name, value in vars(module).items() if name.isupper()}


def reels(film: dict) -> dict[str, list[dict]]:
    """Return the shots of each film by the name of its file, without its ending; the main film first.

    The main film is cut from the shots, or is the first camera's where there are none. Every camera that it does not
    use makes a film of its own.
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
        film: What `render.py` says.
        reel: Shots of the film, one of `reels`.
        last: Last recorded time [s]; what was not recorded is not shown.
    """
    found, seen = [], -float("inf")
    for shot in _recorded(reel, last):
        # A cut that goes back by less than is noticed is no replay, and what comes after a second view is new.
        until, seen = seen if shot["from"] < seen - BACK * shot["speed"] else shot["from"], max(seen, shot["to"])
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
    """Return the shots as far as they were recorded; at least one picture."""
    shots = [shot | {"hold": shot["hold"] * (shot["to"] <= last + 1e-9)} for shot in reel if shot["from"] <= last]
    shots = shots or [reel[0] | {"from": last, "hold": 0.0}]
    return [shot | {"to": max(min(shot["to"], last), shot["from"])} for shot in shots]


def _takes(cameras: list[str]) -> list[tuple[int, int]]:
    """Return the spans of pictures, (first, end), that one camera takes without a cut."""
    cuts = [k for k in range(len(cameras)) if k == 0 or cameras[k] != cameras[k - 1]]
    return list(zip(cuts, [*cuts[1:], len(cameras)], strict=True))
