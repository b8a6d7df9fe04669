"""Table of a case's names, with lookup of its selectors."""

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from text2sim.spec_schema.errors import Problem, Severity, nearest, there_are
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.bodies import Articulated, Driven, Rigid
from text2sim.spec_schema.models.placed import Deformable
from text2sim.spec_schema.models.repeat import Divided, Fragments, Grid, Repeat, RunningBond
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.models.shapes import Compound, Text
from text2sim.spec_schema.names.selectors import Selection, named_by, parse_selector
from text2sim.spec_schema.text.document import Path

UNKNOWN_COPIES = 1000
"""Copies of an unread sketch: the largest number of pieces. A body that is not yet cut has fewer fragments."""


def touching_parts(model: Any) -> list[str]:
    """Return the parts of a rigid compound that have contact, which contact measures and events and `threaded` name.

    Meshes with `collision: decompose` become one in the engine; if there are several, no contact is known to be of one.
    """
    shape = getattr(model, "shape", None)
    if not isinstance(shape, Compound) or isinstance(model, Deformable) or isinstance(model.repeat, Fragments):
        return []
    merged = {name for name, part in shape.solids.items() if getattr(part.shape, "collision", "") == "decompose"}
    return [name for name in shape.solids if len(merged) < 2 or name not in merged]


@dataclass(frozen=True)
class Parts:
    """Links and joints of a body whose links are not in the case."""

    links: tuple[str, ...]
    joints: Mapping[str, Any]
    """Model of each joint that moves: hinge, slider or ball."""


@dataclass(frozen=True)
class Member:
    """The target of a selector."""

    text: str
    """The selector."""
    name: str
    """Name of the body or static."""
    model: Any
    count: int
    """Number of selected copies, or of links or joints if a pattern selects them."""
    part: str | None
    """Link or joint, if one is named."""
    where: Path
    """Path of the selector."""

    @property
    def static(self) -> bool:
        """Whether it is one of `scene.statics`."""
        return isinstance(self.model, Static)

    @property
    def driven(self) -> bool:
        """Whether its motion is prescribed."""
        return isinstance(self.model, Driven)

    @property
    def fixed(self) -> bool:
        """Whether it cannot move at all."""
        return self.static or (isinstance(self.model, Rigid) and self.model.mount.kind == "fixed")

    @property
    def dynamic(self) -> bool:
        """Whether physics moves it."""
        return not (self.fixed or self.driven)

    @property
    def deforms(self) -> bool:
        """Whether it is a deformable body."""
        return isinstance(self.model, Deformable)

    @property
    def why_not_dynamic(self) -> str:
        """Why physics does not move it."""
        if self.static:
            return f"`{self.name}` is a static, which never moves"
        if self.driven:
            return f"the motion of `{self.name}` is prescribed (`kind: driven`)"
        return f"`{self.name}` is fixed (`mount: {{kind: fixed}}`)"


