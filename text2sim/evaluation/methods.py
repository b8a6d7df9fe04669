"""Methods that answer the prompts of a suite: text2sim, the bare coding agent, and any command line."""

import json
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from time import monotonic
from types import MappingProxyType
from typing import Any, Literal

from text2sim import __version__
from text2sim.agents.models.endpoint import in_subfolder
from text2sim.card_library.library import VARIABLE
from text2sim.evaluation.method_folder import (
    CASE,
    PROMPT_FILE,
    RESULT,
    CaseResult,
    MethodRecord,
    discover_result,
    read_made,
    resources_of,
    write_method,
    write_result,
)
from text2sim.evaluation.suite import Prompt, Suite
from text2sim.recording.record import RunRecord
from text2sim.recording.run_files import read_json
from text2sim.runtime.child import kill_group
from text2sim.runtime.stop import Stop
from text2sim.service.exits import BUG
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.whole_files import write_atomically, write_json

ARMS = ("text2sim:with-cards", "text2sim:no-cards", "agent:with-cards", "agent:no-cards")
METHOD_FORMS = f"{', '.join(ARMS)}, or NAME=COMMAND"
CLOCK_FILE = "clock.json"
Report = Callable[[str], None]


@dataclass(frozen=True)
class Method:
    """A method that answers prompts."""

    name: str
    kind: Literal["text2sim", "agent", "command"]
    cards: bool = True
    library: str = ""
    """Folder of additional cards for `text2sim`; empty for that of the environment."""
    command: tuple[str, ...] = ()
    """Arguments of the command, with the placeholders `{prompt}`, `{prompt_file}` and `{folder}`."""


@dataclass(frozen=True)
class Allowance:
    """Budget of a method for each prompt."""

    attempts: int = 30
    tokens: int | None = None
    cost: float | None = None
    minutes: float | None = None
    sim_timeout: float = 3600.0
    film: Literal["draft", "final", "none"] = "draft"
    film_minutes: float = 10.0
    """Largest wall time for the path-traced film of text2sim [min]."""


def parse_method(word: str) -> Method:
    """Parse a method from the command line.

    Raises:
        RunError: If it is unknown.
    """
    name, equals, command = word.partition("=")
    if equals:
        try:
            words = tuple(shlex.split(command))
            MethodRecord(name=name, suite="")
        except ValueError:
            words = ()
        if not words:
            raise RunError(
                f"`{word[:80]}` is not a method: NAME=COMMAND, with letters, digits, `-`, `_`, `.` in the name"
            )
        return Method(name, "command", command=words)
    kind, _, cards = word.partition(":")
    if kind not in ("text2sim", "agent") or cards not in ("", "with-cards", "no-cards"):
        raise RunError(f"`{word[:80]}` is not a method; there are {METHOD_FORMS}")
    return Method(f"{kind}-{cards or 'with-cards'}", "agent" if kind == "agent" else "text2sim", cards != "no-cards")


def run_method(
    suite: Suite, prompts: Mapping[str, Prompt], method: Method, models: Sequence[str], allowance: Allowance,
    out: Path, tell: Report,
) -> Path:  # fmt: skip
    """Have a method answer prompts; existing answers are kept.

    Args:
        suite: The suite.
        prompts: The prompts to answer, by id.
        method: The method.
        models: `[ROLE=]MODEL`, for text2sim and the agent; a mailbox gets a folder for each prompt.
        allowance: Budget for each prompt.
        out: Parent of the method folder.
        tell: Called with one line for each prompt.

    Returns:
        The method folder.
    """
    folder = out / method.name
    made_by = {
        "method": asdict(method),
        "models": list(models),
        "allowance": asdict(allowance),
        "text2sim": __version__,
    }
    write_method(
        folder, MethodRecord(name=method.name, suite=suite.name, digest=suite.prompts_digest(), made_by=made_by)
    )
    for name, prompt in prompts.items():
        prompt_folder = folder / name
        if (prompt_folder / RESULT).is_file():
            tell(f"{name}, {method.name}: answered before")
            continue
        prompt_folder.mkdir(parents=True, exist_ok=True)
        write_atomically(prompt_folder / PROMPT_FILE, prompt.prompt + "\n")
        answer = {"text2sim": _text2sim, "agent": _agent, "command": _command}[method.kind]
        before, start = _time_used(prompt_folder), monotonic()
        try:
            result = answer(
                prompt_folder,
                name,
                prompt,
                method,
                [_model_for_prompt(model, method, name) for model in models],
                allowance,
            )
        finally:
            wall = before + monotonic() - start
            write_json(prompt_folder / CLOCK_FILE, {"wall_s": wall})  # a kill must not refund the time used
        if result.wall_s is None:
            result = result.model_copy(update={"wall_s": wall})
        write_result(prompt_folder, result)
        tell(f"{name}, {method.name}: {result.status}{f': {result.why}' if result.why else ''}")
    return folder


