"""Types of the roles' answers.

A `Form` rejects unknown keys, since they would silently have no effect. Other answers ignore them, to save a call.
"""

import re
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints, model_validator

from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.colors import ColorError, rgb
from text2sim.spec_schema.names.selectors import body_of

SECTIONS = ("scene", "bodies", "actions", "render")
Owner = Literal["scene", "bodies", "actions", "render"]
Where = Literal["scene", "bodies", "actions", "render", "plan"]
Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,47}$")]
MAX_LINE_LENGTH = 4_000
Line = Annotated[str, StringConstraints(max_length=MAX_LINE_LENGTH)]
Lines = Annotated[list[Line], Field(max_length=60)]
ChangedLines = Annotated[dict[Annotated[int, Field(ge=1, le=60)], Line | None], Field(max_length=60)]
"""Lines by number, from 1; null removes one, and a number after the last adds one."""


class Answer(BaseModel):
    """Base of all answers; it ignores unknown keys."""

    model_config = ConfigDict(extra="ignore", allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _leniently(cls, data: Any) -> Any:
        """Correct obvious slips of form, which is cheaper than another call."""
        return {k: _as_meant(cls, k, v) for k, v in data.items() if v is not None} if isinstance(data, dict) else data


class Form(Answer):
    """Base of answers in which every key has an effect; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


def _as_meant(model: type[BaseModel], key: Any, value: Any) -> Any:
    field = model.model_fields.get(key)
    if field is not None and field.annotation is str and isinstance(value, list):
        return " ".join(value) if all(isinstance(row, str) for row in value) else value
    if field is None or get_origin(field.annotation) is not list:
        return value
    if isinstance(value, str):
        return [value]
    if isinstance(value, list) and get_args(field.annotation)[0] == Line:
        return [_as_text(row) for row in value]
    if isinstance(value, dict) and all(isinstance(row, dict) for row in value.values()):
        # A mapping of assets by body instead of a list.
        return [{"body": name, **row} for name, row in value.items()]
    return value


def _as_text(row: Any) -> Any:
    """A line in which YAML takes a colon for a mapping, as text again."""
    if isinstance(row, dict) and len(row) == 1:
        ((before, after),) = row.items()
        if not isinstance(after, dict | list):
            return f"{before}: {'' if after is None else after}".rstrip()
    return row


class PlannedBody(Form):
    """Outline of a body or static, which its Writer works out."""

    kind: Annotated[str, StringConstraints(max_length=40)]
    """A kind of body, a prefab, or `static`."""
    shape: Annotated[str, StringConstraints(max_length=40)] = ""
    """Kind of shape; empty to leave it open."""
    mount: Annotated[str, StringConstraints(max_length=40)] = ""
    count: Annotated[int, Field(ge=1, le=100_000)] = 1
    """Number of copies."""
    what: Line = ""
    """Size, material, initial place, purpose."""

    @model_validator(mode="after")
    def _shape_of_its_own(self) -> "PlannedBody":
        """Accept the kind as shape: a beam, chain or net has no other."""
        if self.shape == self.kind:
            self.shape = ""
        return self


class Asset(Form):
    """A shape or mechanism that an asset agent makes before the bodies are written."""

    kind: Literal["mesh", "mechanism"]
    body: Name
    """The planned body that it is for."""
    what: Line

    @model_validator(mode="before")
    @classmethod
    def _named(cls, data: Any) -> Any:
        """Accept `name` for `body`."""
        if not isinstance(data, dict) or "name" not in data:
            return data
        return {"body": data["name"]} | {key: value for key, value in data.items() if key != "name"}


class Fragments(Form):
    """Measures, events and expectations in the language of cases."""

    measures: dict[Name, dict[str, Any]] = {}
    events: dict[Name, dict[str, Any]] = {}
    expect: dict[Name, dict[str, Any]] = {}


Selector = Annotated[str, StringConstraints(max_length=80)]
FACTS = {"count": "equals", "color": "like", "seen": "", "moved": "by", "touched": "by", "same": "of", "passive": ""}
"""Sorts of facts: the field of `Claim` that gives it, and the further field that this requires."""


class Claim(Form):
    """A fact about a run that the plan wants and the program can check; exactly one field of `FACTS` is set."""

    count: Selector = ""
    """Bodies whose number is `equals`."""
    equals: Annotated[int, Field(ge=0, le=100_000)] | None = None
    color: Selector = ""
    """A body, copy, part or link whose colour is `like` a name or #rrggbb."""
    like: Annotated[str, StringConstraints(max_length=40)] = ""
    seen: Selector = ""
    """A body that the film shows."""
    whole: bool = False
    """Whether every picture has to show all of it, as far as nothing stands before it."""
    moved: Selector = ""
    """A body that the touch of another, `by`, sets in motion."""
    by: Annotated[tuple[Selector, ...], BeforeValidator(lambda by: listed(by) if isinstance(by, str) else by)] = ()
    """A body, or several, any of which counts."""
    touched: Selector = ""
    """A body that another, `by`, touches."""
    lasting: Annotated[float, Field(gt=0, le=3600)] | None = None
    """Smallest total duration of the touch [s]."""
    never: bool = False
    """Whether it must not be touched."""
    same: Literal["mass", "size", ""] = ""
    """In what the bodies `of` it are alike; the size is the longest side of the box around a body."""
    of: tuple[Selector, ...] = ()
    passive: Selector = ""
    """A body or link on which no control acts: gravity, contact and its joints alone move it."""

    @model_validator(mode="after")
    def _one(self) -> "Claim":
        given = [sort for sort in FACTS if getattr(self, sort)]
        if len(given) != 1:
            raise ValueError(f"a fact is one of {', '.join(f'{a} ({b})' if b else a for a, b in FACTS.items())}")
        for key in dict.fromkeys(filter(None, FACTS.values())):
            sorts = [sort for sort, needed in FACTS.items() if needed == key]
            if (getattr(self, key) in ("", None, ())) == bool(given[0] in sorts):
                raise ValueError(f"`{key}` and {' or '.join(f'`{sort}`' for sort in sorts)} need each other")
        if self.whole and not self.seen:
            raise ValueError("`whole` goes with `seen`")
        if (self.lasting is not None or self.never) and not self.touched:
            raise ValueError("`lasting` and `never` go with `touched`")
        if self.lasting is not None and self.never:
            raise ValueError("what is `never` touched has no `lasting`")
        if self.like:
            try:
                rgb(self.like)
            except ColorError as error:
                raise ValueError(str(error)) from None
        return self

    @property
    def sort(self) -> str:
        """The sort of fact, a key of `FACTS`."""
        return next(sort for sort in FACTS if getattr(self, sort))

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that it is about."""
        words = self.of or (getattr(self, self.sort), *self.by)
        return tuple(map(body_of, words))


class CasePlan(Form):
    """Plan of a case: the event, the bodies, and the expectations that define success."""

    name: Name
    event: Line
    """The event that the request asks for, in one sentence."""
    possible: Literal["yes", "partly", "no"] = "yes"
    why: Line = ""
    """Reason why something is not possible."""
    cannot: dict[Name, Line] = {}
    """With `partly`: requirements that cannot be met in full, and why."""
    assumptions: Lines = []
    """Interpretations of what the request leaves open."""
    mode: list[Annotated[str, StringConstraints(max_length=40)]] = []
    """Kinds of physics: rigid, articulated, soft, cloth, rope, granular, liquid, snow."""
    duration: Annotated[float, Field(gt=0, le=600)] = 4.0
    """Simulated time [s]."""
    params: dict[Name, Any] = {}
    bodies: Annotated[dict[Name, PlannedBody], Field(max_length=60)] = {}
    shared: Lines = []
    """Values that several Writers must agree on: places, sizes, joints, directions, times."""
    assets: Annotated[list[Asset], Field(max_length=8)] = []
    says: dict[Name, Line] = {}
    """The sentence of the request behind each expectation."""
    checks: Fragments = Fragments()
    """The expectations, with their measures and events; only the Planner may change them."""
    keeps: list[Name] = []
    """Expectations that something stays as it is, which hold from the start."""
    meets: dict[Name, list[Name]] = {}
    """Expectations that fail if a requirement is not met, by requirement; the others are judged by eye."""
    facts: dict[Name, list[Claim]] = {}
    """Facts that the program can check, by requirement."""
    causes: dict[Name, list[Name]] = {}
    """For requirements of the form "X makes Y": bodies or controls without which Y must not happen."""
    briefs: dict[Owner, Line] = {}
    """Task of each Writer."""
    cards: dict[str, list[Annotated[str, StringConstraints(max_length=80)]]] = {}
    """Ids of Debug Cards for each Writer."""

    @model_validator(mode="after")
    def _whole_repeats(self) -> "CasePlan":
        """Accept `NAME_0` under `keeps` and `meets` for an expectation with `repeat`, which counts as a whole."""
        repeated = [name for name, row in self.checks.expect.items() if "repeat" in row]

        def whole(names: list[str]) -> list[str]:
            found = [next((one for one in repeated if re.fullmatch(rf"{one}_\d+", name)), name) for name in names]
            return list(dict.fromkeys(found))

        self.keeps[:] = whole(self.keeps)
        for names in self.meets.values():
            names[:] = whole(names)
        return self


class Route(Form):
    """A task for one Writer."""

    section: Owner
    instruction: Line
    cards: list[Annotated[str, StringConstraints(max_length=80)]] = []


class Restatement(Form):
    """Corrections of expectations that do not say what the request means."""

    why: Line
    checks: Fragments


class PlanPatch(Form):
    """The Planner's changes of its plan."""

    event: Line = ""
    duration: Annotated[float, Field(gt=0, le=600)] | None = None
    """New duration of the run [s], which the case gets at once."""
    rename: dict[Name, Name] = {}
    """New names of parameters by old name, for the whole case."""
    bodies: dict[Name, PlannedBody] = {}
    """New bodies, and new outlines of planned ones."""
    drop_bodies: list[Name] = []
    shared: Lines | ChangedLines | None = None
    assumptions: Lines | ChangedLines | None = None
    briefs: dict[Owner, Line] = {}
    """Tasks for Writers, like `routes`."""
    assets: Annotated[list[Asset], Field(max_length=8)] = []
    """Additional assets."""
    says: dict[Name, Line] = {}
    checks: Fragments = Fragments()
    """Additional expectations, with their measures and events."""
    keeps: list[Name] = []
    """Expectations that are meant to hold from the start."""
    facts: dict[Name, list[Claim]] = {}
    """Replaces the facts of these requirements."""
    meets: dict[Name, list[Name]] = {}
    """Replaces the expectations that these requirements are bound to."""
    causes: dict[Name, list[Name]] = {}
    """Replaces the causes of these requirements; an empty list removes them."""


class Decision(Form):
    """The Planner's decision about an attempt that was not accepted."""

    action: Literal["repair", "try", "plan_anew", "give_up"]
    why: Line
    trials: list[dict[Name, Any]] = []
    """With `try`: values of parameters, for each run before the decision."""
    back_to: int | None = None
    """Number of the earlier attempt that is changed, instead of the latest."""
    take: list[int] = []
    """Numbers of the Critic's patches to apply."""
    routes: Annotated[list[Route], Field(max_length=8)] = []
    params: dict[Name, Any] = {}
    """New values of parameters."""
    waive: dict[Annotated[str, StringConstraints(max_length=120)], Line] = {}
    """Lint rules whose findings are intended, and why."""
    restate: Restatement | None = None
    plan: PlanPatch | None = None
    patch: Annotated[list[dict[str, Any]], Field(max_length=100)] = []
    """RFC 6902, on parts that no Writer owns: parameters, waivers, variants, sweeps, prefabs, name and prompt."""


class Refer(Form):
    """A Writer's statement that a fault must be fixed in another section, or in the plan."""

    section: Where
    why: Line


class Opening(Form):
    """The Planner's first answer about an existing case that is to be changed."""

    possible: Literal["yes", "partly", "no"] = "yes"
    why: Line = ""
    cannot: dict[Name, Line] = {}
    """With `partly`: requirements that cannot be met in full, and why."""
    event: Line = ""
    routes: Annotated[list[Route], Field(max_length=8)] = []
    params: dict[Name, Any] = {}
    patch: Annotated[list[dict[str, Any]], Field(max_length=100)] = []
    """RFC 6902, on parts that no Writer owns."""
    says: dict[Name, Line] = {}
    checks: Fragments = Fragments()
    keeps: list[Name] = []
    """New expectations that are meant to hold from the start."""
    facts: dict[Name, list[Claim]] = {}
    """Facts that the program can check, by requirement."""
    drop: list[Name] = []
    """Expectations that the request itself invalidates."""
