"""Team of Writers, each responsible for its own section; referrals are passed on."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from text2sim.agents import revising
from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import whole_actions
from text2sim.agents.asset_agents import Supplies, make_asset, merge_supplies
from text2sim.agents.conversation import Conversation, RoleFailed
from text2sim.agents.journal import Emit
from text2sim.agents.offered_cards import OfferedCards
from text2sim.agents.planning import Request
from text2sim.agents.replies import SECTIONS, Asset, Refer, Route
from text2sim.agents.section_writer import Change, Unchanged, change_section, write_section
from text2sim.agents.yaml_text import yaml_text

T = TypeVar("T")
MAX_CONCURRENT = 4
"""Largest number of concurrent questions."""
REFERRAL_INSTRUCTION = "Mend what you are told, and change nothing else; refer it on if it is not yours."


@dataclass
class Workshop:
    """Coordinator of the Writers."""

    chat: Conversation
    offered: OfferedCards
    agreement: Agreement
    request: Request
    path: Path
    """Path of the case file."""
    emit: Emit
    derived: str = ""
    """Line with the derived settings that the case leaves open."""
    referred: list[str] = field(default_factory=list)
    """Faults that Writers have referred to the Planner, and that it has not been told yet."""
    unchanged: dict[str, str] = field(default_factory=dict)
    """Reasons of Writers who left their sections unchanged in the last round, by section."""
    left: Callable[[], str] = lambda: ""
    """Returns a sentence with the attempts and time left."""

    def draft_sections(self) -> dict[str, dict[str, Any]]:
        """Have all sections written for the first time."""
        plan = self.agreement.plan
        supplies = self.make_assets(plan.assets)
        self.emit("stage", name="write")
        asked = self.request.text + "".join(f"\nGiven with it: {row}" for row in self.request.inputs)
        words, left = "\n".join(f"- {row}" for row in supplies.words), self.left()

        def write(section: str) -> dict[str, Any]:
            cards = self.offered.give(section, plan.cards.get(section, ()), "first version")
            now = "" if section == "render" else left
            return write_section(self.chat, section, plan, asked, words, cards, self.path, supplies.shapes, now)

        sections = _run_concurrently({name: lambda name=name: write(name) for name in SECTIONS})
        sections["bodies"] |= supplies.bodies
        return sections

    def make_assets(self, assets: Sequence[Asset]) -> Supplies:
        """Have assets made."""
        if not assets:
            return Supplies()
        self.emit("stage", name="assets")
        # Not concurrently, because calls of a role are numbered in order.
        plan, case = self.agreement.plan, self.path.parent
        return merge_supplies([make_asset(self.chat, asset, plan, self.request, case) for asset in assets])

    def add_assets(self, text: str, assets: Sequence[Asset]) -> tuple[str, list[Route]]:
        """Have further assets made and put into the case; return the text, and the instructions for the Body Writer."""
        supplies = self.make_assets(assets)
        if supplies.bodies:
            bodies = revising.mapping(revising.data_of(text), "bodies")
            text = revising.with_sections(text, {"bodies": bodies | supplies.bodies})
        shapes = [f"`{body}`: {yaml_text({'shape': shape})}" for body, shape in supplies.shapes.items()]
        instruction = "\n".join(["Made by an expert, to be used as it is:", *supplies.words, *shapes])
        # Made without validation: an answer's instruction may not be that long.
        route = Route.model_construct(section="bodies", instruction=instruction, cards=[])
        return text, [route] if supplies.words else []

    def fix_sections(
        self, text: str, owners: Mapping[str, Sequence[str]], instruction: str
    ) -> tuple[str, dict[str, list[str]]]:
        """Have owners fix problems in their sections; return the text, and their referrals by role.

        Args:
            text: Text of the case.
            owners: Problems, by the section that has to change.
            instruction: Instruction for the Writers.
        """
        return self._change_sections(text, {name: Change(instruction, tuple(rows)) for name, rows in owners.items()})

    def follow_routes(self, text: str, routes: Sequence[Route], keep: Sequence[str] = ()) -> str:
        """Have Writers change their sections; referrals to other Writers are passed on once.

        Args:
            text: Text of the case.
            routes: Tasks of Writers.
            keep: What holds now and must stay true.
        """
        work: dict[str, Change] = {}
        left = self.left() if any(route.section in SECTIONS for route in routes) else ""
        for section in SECTIONS:
            own = [route for route in routes if route.section == section]
            if own:
                instruction = "\n".join(route.instruction for route in own)
                cards = self.offered.give(section, [card for route in own for card in route.cards], instruction[:80])
                work[section] = Change(instruction, cards=cards, keep=keep, left=left)
        text, referrals = self._change_sections(text, work)
        self.referred += self.refusals()
        return self.pass_on(text, referrals)

    def refusals(self) -> list[str]:
        """Return a sentence for each Writer who changed nothing in the last round, with the reason."""
        return [f"The Writer of {section} changed nothing: {why}" for section, why in self.unchanged.items() if why]

    def pass_on(self, text: str, referrals: dict[str, list[str]]) -> str:
        """Pass referrals on to Writers; those to the Planner wait until it is asked."""
        self.referred += referrals.pop("plan", [])
        if referrals:
            text, further = self.fix_sections(text, referrals, REFERRAL_INSTRUCTION)
            self.referred += [row for rows in further.values() for row in rows]
        return text

    def _change_sections(self, text: str, work: Mapping[str, Change]) -> tuple[str, dict[str, list[str]]]:
        """Have sections changed; `work` has the change of each."""
        case = revising.data_of(text)

        def change(section: str) -> dict[str, Any] | Refer | Unchanged:
            asked = replace(
                work[section],
                derived=self.derived if section in ("scene", "bodies") else "",
                left="" if section == "render" else work[section].left,
            )
            try:
                return change_section(
                    self.chat, section, self.agreement.plan, case, asked, self.path, self.request.text
                )
            except RoleFailed as failed:
                # The section stays as it is, and the Planner decides.
                return Refer.model_construct(section="plan", why=str(failed))

        answers = _run_concurrently({name: lambda name=name: change(name) for name in SECTIONS if name in work})
        referrals: dict[str, list[str]] = {}
        written: dict[str, dict[str, Any]] = {}
        self.unchanged = {name: answer.why for name, answer in answers.items() if isinstance(answer, Unchanged)}
        for section, answer in answers.items():
            if isinstance(answer, Refer):
                self.emit("referred", section=section, to=answer.section, why=answer.why)
                referrals.setdefault(answer.section, []).append(f"The Writer of {section} says: {answer.why}")
            elif not isinstance(answer, Unchanged):
                written[section] = whole_actions(self.agreement.plan, answer) if section == "actions" else answer
        return revising.with_sections(text, written), referrals


def _run_concurrently(jobs: Mapping[str, Callable[[], T]]) -> dict[str, T]:
    """Run independent jobs concurrently; after all have ended, the first exception is raised."""
    with ThreadPoolExecutor(max_workers=MAX_CONCURRENT) as pool:
        futures = {name: pool.submit(job) for name, job in jobs.items()}
    return {name: future.result() for name, future in futures.items()}
