"""Prompt templates of the evaluation."""

from pathlib import Path
from typing import Any

from text2sim.agents.roles import prompts_in


def render_prompt(file: str, /, **values: Any) -> str:
    """Render a prompt template."""
    return prompts_in(Path(__file__).parent / "prompts").get_template(f"{file}.md.j2").render(**values).strip() + "\n"
