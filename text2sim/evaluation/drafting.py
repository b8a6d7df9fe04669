"""Drafting of requirements by a model that sees the prompt alone, and freezing of suites."""

from pathlib import Path
from typing import Any

from text2sim.agents.conversation import Conversation, typed_parser
from text2sim.agents.journal import Journal
from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.roles import quoted
from text2sim.agents.yaml_text import yaml_text
from text2sim.evaluation.judging import judge_endpoint
from text2sim.evaluation.prompt_templates import render_prompt
from text2sim.evaluation.suite import CATEGORIES, Prohibition, Prompt, Requirements, Suite, check_complete
from text2sim.spec_schema.models.base import Model, Name
from text2sim.spec_schema.text.document import Document
from text2sim.spec_schema.whole_files import write_atomically


class RequirementDraft(Model):
    """Requirements that a model drafted from a prompt."""

    requirements: Requirements
    prohibitions: dict[Name, Prohibition] = {}


def draft_requirements(chat: Conversation, prompt: Prompt) -> Prompt:
    """Return a prompt with requirements; existing ones are kept.

    Raises:
        RoleFailed: If no answer is usable.
    """
    if prompt.requirements is not None:
        return prompt
    question = f"<prompt>\n{quoted(prompt.prompt)}\n</prompt>\n\nTake it apart."
    answer: RequirementDraft = chat.ask("drafter", render_prompt("draft"), question, typed_parser(RequirementDraft))
    return prompt.model_copy(update={"requirements": answer.requirements, "prohibitions": answer.prohibitions})


def write_frozen(suite: Suite, path: Path) -> None:
    """Write a suite with the digest of its prompts and requirements."""
    write_atomically(path, suite_text(suite.model_copy(update={"frozen": suite.digest()})))


def suite_text(suite: Suite) -> str:
    """Return a suite as YAML, prompt by prompt."""
    head: dict[str, Any] = {"text2sim_suite": 1, "name": suite.name}
    if suite.frozen is not None:
        head["frozen"] = suite.frozen
    rows = [yaml_text(head), "prompts:"]
    for name, prompt in suite.prompts.items():
        data = prompt.model_dump(mode="json", exclude_none=True)
        needs = data.pop("requirements", None)
        prohibitions = data.pop("prohibitions")
        rows += ["", f"  {name}:", yaml_text(data, 4)]
        if needs is not None:
            rows.append("    requirements:")
            rows += [f"      {kind}:\n{_yaml_rows(needs[kind], 8)}" for kind in CATEGORIES]
        if prohibitions:
            rows.append(f"    prohibitions:\n{_yaml_rows(prohibitions, 6)}")
    return "\n".join(rows) + "\n"


def _yaml_rows(rows: dict[str, Any], indent: int) -> str:
    """One line of YAML per entry."""
    return "\n".join(yaml_text({name: row}, indent) for name, row in rows.items())


def draft_missing(suite: Suite, document: Document, model: str, folder: Path) -> Suite:
    """Return a suite in which every prompt has requirements.

    Args:
        suite: The suite.
        document: Its source document.
        model: The drafting model; needed only if requirements are missing.
        folder: Folder for the log of calls.

    Raises:
        SpecError: If requirements are missing and no model is given.
    """
    if not model:
        check_complete(suite, document)
        return suite
    prompts = {}
    for name, prompt in suite.prompts.items():
        log, journal = CallLog(folder / name), Journal(folder / name / "journal.jsonl")
        chat = Conversation({"": judge_endpoint(model, name)}, log, Account(), Budget(), journal)
        prompts[name] = draft_requirements(chat, prompt)
    return suite.model_copy(update={"prompts": prompts})