def _time_used(place: Path) -> float:
    found = read_json(place / CLOCK_FILE)
    return float(found["wall_s"]) if isinstance(found, dict) else 0.0


def _model_for_prompt(model: str, method: Method, prompt: str) -> str:
    """Return the name of a model; a mailbox gets a separate folder for each method and prompt."""
    role, equals, name = model.partition("=")
    prefix, name = (f"{role}=", name) if equals and role.isidentifier() else ("", model)
    return prefix + in_subfolder(name, f"{method.name}/{prompt}")


def _text2sim(
    place: Path, name: str, prompt: Prompt, method: Method, models: Sequence[str], allowance: Allowance
) -> CaseResult:
    """Run `text2sim generate` and then its film, each as a separate process."""
    case = place / "case"
    arguments = ["generate", "--out", str(case), "--json", "--film", "none"]
    arguments += (
        ["--resume"] if (case / "generation" / "request.json").is_file() else ["--file", str(place / PROMPT_FILE)]
    )
    arguments += [argument for model in models for argument in ("--model", model)]
    arguments += ["--attempts", str(allowance.attempts), "--sim-timeout", str(allowance.sim_timeout)]
    for option in ("tokens", "cost", "minutes"):
        if (value := getattr(allowance, option)) is not None:
            arguments += [f"--{option}", str(value)]
    cards = {VARIABLE: method.library} if method.library else {}
    code, output = _run_text2sim(arguments + ([] if method.cards else ["--no-cards"]), place / "generate.log", cards)
    if "account" not in output:
        why = f"text2sim generate: {output.get('error') or output.get('problems') or f'exit code {code}'}"[:4000]
        if code == BUG:
            return CaseResult(prompt=name, status="failed", why=why)
        raise RunError(f"{name}: {why}")  # the cause is not this prompt, so the next one would fail, too
    run = Path(output["run"]) if output.get("run") else None
    film, seconds = _film(run, allowance, place)
    records = [RunRecord.read(path.parent) for path in case.glob("runs/*/run.json")]
    return CaseResult(
        prompt=name,
        status="finished" if output.get("case") else "failed",
        accepted=output["state"] == "accepted",
        why="" if output["state"] == "accepted" else _why_not_accepted(output),
        film=_relative(film, place),
        program=_relative(case / CASE, place),
        run=_relative(run, place),
        roles={role: resources_of(spent) for role, spent in output["account"]["roles"].items()},
        attempts=len((read_json(case / "generation" / "run.json") or {}).get("attempts", [])),
        simulation_s=sum(record.wall for record in records if record is not None) + seconds,
    )


def _why_not_accepted(output: Mapping[str, Any]) -> str:
    """The outcome of a loop that was not accepted, or in part only, and what is missing."""
    return "; ".join([f"{output['state']}: {output.get('why', '')}", *output.get("unresolved", ())])[:4000]


