"""Search for prefabs in the case, its folder, the user's folder, and among the built-in ones."""

import os
import re
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any

from pydantic import ValidationError

from text2sim.spec_schema.errors import Problem, SpecError, nearest, there_are
from text2sim.spec_schema.models.base import Name
from text2sim.spec_schema.models.prefab_models import Prefab, PrefabFile
from text2sim.spec_schema.reuse.definition_check import check_definition
from text2sim.spec_schema.reuse.migration import migrate
from text2sim.spec_schema.reuse.overlay_check import check_names
from text2sim.spec_schema.reuse.trees import LocatedValue
from text2sim.spec_schema.text.document import Document, Path, parse_document, value_at
from text2sim.spec_schema.text.source import MAX_BYTES, Source, read_source
from text2sim.spec_schema.vocabulary.diagnosis import diagnose
from text2sim.spec_schema.vocabulary.slot_path import PrefabInterface
from text2sim.spec_schema.vocabulary.words import bounds_of, slot_of

FOLDER = "prefabs"
VARIABLE = "TEXT2SIM_PREFABS"
"""Environment variable with another folder of prefabs."""
BUILT_IN = FilePath(__file__).resolve().parents[2] / FOLDER
MAX_LISTED = 1000

_NAME = re.compile(bounds_of(slot_of(Name))["pattern"])


@dataclass(frozen=True, eq=False)
class Definition:
    """A valid prefab."""

    name: str
    place: str
    """Its file, as messages name it."""
    document: Document
    root: Path
    """Its path in the document."""
    model: Prefab

    @property
    def bodies(self) -> dict[str | None, LocatedValue]:
        """Its bodies by name of the part; a single one has the name None."""
        tree = self._tree
        if self.model.body is not None:
            return {None: tree.child("body")}
        bodies = tree.child("bodies")
        return {name: bodies.child(name) for name in bodies.data}

    def default(self, param: str) -> LocatedValue | None:
        """Return the default of a parameter, or None."""
        if self.model.params[param].default is None:
            return None
        return self._tree.at(("params", param, "default"))

    @property
    def _tree(self) -> LocatedValue:
        return LocatedValue(self.document.data, self.document.root).at(self.root)


class MissingPrefab(Exception):
    """A prefab that does not exist or is invalid.

    Attributes:
        hint: The nearest name of a prefab.
        problems: The problems of the prefab, if it is invalid.
    """

    def __init__(self, message: str, hint: str | None = None, problems: tuple[Problem, ...] = ()) -> None:
        super().__init__(message)
        self.hint = hint
        self.problems = problems


