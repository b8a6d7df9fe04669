"""Rendering of self-contained HTML pages, and their formats of numbers and prose."""

import base64
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from text2sim.spec_schema.plain import plain

MAX_EMBEDDED_SIZE = 30_000_000
"""Films up to this size [bytes] together are put into the page; larger ones are linked."""


def render_page(package: str, template: str, contents: Mapping[str, Any]) -> str:
    """Render a template from a package of text2sim.

    Args:
        package: Folder of `text2sim`.
        template: File in it; it may include `page.css`.
        contents: Variables of the template.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    here = Path(__file__).parent
    # Strings of a case are untrusted: everything is escaped.
    environment = Environment(
        loader=FileSystemLoader([here.parent / package, here]),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=lambda value: plain(value) if type(value) is str else value,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"number": _number, "seconds": _seconds, "percent": _percent, "prose": _prose}
    return environment.get_template(template).render(contents)


def films_script() -> dict[str, str]:
    """Return `script`, which plays the films in each `.together` of a page together, and `allowed`, its digest.

    A page may run no other script, so that nothing in a case can be executed.
    """
    script = Path(__file__).with_name("films.js").read_text("utf-8")
    return {"script": script, "allowed": base64.b64encode(sha256(script.encode()).digest()).decode()}


def data_uri(path: Path | None, kind: str) -> str | None:
    """Return a file as a data URI; `kind` is its media type."""
    if path is None or not path.is_file():
        return None
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


def _number(value: Any, unit: str = "") -> str:
    """Return a number with four digits and its unit; a dash for none."""
    if value is None:
        return "–"
    if isinstance(value, list | tuple):
        return f"({', '.join(_number(x) for x in value)}) {unit}".rstrip()
    return f"{value:.4g} {unit}".rstrip() if isinstance(value, int | float) else str(value)


def sentence(text: str) -> str:
    """Return text with an initial capital and a final full stop."""
    return text[:1].upper() + text[1:].rstrip(".") + "."


def _percent(share: Any) -> str:
    return f"{100 * share:.2g} %"


def _prose(text: Any) -> Any:
    """Return text as HTML, with text in backticks set as code."""
    from markupsafe import Markup, escape

    parts = str(text).split("`")
    if len(parts) % 2 == 0:  # not in pairs
        return escape(text)
    marked = (escape(p) if i % 2 == 0 else Markup("<code>{}</code>").format(p) for i, p in enumerate(parts))
    return Markup("").join(marked)


def _seconds(value: Any) -> str:
    return "–" if value is None else f"{value:.3f} s"


def read_films(run_dir: Path, room: int | None = None) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
    """Return films as (name, data URI), and those that exceed `room` [bytes] as (name, file)."""
    room = MAX_EMBEDDED_SIZE if room is None else room
    paths = [run_dir / "video.mp4", *sorted(run_dir.glob("video_*.mp4"))]
    found, linked = [], []
    for path in paths:
        if not path.is_file():
            continue
        name, size = path.stem.removeprefix("video").lstrip("_"), path.stat().st_size
        if size < room:
            room -= size
            found.append((name, data_uri(path, "video/mp4") or ""))
        else:
            linked.append((name, path.name))
    return found, linked
