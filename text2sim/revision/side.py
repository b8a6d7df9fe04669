"""One side of a comparison: a file, a case's folder, a revision in git, a variant, or a run."""

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from text2sim.revision.repository import extract, find_commit
from text2sim.spec_schema.errors import Problem, RunError, SpecError
from text2sim.spec_schema.load import CASE_FILE, load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.reuse.layers import overlaid
from text2sim.spec_schema.reuse.migration import migrate
from text2sim.spec_schema.reuse.overlay import NOTHING, CaseOverlay
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source, read_source

EXPANDED = "expanded.yaml"
"""File in a run folder: the case with overlays applied and prefabs expanded."""
_VARIANTS = re.compile(r"((?:\+[A-Za-z][A-Za-z0-9_]{0,47})*)$")


@dataclass(frozen=True)
class VersionPlace:
    """Parsed form of `PATH`, `PATH@REVISION`, `PATH+VARIANT` or `PATH@REVISION+VARIANT`."""

    path: Path
    revision: str = ""
    variants: tuple[str, ...] = ()


@dataclass
class Side:
    """A version of a case."""

    label: str
    """Its name in messages."""
    written: Any
    """Plain data of the file."""
    data: Any
    """Plain data in the latest version of the language, with overlays applied; `${…}` and prefabs are not expanded."""
    loaded: LoadedCase | None = None
    """The case, if it is valid."""
    problems: list[Problem] = field(default_factory=list)
    """Problems of an invalid case."""
    run: Path | None = None
    """Its folder, if it is a run."""


def parse_place(text: str) -> VersionPlace:
    """Parse the description of a side; an existing file or folder of this exact name takes precedence.

    Raises:
        RunError: If there is no such file or folder, and no revision is named.
    """
    if Path(text).exists():
        return VersionPlace(Path(text))
    found = _VARIANTS.search(text)
    assert found is not None
    head, variants = text[: found.start()], tuple(name for name in found[0].split("+") if name)
    if variants and Path(head).exists():
        return VersionPlace(Path(head), "", variants)
    cuts = [i for i, c in enumerate(head) if c == "@" and 0 < i < len(head) - 1]
    if not cuts:
        raise RunError(f"{text}: there is no such file or folder")
    cut = next((i for i in cuts if Path(head[:i]).exists()), cuts[0])
    return VersionPlace(Path(head[:cut]), head[cut + 1 :], variants)


@contextmanager
def open_side(text: str, overlay: CaseOverlay) -> Iterator[Side]:
    """Read one side.

    Args:
        text: `PATH`, `PATH@REVISION`, `PATH+VARIANT`, or `PATH@REVISION+VARIANT`.
        overlay: Overlay applied on top of the variants.

    Raises:
        SpecError: If it is not YAML that the language accepts.
        RunError: If it does not exist.
    """
    place = parse_place(text)
    overlay = CaseOverlay(place.variants) + overlay
    if not place.revision:
        yield _read_side(place.path, text, overlay)
        return
    with tempfile.TemporaryDirectory(prefix="text2sim-") as folder:
        repository = find_commit(place.path, place.revision)
        yield _read_side(extract(repository, place.path, Path(folder)), text, overlay)


def _read_side(path: Path, label: str, overlay: CaseOverlay) -> Side:
    """Read an existing file or folder; see `open_side`."""
    file = path / CASE_FILE if path.is_dir() else path
    run = path if path.is_dir() and (path / "run.json").is_file() else None
    if run is not None and (run / EXPANDED).is_file():
        file = run / EXPANDED
    try:
        side = text_side(read_source(file), label, file, overlay)
    except SpecError as error:
        raise SpecError(_relabelled(error.problems, file, label)) from None
    side.run = run
    return side


def text_side(source: Source, label: str, file: Path, overlay: CaseOverlay = NOTHING) -> Side:
    """Return a text as a side; see `open_side`.

    Args:
        source: The text.
        label: Its name in messages.
        file: Path of the case, which files in it are relative to.
        overlay: Overlay applied to the case.

    Raises:
        SpecError: If the text is not YAML, or the overlay does not fit it.
    """
    written = parse_document(source)
    data = written.data
    try:
        if isinstance(data, dict):
            document = migrate(written)[0]
            data = (overlaid(document, file.parent, overlay) if overlay else document).data
        loaded = load_text(source.text, file, overlay)
    except SpecError as error:
        if overlay:
            raise
        return Side(label, written.data, data, None, _relabelled(error.problems, file, label))
    return Side(label, written.data, data, loaded)


def _relabelled(problems: list[Problem], file: Path, label: str) -> list[Problem]:
    return [replace(problem, file=label) if problem.file == str(file) else problem for problem in problems]