class PrefabLibrary:
    """The prefabs that a case can use."""

    def __init__(self, document: Document, folder: FilePath) -> None:
        self.document = document
        self.folder = folder
        self._found: dict[str, Definition | MissingPrefab] = {}
        self._read_so_far = 0

    def find(self, name: str) -> Definition:
        """Return a prefab.

        Raises:
            MissingPrefab: If there is none with that name, or it is invalid.
        """
        if name not in self._found:
            try:
                self._found[name] = self._look_up(name)
            except MissingPrefab as missing:
                self._found[name] = missing
        found = self._found[name]
        if isinstance(found, MissingPrefab):
            raise found
        return found

    def interface(self, use: Any, depth: int = 8) -> PrefabInterface:
        """Return what can be changed of a prefab; an empty interface if it does not exist."""
        try:
            found = self.find(use) if isinstance(use, str) else None
        except MissingPrefab:
            return PrefabInterface()
        if found is None:
            return PrefabInterface()
        if found.model.bodies is not None:
            return PrefabInterface(parts=tuple(found.model.bodies))
        body = found.model.body or {}
        if "use" in body:
            return self.interface(body["use"], depth - 1) if depth else PrefabInterface()
        kind = body.get("kind")
        return PrefabInterface(kind if isinstance(kind, str) else None)

    def names(self) -> list[str]:
        """Return the names of all available prefabs."""
        names = list(check_names(self.document, "prefabs", []))
        for folder, label in self._folders():
            try:
                if label == FOLDER and not folder.resolve().is_relative_to(self.folder.resolve()):
                    continue
                with os.scandir(folder) as entries:
                    files = [entry.name for _, entry in zip(range(MAX_LISTED), entries, strict=False)]
            except (OSError, RuntimeError):
                continue
            names += sorted(file.removesuffix(".yaml") for file in files if file.endswith(".yaml"))
        return list(dict.fromkeys(name for name in names if _NAME.fullmatch(name)))

    def own_problems(self) -> list[Problem]:
        """Return the problems of the prefabs in the case itself, used or not."""
        problems: list[Problem] = []
        for name in check_names(self.document, "prefabs", problems):
            try:
                self.find(name)
            except MissingPrefab as missing:
                problems += missing.problems
        return problems

    def _look_up(self, name: str) -> Definition:
        section = self.document.data.get("prefabs")
        if isinstance(section, dict) and name in section:
            file = FilePath(self.document.source.file).name
            return _define(name, file, self.document, ("prefabs", name), Prefab)
        if _NAME.fullmatch(name):
            for folder, label in self._folders():
                path = folder / f"{name}.yaml"
                if path.is_symlink() or path.exists():
                    return self._read(name, path, label)
        known = self.names()
        raise MissingPrefab(f"there is no prefab `{name[:60]}`{there_are(known, None)}", nearest(name, known))

    def _folders(self) -> list[tuple[FilePath, str]]:
        """Return the folders with prefabs, and their names in messages."""
        found = [(self.folder / FOLDER, FOLDER)]
        more = os.environ.get(VARIABLE)
        if more:
            found.append((FilePath(more), FilePath(more).name))
        return [*found, (BUILT_IN, f"text2sim/{FOLDER}")]

    def _read(self, name: str, path: FilePath, label: str) -> Definition:
        place = f"{label}/{path.name}"
        home = self.folder if label == FOLDER else path.parent
        try:
            inside = path.resolve().is_relative_to(home.resolve())
        except (OSError, RuntimeError):
            inside = False
        if not inside:
            raise MissingPrefab(f"the prefab `{name}` is a link that leads out of its folder ({place})")
        try:
            source = read_source(path)
            self._read_so_far += len(source.text)
            if self._read_so_far > MAX_BYTES:
                raise MissingPrefab(
                    f"with `{name}`, the prefabs are larger than {MAX_BYTES // 1_000_000} MB in all ({place})"
                )
            document = _parse(source)
        except SpecError as error:
            raise MissingPrefab(f"the prefab `{name}` is broken", problems=tuple(error.problems)) from None
        return _define(name, place, document, (), PrefabFile)


def prefab_problems(source: Source) -> list[Problem]:
    """Return what is wrong with the text of a prefab in a file of its own."""
    try:
        document = _parse(source)
        name = document.data.get("prefab")
        _define(name if isinstance(name, str) else "", source.file, document, (), PrefabFile)
    except SpecError as error:
        return error.problems
    except MissingPrefab as missing:
        return list(missing.problems)
    return []


def _parse(source: Source) -> Document:
    """Return a prefab file, in the latest version of the language."""
    document = parse_document(source)
    if not isinstance(document.data, dict):
        message = "a prefab is a mapping with the keys text2sim, prefab, doc, params, body"
        raise SpecError([document.problem((), message, rule="type")])
    document, problems = migrate(document)
    if problems:
        raise SpecError(problems)
    return document


def _define(name: str, place: str, document: Document, root: Path, model: type[Prefab]) -> Definition:
    """Return a prefab after checks."""
    data = value_at(document.data, root)
    problems: list[Problem] = []
    found: Prefab | None = None
    if not isinstance(data, dict):
        problems.append(document.problem(root, "a prefab is a mapping with the keys doc, params, body", rule="type"))
    else:
        try:
            found = model.model_validate(data, by_alias=True, by_name=False)
        except ValidationError as error:
            problems += diagnose(document, error, model, data, root)
    if isinstance(found, PrefabFile) and found.prefab != name:
        message = f"the file is {name}.yaml, but this is the prefab `{found.prefab}`; give both the same name"
        problems.append(document.problem(("prefab",), message, rule="prefab"))
    if found is not None:
        problems += check_definition(document, root, found)
    if problems or found is None:
        raise MissingPrefab(f"the prefab `{name}` is invalid", problems=tuple(problems))
    return Definition(name, place, document, root, found)


def named(problems: tuple[Problem, ...], user: str) -> list[Problem]:
    """Return the problems of a prefab file, with the name of its user."""
    return [replace(problem, message=f"{problem.message} (used by {user})") for problem in problems]