def _film(run: Path | None, allowance: Allowance, place: Path) -> tuple[Path | None, float]:
    """Return the film of a run and its rendering time [s]: path traced if requested and possible, else the preview."""
    if run is None:
        return None, 0.0
    start = monotonic()
    if allowance.film != "none":
        arguments = [
            "render",
            str(run),
            "--quality",
            allowance.film,
            "--minutes",
            str(allowance.film_minutes),
            "--json",
        ]
        files = _run_text2sim(arguments, place / "film.log")[1].get("files") or []
        traced = [Path(file) for file in files if file.endswith(".mp4")]
        if traced:
            return traced[0], monotonic() - start
    preview = run / "video.mp4"
    return (preview if preview.is_file() else None), monotonic() - start


def _agent(
    place: Path, name: str, prompt: Prompt, method: Method, models: Sequence[str], allowance: Allowance
) -> CaseResult:
    from text2sim.evaluation.bare_agent import BareAgent

    model = models[-1] if models else ""
    return BareAgent(place, model, allowance, method.cards, _time_used(place) / 60).answer(name, prompt.prompt)


def _command(
    place: Path, name: str, prompt: Prompt, method: Method, models: Sequence[str], allowance: Allowance
) -> CaseResult:
    """Run the user's command in the user's environment; its output goes to `log.txt`."""
    folder = place.resolve()
    placeholders = {"{prompt}": prompt.prompt, "{prompt_file}": str(folder / PROMPT_FILE), "{folder}": str(folder)}
    arguments = [_fill_placeholders(argument, placeholders) for argument in method.command]
    variables = {"TEXT2SIM_PROMPT": prompt.prompt, "TEXT2SIM_FOLDER": str(folder)}
    limit = None if allowance.minutes is None else 60 * allowance.minutes
    why = ""
    try:
        code = _run_command(arguments, place / "log.txt", os.environ | variables, limit)
        why = f"it ended with exit code {code}" if code else ""
    except subprocess.TimeoutExpired:
        why = f"it took longer than {allowance.minutes:g} minutes"
    except OSError as error:
        why = f"it cannot be run: {error.strerror or error}"
    if (place / RESULT).is_file():  # the command wrote its own result
        own_result = read_made(place)
        problems = "; ".join(problem.message for problem in own_result.problems)
        result = own_result.result.model_copy(update={"prompt": name, "why": own_result.result.why or problems or why})
        return result if not problems else result.model_copy(update={"status": "unknown"})
    found = discover_result(place)
    left_files = found.film or found.program or found.run
    return found.model_copy(
        update={
            "prompt": name,
            "status": "finished" if left_files else "failed",
            "why": why or ("" if left_files else "it left no files"),
        }
    )


def _fill_placeholders(argument: str, values: Mapping[str, str]) -> str:
    """Fill in placeholders once, so that those within a prompt remain text."""
    return re.sub("|".join(map(re.escape, values)), lambda match: values[match[0]], argument)


def _run_text2sim(
    arguments: Sequence[str], log: Path, variables: Mapping[str, str] = MappingProxyType({})
) -> tuple[int, dict[str, Any]]:
    """Return the exit code of a text2sim command and the JSON document that it prints; other output goes to a log.

    The command ends with this process, also when that is asked to stop by SIGTERM.
    """
    with log.open("ab") as sink, Stop():
        command = [sys.executable, "-P", "-m", "text2sim", *arguments]
        done = subprocess.run(
            command, stdout=subprocess.PIPE, stderr=sink, text=True, check=False, env=os.environ | variables
        )
    try:
        document = json.loads(done.stdout)
    except ValueError:
        document = {}
    return done.returncode, document if isinstance(document, dict) else {}


def _run_command(arguments: Sequence[str], log: Path, environment: Mapping[str, str], limit: float | None) -> int:
    with log.open("ab") as sink:
        process = subprocess.Popen(
            arguments, stdin=subprocess.DEVNULL, stdout=sink, stderr=sink, env=dict(environment), start_new_session=True
        )
        try:
            return process.wait(limit)
        finally:
            kill_group(process)
            with suppress(subprocess.TimeoutExpired):
                process.wait(5)


def _relative(path: Path | None, place: Path) -> str | None:
    if path is None or not path.exists():
        return None
    return str(path.resolve().relative_to(place.resolve()))