@dataclass
class NameTable:
    """The bodies and statics of a case, and its problems so far."""

    loaded: LoadedCase
    parts: Mapping[str, Parts] = field(default_factory=dict)
    """Parts of files, chains, nets and ragdolls, by name of the body, as far as known."""
    problems: list[Problem] = field(default_factory=list)
    counts: Mapping[str, int] = field(default_factory=dict)
    """Number of copies of texts and sketches, by name, as far as known."""

    def __post_init__(self) -> None:
        self.bodies = self.loaded.case.bodies
        self.statics = self.loaded.case.scene.statics

    def copies(self, name: str, model: Any) -> int:
        """Return how many copies a body or static has."""
        return self.counts.get(name) or count_copies(model.repeat, getattr(model, "shape", None))

    def report(
        self,
        where: Path,
        message: str,
        rule: str,
        hint: str | None = None,
        *,
        key: bool = False,
        severity: Severity = "error",
    ) -> None:
        """Add a problem.

        Args:
            where: Path of the value.
            message: What is wrong.
            rule: Id of the rule.
            hint: The nearest valid word.
            key: Whether to point at the key instead of the value.
            severity: `error` or `warning`.
        """
        self.problems.append(self.loaded.problem(where, message, key=key, rule=rule, hint=hint, severity=severity))

    def check_known(self, where: Path, noun: str, name: str | None, known: Collection[str]) -> bool:
        """Report a name that does not exist; return whether it is known, or not given.

        Args:
            where: Path of the name.
            noun: What it names, such as `event`.
            name: The name; None if it is not given.
            known: Existing names.
        """
        if name is None or name in known:
            return True
        self.report(where, f"there is no {noun} `{name}`{there_are(known)}", f"unknown-{noun}", nearest(name, known))
        return False

    def find(
        self,
        selector: str,
        where: Path,
        *,
        parts: bool = True,
        joint: bool = False,
        many: bool = False,
        touching: bool = False,
    ) -> Member | None:
        """Return the target of a selector, or report why it has none.

        Args:
            selector: The selector, in a valid form.
            where: Its path.
            parts: Whether it may name a link or joint.
            joint: Whether that is a joint, if links and joints have different names.
            many: Whether a pattern may select several links or joints.
            touching: Whether it may name a part of a compound, as contacts do.
        """
        chosen = parse_selector(selector)
        model = self.bodies.get(chosen.body) or self.statics.get(chosen.body)
        if model is None:
            known = list(dict.fromkeys([*self.bodies, *self.statics]))
            message = f"there is no body or static `{chosen.body}`" + there_are(known)
            self.report(where, message, "unknown-body", nearest(chosen.body, known))
            return None
        copies = self.copies(chosen.body, model)
        if not self._counted(chosen, model, copies, where):
            return None
        count = chosen.count(copies)
        if chosen.part is not None:
            if "*" in chosen.part and not (many and parts):
                message = f"only one link is allowed here, and `{chosen.part}` may select many; give the name of one"
                self.report(where, message, "part-pattern")
                return None
            if touching and touching_parts(model):
                if not self._has_touching_part(chosen.part, chosen.body, model, where):
                    return None
            elif not self._has_part(chosen.part, chosen.body, model, where, parts):
                return None
            if not self._has_known_part(chosen.part, chosen.body, where, joint):
                return None
            if "*" in chosen.part:
                count *= len(named_by(chosen.part, self._names(chosen.body, model, joint))) or 1
        return Member(selector, chosen.body, model, count, chosen.part, where)

    def find_all(
        self,
        selectors: str | list[str] | None,
        where: Path,
        *,
        joint: bool = False,
        many: bool = False,
        touching: bool = False,
    ) -> list[Member]:
        """Return the targets of a selector or a list of them, and report each that has none.

        Args:
            selectors: The selector or the list; None for nothing.
            where: Its path.
            joint: As in `find`.
            many: As in `find`.
            touching: As in `find`.
        """
        rows = enumerate(selectors) if isinstance(selectors, list) else [(None, selectors)] if selectors else []
        found = [
            self.find(each, where if k is None else (*where, k), joint=joint, many=many, touching=touching)
            for k, each in rows
        ]
        return [member for member in found if member is not None]

    def each(self, member: Member, *, joint: bool = False) -> list[Member]:
        """Return a member for each link or joint that a pattern selects; the member itself without a pattern."""
        if member.part is None or "*" not in member.part:
            return [member]
        head = member.text.partition(".")[0]
        names = named_by(member.part, self._names(member.name, member.model, joint))
        return [replace(member, text=f"{head}.{name}", part=name, count=1) for name in names]

    def _names(self, name: str, model: Any, joint: bool) -> list[str]:
        """Return the names of the links or joints of a body, as far as known."""
        if name in self.parts:
            return list(self.parts[name].joints if joint and self.parts[name].joints else self.parts[name].links)
        links = getattr(model, "links", None)
        if not isinstance(links, dict):
            return touching_parts(model)
        return [key for key, link in links.items() if not joint or getattr(link.joint, "kind", "fixed") != "fixed"]

    def _counted(self, chosen: Selection, model: Any, copies: int, where: Path) -> bool:
        name = chosen.body
        if chosen.first is None or chosen.last is None:
            return True
        if model.repeat is None:
            self.report(where, f"`{name}` has no repeat, so it has no copies", "no-copies", name)
            return False
        copies_text = f"`{name}` has {copies} copies, `{name}[0]` to `{name}[{copies - 1}]`"
        if chosen.last <= chosen.first:
            message = f"`{name}[{chosen.first}:{chosen.last}]` is empty: its end must be larger than its start"
            self.report(where, message, "no-such-copy")
            return False
        if chosen.last > copies:
            self.report(where, copies_text, "no-such-copy")
            return False
        return True

    def _has_part(self, part: str, name: str, model: Any, where: Path, parts: bool) -> bool:
        if not parts:
            self.report(where, "only a whole body is allowed here", "part", name)
            return False
        if isinstance(model, Static | Driven | Rigid | Deformable):
            only = "; only contact measures and events, and `threaded`, name its parts" if touching_parts(model) else ""
            self.report(where, f"`{name}` is one body without links{only}", "unknown-link", name)
            return False
        if isinstance(model, Articulated) and model.links is not None and not named_by(part, model.links):
            message = f"`{name}` has no link `{part}`" + there_are(model.links)
            self.report(where, message, "unknown-link", _nearest(part, model.links))
            return False
        return True

    def _has_touching_part(self, part: str, name: str, model: Any, where: Path) -> bool:
        known = touching_parts(model)
        if named_by(part, known):
            return True
        message = f"`{name}` has no part `{part}`"
        if part in model.shape.parts:
            drawn = model.shape.parts[part].decor
            why = "is only drawn (decor: true)" if drawn else "becomes one with others (collision: decompose)"
            message = f"part `{part}` of `{name}` {why}"
        self.report(where, message + there_are(known), "unknown-link", _nearest(part, known))
        return False

    def _has_known_part(self, part: str, name: str, where: Path, joint: bool) -> bool:
        """Return whether a link or joint that is not in the case exists, as far as known; report if not."""
        if name not in self.parts:
            return True
        known = self.parts[name]
        names = list(known.joints) if joint else list(known.links)
        # If there are no joints at all, another check reports why none can be driven.
        if named_by(part, names) or (joint and not names and named_by(part, known.links)):
            return True
        what, other = ("joint", "link") if joint else ("link", "joint")
        elsewhere = part in (known.links if joint else known.joints)
        these = there_are(names) or f"; there are {', '.join(names[:2])}, … {names[-1]}" * bool(names)
        message = f"`{name}` has no {what} `{part}`{f', which is a {other}' * elsewhere}{these}"
        self.report(where, message, f"unknown-{what}", _nearest(part, names))
        return False


def _nearest(part: str, names: Iterable[str]) -> str | None:
    """Return the name that is most similar to a part; for a pattern, the most similar pattern."""
    if "*" not in part:
        return nearest(part, names)
    cuts = [(name, i) for name in names for i, letter in enumerate(name) if letter == "_"]
    return nearest(part, [f"*{name[i:]}" for name, i in cuts] + [f"{name[: i + 1]}*" for name, i in cuts])


def count_copies(repeat: Repeat | None, shape: Any = None) -> int:
    """Return the number of copies; 1 without `repeat`. Half ends give every second row of a bond one box more.

    Args:
        repeat: The pattern.
        shape: The repeated shape; a text has a copy for each letter.
    """
    if repeat is None:
        return 1
    if isinstance(repeat, Divided):
        return sum(not sign.isspace() for sign in shape.text) if isinstance(shape, Text) else UNKNOWN_COPIES
    if isinstance(repeat, Grid):
        return math.prod(repeat.counts)
    if isinstance(repeat, RunningBond):
        return repeat.rows * repeat.columns + (repeat.rows // 2 if repeat.ends == "half" else 0)
    return repeat.count
