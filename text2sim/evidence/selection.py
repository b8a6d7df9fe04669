"""Selection of recorded copies, links and joints by a selector of the language."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from text2sim.compiler.soft.solvers import touches_soft, unfelt_links
from text2sim.recording.states import Array, JointRecord, RunStates
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.bodies import Body
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.names.name_table import touching_parts
from text2sim.spec_schema.names.selectors import WORLD, body_of, named_by, parse_selector

_Found = TypeVar("_Found")


class SelectionError(LookupError):
    """Error: a selector matches nothing that was recorded."""


@dataclass(frozen=True)
class RecordedTarget:
    """Referent of a name: a copy of a body, or one of its links."""

    label: str
    """`ball`, `brick[3]`, `arm.hand`, `chair.leg`."""
    copy: str
    """Name of the copy."""
    links: tuple[int, ...]
    """Columns of the arrays; empty for a deformable body."""
    root: int
    """The link whose frame stands for it; -1 for a deformable body."""
    link: str | None = None
    """Name of the link, if the target is a single one."""
    soft: int | None = None
    """Its number among deformable bodies."""
    part: str | None = None
    """Name of the part, if the target is a part of a compound."""


@dataclass(frozen=True)
class RecordedNames:
    """Recorded objects by their names in the case."""

    states: RunStates
    case: Case

    @cached_property
    def copies(self) -> dict[str, RecordedTarget]:
        """Every copy by name, in the order of the recording."""
        members: dict[str, list[int]] = {}
        for link in self.states.links:
            members.setdefault(link.body, []).append(link.index)
        found = {}
        for name, links in members.items():
            own = [i for i in links if self.states.links[i].name != WORLD] or links
            found[name] = RecordedTarget(name, name, tuple(links), own[0])
        for body in self.states.deformables:
            found.setdefault(body.body, RecordedTarget(body.body, body.body, (), -1, soft=body.index))
        return found

    @cached_property
    def copy_of_link(self) -> Array:
        """Index of the copy that each link belongs to, shape (L,)."""
        number = {name: i for i, name in enumerate(self.copies)}
        return np.array([number[link.body] for link in self.states.links], dtype=np.int64)

    @cached_property
    def driven(self) -> list[str]:
        """Copies with prescribed motion."""
        return [name for name in self.copies if self._kind(name) == "driven"]

    @cached_property
    def loose(self) -> list[RecordedTarget]:
        """Copies of bodies that are neither driven nor static."""
        return [target for name, target in self.copies.items() if self._kind(name) == "body"]

    def label_of_link(self, link: int) -> str:
        """Return a link's name in the language: its copy's, with its own if the copy has several links."""
        record = self.states.links[link]
        several = sum(self.states.links[i].name != WORLD for i in self.copies[record.body].links) > 1
        return f"{record.body}.{record.name}" if several else record.body

    def is_static(self, copy: str) -> bool:
        """Whether a copy is static."""
        return self._kind(copy) == "static"

    def touches_soft(self, copy: str) -> bool:
        """Whether a rigid copy is coupled to deformable bodies."""
        return touches_soft(self.model_of(copy))

    def felt_links(self, target: RecordedTarget) -> tuple[int, ...]:
        """Return those links of a rigid target that are coupled to deformable bodies."""
        unfelt = unfelt_links(self.model_of(target.copy)) if self.touches_soft(target.copy) else None
        if unfelt is None:
            return ()
        return tuple(link for link in target.links if self.states.links[link].name not in unfelt)

    def model_of(self, copy: str) -> Body | Static | None:
        """Return the model of a copy, with the values that the first copy has."""
        return self.case.bodies.get(body_of(copy)) or self.case.scene.statics.get(body_of(copy))

    def _kind(self, copy: str) -> str:
        body = self.case.bodies.get(body_of(copy))
        if body is None:
            return "static"
        return "driven" if body.kind == "driven" else "body"

    def select(self, selectors: str | Sequence[str]) -> list[RecordedTarget]:
        """Return the targets that a selector, or any of several, matches, each once.

        Raises:
            SelectionError: if one of them matches nothing that was recorded.
        """
        return _once(selectors, self._select)

    def select_touching(self, selectors: str | Sequence[str]) -> list[RecordedTarget]:
        """Return targets as `select` does; selectors may also name parts of rigid compounds (`chair.leg`).

        Raises:
            SelectionError: if one of them matches nothing that was recorded.
        """
        return _once(selectors, self._select_touching)

    def _select_touching(self, selector: str) -> list[RecordedTarget]:
        chosen, part = self._select_copies(selector)
        known = touching_parts(self.model_of(chosen[0].copy))
        if part is None or not known:
            return self._select(selector)
        meant = named_by(part, known)
        if not meant:
            raise SelectionError(f"{chosen[0].copy} has no part `{part}` (it has {', '.join(known)})")
        return [replace(target, label=f"{target.copy}.{name}", part=name) for target in chosen for name in meant]

    def _select(self, selector: str) -> list[RecordedTarget]:
        chosen, part = self._select_copies(selector)
        if part is None:
            return chosen
        found = []
        for target in chosen:
            if target.soft is not None:
                raise SelectionError(f"{target.copy} is deformable and has no links (asked for {selector})")
            links = {self.states.links[i].name: i for i in reversed(target.links)}
            meant = named_by(part, reversed(links))
            if not meant:
                raise SelectionError(f"{target.copy} has no link `{part}` (it has {', '.join(reversed(links))})")
            found += [RecordedTarget(f"{target.copy}.{n}", target.copy, (links[n],), links[n], n) for n in meant]
        return found

    def select_joints(self, selectors: str | Sequence[str]) -> list[tuple[str, JointRecord]]:
        """Return the joints that selectors match, each once, with labels; a mounted body stands for its single joint.

        Raises:
            SelectionError: if one of them matches none.
        """
        labels: dict[JointRecord, str] = {}
        for label, joint in _once(selectors, self._select_joints):
            labels.setdefault(joint, label)
        return [(label, joint) for joint, label in labels.items()]

    def _select_joints(self, selector: str) -> list[tuple[str, JointRecord]]:
        chosen, part = self._select_copies(selector)
        found = []
        for target in chosen:
            if target.soft is not None:
                raise SelectionError(f"{target.copy} is deformable and has no joints (asked for {selector})")
            joints = [j for j in self.states.joints if j.body == target.copy and j.kind != "fixed"]
            if part is not None:
                meant = named_by(part, [j.name for j in joints])
                joints = [j for j in joints if j.name in meant]
            if not joints or (len(joints) > 1 and "*" not in (part or "")):
                has = f"{len(joints)} joints, name one of them" if joints else "no such joint"
                raise SelectionError(f"{target.copy}{'.' + part if part else ''}: {has}")
            found += [(f"{target.copy}.{joint.name}" if part else target.copy, joint) for joint in joints]
        return found

    def select_bends(self, selectors: str | Sequence[str]) -> list[JointRecord]:
        """Return the hinge and ball joints that selectors match, each once; for links, those to their parents.

        Raises:
            SelectionError: if one of them matches none.
        """
        return _once(selectors, self._select_bends)

    def _select_bends(self, selector: str) -> list[JointRecord]:
        links = {link for target in self._select(selector) for link in target.links}
        found = [joint for joint in self.states.joints if joint.link in links and joint.kind in ("hinge", "ball")]
        if not found:
            raise SelectionError(f"{selector} has no hinge and no ball joint that could bend")
        return found

    def _select_copies(self, selector: str) -> tuple[list[RecordedTarget], str | None]:
        try:
            wanted = parse_selector(selector)
        except ValueError:
            raise SelectionError(f"`{selector}` is not a selector") from None
        all_copies = [target for name, target in self.copies.items() if body_of(name) == wanted.body]
        if not all_copies:
            raise SelectionError(f"`{wanted.body}` was not recorded")
        chosen = all_copies[wanted.first : wanted.last]
        if not chosen:
            raise SelectionError(f"`{wanted.body}` has {len(all_copies)} copies, counted from 0 (asked for {selector})")
        return chosen, wanted.part

    def groups(self, targets: Iterable[RecordedTarget]) -> Array:
        """Return the index of the target that each surface belongs to, or -1, shape (L + P,).

        Surfaces are links, then parts of compounds. Deformable bodies have none and do not appear.

        Raises:
            SelectionError: if the contacts of a part were not recorded apart from those of its body.
        """
        links = self.states.surface_links
        group = np.full(len(links), -1, dtype=np.int64)
        parts: dict[tuple[int, str | None], int] = {
            row: len(self.states.links) + i for i, row in enumerate(self.states.parts)
        }
        for number, target in enumerate(targets):
            surface = (target.root, target.part)
            if target.part is not None and (surface not in parts or not self.states.tells_parts):
                raise SelectionError(f"this recording does not tell parts of {target.copy} apart: run the case again")
            group[np.isin(links, target.links) if target.part is None else parts[surface]] = number
        return group


def _once(selectors: str | Sequence[str], find: Callable[[str], list[_Found]]) -> list[_Found]:
    """Return what selectors match, in their order, without repetitions."""
    return list(dict.fromkeys(found for selector in listed(selectors) for found in find(selector)))
