"""Prompt files of the evaluation, with their blanks filled in."""

from pathlib import Path
from typing import Any

from text2sim.agents.roles import prompts_in


def letter(file: str, /, **values: Any) -> str:
    """Return a prompt file with its blanks filled in."""
    return prompts_in(Path(__file__).parent / "prompts").get_template(f"{file}.md.j2").render(**values).strip() + "\n"
