"""How large the letters of small edits are, by part: written as the loop writes them, without a model or an engine.

    python benchmarks/edit_letters.py             # tokens of each letter
    python benchmarks/edit_letters.py --parts     # and of its parts
    python benchmarks/edit_letters.py --text      # the letters themselves

Three edits of two cases: looks, one number, one more body. The instructions to Writers are written as Planners write
them: with names of fields, and with what has to stay. Tokens are counted as `docs/models.md` says of mailboxes.
"""

import argparse
import re
from pathlib import Path
from typing import Any

from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import examine
from text2sim.agents.existing_case import plan_of_case
from text2sim.agents.models.tokens import text_tokens
from text2sim.agents.opening import open_case
from text2sim.agents.planning import Request
from text2sim.agents.revising import data_of
from text2sim.agents.section_writer import Change, change_section

CASES = Path(__file__).resolve().parents[1] / "cases"
LEFT = "3 of 3 attempts are left; 28 minutes are left for everything."
EDITS: dict[str, tuple[str, dict[str, str]]] = {
    "looks": (
        "make the {body} look like worn blue steel and the floor lighter",
        {
            "bodies": "Change only the look of `{body}`: worn blue steel, `color: '#4a6a8a'`, `finish: brushed_metal`. "
            "Keep its shape, place, pose, material and density as they are.",
            "scene": "Make `floor` lighter: `color: '#dcdcdc'` in its look, same finish. "
            "Keep its shape, place and friction.",
        },
    ),
    "number": (
        "drop the {body} from twice the height",
        {"bodies": "Start `{body}` twice as high above the floor (`pose` or `place`); nothing else changes."},
    ),
    "added": (
        "add a second, smaller ball that rolls into the first {body}",
        {
            "bodies": "Add `roller`: kind rigid, a sphere of radius 0.02 m, material density 7800, placed on the floor "
            "0.2 m to the left of the first `{body}`, with a red look of rubber.",
            "actions": "Add a control of kind `initial_velocity` that starts `roller` with 1 m/s along +x.",
        },
    ),
}
"""What is wished, and what each Writer is told."""
_PART = re.compile(
    r"#+ |<request>|The event:|Names in the rest|Agreed between|derived:|Kinds of measures|Left:|```yaml"
)


class Sent(Exception):
    """A letter that would be sent."""


class Desk:
    """Takes the letters instead of a model."""

    def ask(self, role: str, system: str, question: str, *rest: Any, **more: Any) -> Any:
        """Raise `Sent` with the letter."""
        raise Sent(role, system, question)

    def vision(self, role: str) -> bool:
        """Return whether pictures can be sent."""
        return True


def main() -> None:
    """Print what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", action="store_true", help="print the tokens of each part")
    parser.add_argument("--text", action="store_true", help="print the letters")
    given = parser.parse_args()
    for name, body in (("newton_cradle", "ball"), ("domino_spiral", "domino")):
        for edit, (wish, told) in EDITS.items():
            total = 0
            for role, system, question in letters(name, wish.format(body=body), told, body):
                tokens = text_tokens(system) + text_tokens(question)
                total += tokens
                print(f"{name:14} {edit:7} {role:8} {tokens:6,} tokens, {text_tokens(question):,} of them the question")
                for part, size in parts(system, question) if given.parts else ():
                    print(f"{'':32} {size:6,} {part}")
                if given.text:
                    print(f"\n{system}\n{question}")
            print(f"{name:14} {edit:7} {'all':8} {total:6,}")


def letters(name: str, wish: str, told: dict[str, str], body: str) -> list[tuple[str, str, str]]:
    """Return role, system prompt and question of the Planner's letter and those of the Writers."""
    path = CASES / name / "case.yaml"
    text = path.read_text("utf-8")
    plan, desk, found = plan_of_case(text, name), Desk(), []
    agreement = Agreement(plan, lambda *event, **what: None)
    derived = examine(text, path).derived

    def sent(letter: Any) -> None:
        try:
            letter()
        except Sent as one:
            found.append(one.args)

    request: Any = Request(wish)
    sent(lambda: open_case(desk, request, agreement, text, "", path, keep=False, left=LEFT))  # type: ignore[arg-type]
    for section, instruction in told.items():
        words = instruction.format(body=body)
        known = derived if section in ("scene", "bodies") else ""
        sent(
            lambda section=section, words=words, known=known: change_section(
                desk, section, plan, data_of(text), Change(words, derived=known, left=LEFT), path, wish  # type: ignore[arg-type]
            )
        )  # fmt: skip
    return found


def parts(system: str, question: str) -> list[tuple[str, int]]:
    """Return the beginning and the tokens of each part of a letter."""
    rows: list[tuple[str, list[str]]] = []
    for text in (system, question):
        rows.append(("(beginning)", []))
        for line in text.split("\n"):
            if _PART.match(line):
                rows.append((line[:50], []))
            rows[-1][1].append(line)
    return [(head, size) for head, lines in rows if (size := text_tokens("\n".join(lines))) > 3]


if __name__ == "__main__":
    main()
