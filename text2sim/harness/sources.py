"""Digests of our own code, since its results change between releases while the version number does not."""

from collections.abc import Iterable
from hashlib import sha256
from pathlib import Path

from text2sim import drawing, evidence, legibility, recording, templates
from text2sim.compiler.emit import FILM_TEMPLATES

TEMPLATES = Path(str(templates.__file__)).parent


def simulation_code() -> str:
    """Return the digest of the templates that a simulation depends on: all except those that only film."""
    return _digest(TEMPLATES, (path for path in _sources(TEMPLATES) if path.name not in FILM_TEMPLATES))


def film_code() -> str:
    """Return the digest of the templates that only film what was recorded."""
    return _digest(TEMPLATES, (TEMPLATES / name for name in FILM_TEMPLATES))


def judge_code() -> str:
    """Return the digest of the code that makes evidence of a recording."""
    folders = [Path(str(package.__file__)).parent for package in (evidence, recording, legibility, drawing)]
    return _digest(folders[0].parent, (path for folder in folders for path in _sources(folder)))


def package_code() -> str:
    """Return the digest of all our code."""
    folder = TEMPLATES.parent
    return _digest(folder, [path for path in folder.rglob("*") if path.suffix in (".py", ".j2", ".yaml")])


def _sources(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.suffix in (".py", ".j2")]


def _digest(root: Path, paths: Iterable[Path]) -> str:
    digest = sha256()
    for path in sorted(paths):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]
