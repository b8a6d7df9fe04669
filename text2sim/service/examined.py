"""Reading and checking of cases, with all their problems."""

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from text2sim.service import exits
from text2sim.service.phrases import display_path, user_message
from text2sim.spec_schema.errors import Problem, SpecError, Text2SimError
from text2sim.spec_schema.reuse.overlay import NOTHING, CaseOverlay
from text2sim.spec_schema.text.source import read_source

if TYPE_CHECKING:
    from text2sim.compiler.build import Resolution
    from text2sim.compiler.plan import Plan
    from text2sim.lint import Waived
    from text2sim.spec_schema.loaded import LoadedCase

CASE_FILE = "case.yaml"
SKIPPED = frozenset({"runs", "program", "assets", "__pycache__", "node_modules"})
"""Folders that are not searched for cases: they have what was made from cases."""
MAX_DEPTH = 6


@dataclass
class Examined:
    """A case that was read, with all its problems."""

    path: Path
    overlay: CaseOverlay = NOTHING
    """Changes to the case."""
    loaded: "LoadedCase | None" = None
    resolution: "Resolution | None" = None
    """Only of a case that was resolved and not linted, as it is large."""
    plan: "Plan | None" = None
    problems: list[Problem] = field(default_factory=list)
    waived: "list[Waived]" = field(default_factory=list)
    """Findings of the lint that the case waives."""
    held: list[str] = field(default_factory=list)
    """Expectations that would hold if nothing moved."""
    seconds: float = 0.0
    """Estimated wall time of a run on two idle cores; 0 if unknown."""
    sources: dict[str, str] = field(default_factory=dict)
    """Text by file name, for excerpts."""
    failure: str = ""
    """The error, if it is not a problem of some line of the case."""
    exit: int = exits.OK

    @property
    def ok(self) -> bool:
        """Whether it can run."""
        return self.exit == exits.OK

    @property
    def name(self) -> str:
        """Name of the case, or of its folder if it could not be read."""
        if self.loaded is not None:
            return self.loaded.case.name
        return self.path.parent.name if self.path.name == CASE_FILE else self.path.stem

    @property
    def title(self) -> str:
        """Its file, and the changes to it."""
        return display_path(self.path) + (f" ({', '.join(self.overlay.words)})" if self.overlay else "")

    def as_dict(self) -> dict[str, Any]:
        """Return the document that `--json` prints."""
        document: dict[str, Any] = {
            "case": self.name,
            "file": str(self.path),
            "variants": list(self.overlay.variants),
            "sets": list(self.overlay.sets),
            "ok": self.ok,
            "problems": [problem.as_dict() for problem in self.problems],
            "waived": [waived.as_dict() for waived in self.waived],
        }
        if self.failure:
            document["error"] = self.failure
        if self.plan is not None:
            document["notes"] = list(self.plan.notes)
            document["true_at_start"] = self.held
            document["seconds"] = round(self.seconds, 1)
        return document

    def resolve(self) -> None:
        """Resolve the case that was read, without the lint.

        Raises:
            SpecError: with every problem found, if there is an error among them.
        """
        from text2sim.compiler.build import resolve_case

        assert self.loaded is not None
        self.resolution = resolve_case(self.loaded)
        self.plan, self.problems = self.resolution.plan, list(self.resolution.plan.warnings)
        self.collect_sources()

    def plan_and_lint(self) -> None:
        """Resolve the case that was read, and lint it.

        Raises:
            SpecError: with every problem found, if there is an error among them.
        """
        from text2sim.compiler.build import resolve_case
        from text2sim.lint import lint_case

        assert self.loaded is not None
        resolution = resolve_case(self.loaded)
        report = lint_case(resolution)
        self.waived, self.held, self.seconds = report.waived, report.held, report.seconds
        if not report.ok:
            raise SpecError(report.problems)
        self.plan, self.problems = resolution.plan, report.problems
        self.collect_sources()

    def findings(self) -> list[dict[str, Any]]:
        """Return the findings of the lint in the format of a run record."""
        found: list[tuple[Problem, str | None]] = [(problem, None) for problem in self.problems]
        found += [(waived.problem, waived.reason) for waived in self.waived]
        return [{"rule": p.rule, "path": p.path, "message": p.message, "reason": reason} for p, reason in found]

    def blame(self, error: Exception) -> None:
        """Record an error that the author of the case, or the owner of the machine, can fix."""
        self.exit = exits.exit_of_error(error)
        self.problems = error.problems if isinstance(error, SpecError) else []
        self.failure = "" if self.problems else user_message(error).removeprefix(f"{self.path}: ")
        self.collect_sources()

    def collect_sources(self) -> None:
        """Read the files that the problems are in."""
        texts = {file: self._text(file) for file in {problem.file for problem in self.problems}}
        self.sources = {file: text for file, text in texts.items() if text}

    def _text(self, file: str) -> str:
        if self.loaded is not None and file == self.loaded.source.file:
            return self.loaded.source.text
        if file in ("--set", "--variant"):
            return "\n".join(self.overlay.sets if file == "--set" else self.overlay.variants)
        try:
            return read_source(Path(file)).text
        except SpecError:
            return ""


def examine(
    path: Path, *, to: Literal["loaded", "resolved", "linted"] = "linted", overlay: CaseOverlay = NOTHING
) -> Examined:
    """Read a case, and resolve and lint it as far as `to` says; mistakes of its author are put into `problems`.

    Args:
        path: File or folder of the case.
        to: The last of these steps.
        overlay: Changes to the case.
    """
    from text2sim.spec_schema.load import load_case

    found = Examined(case_file(path), overlay)
    try:
        found.loaded = load_case(path, overlay)
        found.path = found.loaded.path
        if to == "resolved":
            found.resolve()
        elif to == "linted":
            found.plan_and_lint()
    except (Text2SimError, OSError) as error:
        found.blame(error)
    return found


def case_file(path: Path) -> Path:
    """Return the file of a case: the path itself, or `case.yaml` in it."""
    return path / CASE_FILE if path.is_dir() else path


def find_cases(paths: Iterable[Path]) -> list[Path]:
    """Return the files or folders of cases; a folder that is not a case stands for all cases below it."""
    found: dict[Path, None] = {}
    for path in paths:
        below = [path] if not path.is_dir() or (path / CASE_FILE).is_file() else list(_folders_below(path, MAX_DEPTH))
        # A folder without cases is kept, so that reading it reports that.
        found |= dict.fromkeys(below or [path])
    return list(found)


def _folders_below(folder: Path, depth: int) -> Iterable[Path]:
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except OSError:
        return
    for entry in entries:
        if entry.name.startswith(".") or entry.name in SKIPPED or not entry.is_dir(follow_symlinks=False):
            continue
        path = Path(entry.path)
        if (path / CASE_FILE).is_file():
            yield path
        elif depth > 0:
            yield from _folders_below(path, depth - 1)
