"""Table of roles: name, prompt and owned sections of each."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from text2sim.spec_schema.plain import plain

PROMPTS = Path(__file__).parent / "prompts"


@dataclass(frozen=True)
class Role:
    """A role that a model plays."""

    name: str
    """Name for its calls and in `--model`."""
    title: str
    duty: str
    """Prompt file with its task."""
    owns: str = ""
    """The section that it writes."""
    example: str = ""
    """Path and value of the example of a patch in its prompt."""


ROLES = {
    role.name: role
    for role in (
        Role("reader", "Reader", "apart"),
        Role("planner", "Planner", "plan"),
        Role("scene", "Scene Writer", "scene", "scene", "/scene/dt, value: 0.005}"),
        Role("bodies", "Body Writer", "bodies", "bodies", "/bodies/ball/material/density, value: 2700}"),
        Role("actions", "Action Writer", "actions", "actions", "/actions/controls/turn/velocity, value: 3.0}"),
        Role("render", "Render Writer", "render", "render", "/render/speed, value: 0.5}"),
        Role("articulation", "Articulation agent", "mechanism"),
        Role("mesh", "Mesh agent", "mesh"),
        Role("critic", "Critic", "critic"),
        Role("viewer", "Visual Judge", "viewer"),
        Role("distiller", "Distiller", "distill"),
    )
}


@cache
def prompts_in(folder: Path) -> Any:
    """Return the Jinja environment of a folder of prompt files."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    # The output is text for a model, not HTML: nothing is escaped.
    loader = FileSystemLoader(folder)
    environment = Environment(
        loader=loader, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, autoescape=False
    )
    environment.filters["quoted"] = quoted
    return environment


def quoted(text: str) -> str:
    """Return untrusted text without control characters and closing tags, so that it cannot end the tag around it."""
    return plain(text).replace("</", "<\u200b/").strip()


def render(prompt: str, **values: Any) -> str:
    """Render a prompt template."""
    return prompts_in(PROMPTS).get_template(f"{prompt}.md.j2").render(**values).strip() + "\n"


def system_prompt(role: Role, prompt: str = "", **values: Any) -> str:
    """Return the system prompt of a role: the same in every call, so that providers can cache it.

    Args:
        role: The role.
        prompt: Prompt file, if not the role's own.
        values: Variables of that file.
    """
    duty = render(prompt or role.duty, **values)
    return render("system", title=role.title, duty=duty)


def writer_prompt(role: Role, rules: str, *, change: bool = False) -> str:
    """Return the system prompt of a section's Writer, for writing it, or for changing it.

    Args:
        role: The Writer.
        rules: Rules of the language for its section.
        change: Whether it changes a section that exists.
    """
    duty = render("write", section=role.owns, duty=render(role.duty), example=role.example, rules=rules, change=change)
    return render("system", title=role.title, duty=duty)
