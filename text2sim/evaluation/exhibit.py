"""Exhibits for judges: program, records and computed facts of a result, and frames of its film."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from pydantic import Field

from text2sim.agents.conversation import Conversation, RoleFailed, Wrong, typed_parser
from text2sim.agents.facts import claim_faults, compute_facts
from text2sim.agents.models.exchange import ModelError, StoppedError
from text2sim.agents.models.files import UnfitFileError, read_plain
from text2sim.agents.replies import Answer, Claim
from text2sim.agents.roles import quoted
from text2sim.agents.run_summary import evidence_text
from text2sim.evaluation.film_frames import FilmFrames, film_frames
from text2sim.evaluation.keyframes import Motion, motion_of
from text2sim.evaluation.method_folder import PromptResult
from text2sim.evaluation.prompt_templates import render_prompt
from text2sim.evaluation.suite import Prompt
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.recording.run_files import read_evidence, read_json
from text2sim.spec_schema.errors import RunError, SpecError, Text2SimError
from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.loaded import LoadedCase

LONGEST_PROGRAM, LONGEST_LOG = 80_000, 6_000
"""Characters of a program, and of the end of a log, that a judge reads."""
LARGEST_FILE = 20_000_000
MAX_FACTS = 12
"""Largest number of requirements that facts are computed for."""


class FactClaims(Answer):
    """Facts that can be computed from a run, by requirement."""

    facts: Annotated[dict[str, list[Claim]], Field(max_length=MAX_FACTS)] = {}


@dataclass
class ResultExhibit:
    """Material about a result."""

    program: str = ""
    records: str = ""
    frames: FilmFrames | None = None
    motion: Motion | None = None
    facts: list[str] = field(default_factory=list)
    """Sentences; one about a requirement begins with its name."""
    missing: list[str] = field(default_factory=list)
    """Files that are missing or unreadable, and why."""
    notes: list[str] = field(default_factory=list)
    """Errors of text2sim itself, which judges do not see."""
    loaded: LoadedCase | None = None

    def hide(self, folder: Path) -> None:
        """Remove a folder's path from all texts, because it contains the name of the method."""
        for place in map(str, (folder.resolve(), folder)):
            self.program, self.records = (text.replace(place, ".") for text in (self.program, self.records))
            self.missing, self.facts = (
                [row.replace(place, ".") for row in rows] for rows in (self.missing, self.facts)
            )


def exhibit_of(made: PromptResult) -> ResultExhibit:
    """Collect the material of a result; `missing` lists what cannot be read."""
    shown = ResultExhibit(missing=[problem.message for problem in made.problems])
    film, program, run, log = (made.path(name) for name in ("film", "program", "run", "log"))
    if film is None:
        shown.missing.append("there is no film")
    else:
        try:
            shown.frames = film_frames(film)
        except RunError as error:
            shown.missing.append(str(error))
    shown.program = _text(shown, program, LONGEST_PROGRAM) if program else ""
    if run is not None:
        _read_run(shown, run, program)
    elif log is not None:
        shown.records = _text(shown, log, LONGEST_LOG, end=True)
    shown.hide(made.folder)
    return shown


def bind_facts(chat: Callable[[], Conversation], prompt: Prompt, shown: ResultExhibit, made: PromptResult) -> None:
    """Have a model bind requirements to computable facts, and compute these.

    The model is asked once for each result, and all judges read the same facts. There are none without a case or
    without a usable answer.

    Args:
        chat: Opens a conversation with the models.
        prompt: The prompt.
        shown: What judges see; facts and notes are added to it.
        made: The result.

    Raises:
        StoppedError: If the user stopped it.
    """
    run = made.path("run")
    if shown.loaded is None or run is None or prompt.requirements is None:
        return
    names, bodies = list(prompt.requirements.rows()), [*shown.loaded.case.bodies, *shown.loaded.case.scene.statics]

    def check(answer: FactClaims) -> None:
        if wrong := claim_faults(answer.facts, names, bodies):
            raise Wrong(wrong)

    question = render_prompt("check_ask", prompt=prompt, program=shown.program)
    try:
        answer: FactClaims = chat().ask("checker", render_prompt("check"), question, typed_parser(FactClaims, check))
        for fact in compute_facts(answer.facts, shown.loaded, run):
            (shown.facts if fact.ok is not None else shown.notes).append(f"{fact.requirement}: {fact}")
    except StoppedError:
        raise
    except (RoleFailed, ModelError) as error:
        shown.notes.append(f"no facts about requirements: {error}")
    shown.hide(made.folder)


def _read_run(shown: ResultExhibit, run: Path, program: Path | None) -> None:
    """Read as much of a run folder as possible: it may be another tool's."""
    try:
        record = read_json(run / "run.json")
        if not isinstance(record, dict):
            raise RunError("its run folder has no run.json")
        shown.records = quoted(evidence_text(run, read_evidence(run), record, ()))
        expanded = load_case(run / "expanded.yaml")
        # Facts about looks need the assets in the case folder.
        shown.loaded = load_case(program) if program is not None and program.suffix == ".yaml" else expanded
        shown.motion = motion_of(RecordedCase.load(run, expanded.case))
        shown.facts += shown.motion.rows()
    except SpecError as error:
        shown.missing.append(f"the case of its run cannot be read: {error.problems[0].message}")
    except (Text2SimError, OSError, ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        shown.missing.append(f"its run folder cannot be read: {str(error).splitlines()[0] if str(error) else error!r}")


def _text(shown: ResultExhibit, path: Path, longest: int, *, end: bool = False) -> str:
    try:
        text = quoted(read_plain(path, LARGEST_FILE))
    except (UnfitFileError, OSError) as error:
        shown.missing.append(f"{path.name} cannot be read: {error}")
        return ""
    if len(text) <= longest:
        return text
    return f"[…]\n{text[-longest:]}" if end else f"{text[:longest]}\n[… {len(text) - longest:,} characters more]"
