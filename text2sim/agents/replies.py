"""Types of the roles' answers, each checked before anything is done with it.

Values of the wrong type go back, and so does what a form does not know: it would be without effect in silence. Of
judgements and the like, where nothing is done with a further key, it is ignored: a chatty model costs nothing.
"""

from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints, model_validator

from text2sim.spec_schema.models.colors import ColorError, rgb

SECTIONS = ("scene", "bodies", "actions", "render")
Owner = Literal["scene", "bodies", "actions", "render"]
Where = Literal["scene", "bodies", "actions", "render", "plan"]
Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,47}$")]
Line = Annotated[str, StringConstraints(max_length=2_000)]
Lines = Annotated[list[Line], Field(max_length=60)]


class Answer(BaseModel):
    """The base of every answer."""

    model_config = ConfigDict(extra="ignore", allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _leniently(cls, data: Any) -> Any:
        """Take what is meant where only the form is off: another call costs more than this."""
        return {k: _as_meant(cls, k, v) for k, v in data.items() if v is not None} if isinstance(data, dict) else data


class Form(Answer):
    """An answer of which everything has an effect: a key that it does not know is sent back."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


def _as_meant(model: type[BaseModel], key: Any, value: Any) -> Any:
    field = model.model_fields.get(key)
    if field is None or get_origin(field.annotation) is not list:
        return value
    if isinstance(value, str):
        return [value]
    if isinstance(value, dict) and all(isinstance(row, dict) for row in value.values()):
        # Assets by the body that they are for.
        return [{"body": name, **row} for name, row in value.items()]
    return value


class PlannedBody(Form):
    """A body or static as the plan names it; its owner works it out."""

    kind: Annotated[str, StringConstraints(max_length=40)]
    """A kind of body or a prefab; `static` for what never moves."""
    shape: Annotated[str, StringConstraints(max_length=40)] = ""
    """Kind of shape, if one is meant."""
    mount: Annotated[str, StringConstraints(max_length=40)] = ""
    count: Annotated[int, Field(ge=1, le=100_000)] = 1
    """How many copies."""
    what: Line = ""
    """Size, material, where it starts, what it has to do."""


class Asset(Form):
    """A model that has to be made or looked at before the bodies are written."""

    kind: Literal["mesh", "mechanism"]
    body: Name
    """The planned body that it is for."""
    what: Line

    @model_validator(mode="before")
    @classmethod
    def _named(cls, data: Any) -> Any:
        """Take a `name` for the body: an asset has no other."""
        if not isinstance(data, dict) or "name" not in data:
            return data
        return {"body": data["name"]} | {key: value for key, value in data.items() if key != "name"}


class Fragments(Form):
    """Measures, events and expectations in the words of the language."""

    measures: dict[Name, dict[str, Any]] = {}
    events: dict[Name, dict[str, Any]] = {}
    expect: dict[Name, dict[str, Any]] = {}


Selector = Annotated[str, StringConstraints(max_length=80)]
FACTS = {"count": "equals", "color": "like", "seen": "", "moved": "by", "touched": "by"}
"""The sorts of facts, each a field of `Claim` that names a body, and the field that it needs."""


class Claim(Form):
    """Something that the program can tell of a run, as the plan wants it."""

    count: Selector = ""
    """How many bodies of a selector there are: `equals`."""
    equals: Annotated[int, Field(ge=0, le=100_000)] | None = None
    color: Selector = ""
    """Colour of a body, of a copy, a part or a link: `like` a name or #rrggbb."""
    like: Annotated[str, StringConstraints(max_length=40)] = ""
    seen: Selector = ""
    """A body that the film shows."""
    moved: Selector = ""
    """A body that is set in motion by the touch of another: `by`."""
    by: Selector = ""
    touched: Selector = ""
    """A body that another touches: `by`."""
    lasting: Annotated[float, Field(gt=0, le=3600)] | None = None
    """Seconds in all for which it is touched at least."""
    never: bool = False
    """Whether it must not be touched."""

    @model_validator(mode="after")
    def _one(self) -> "Claim":
        said = [sort for sort in FACTS if getattr(self, sort)]
        if len(said) != 1:
            raise ValueError(f"a fact is one of {', '.join(f'{a} ({b})' if b else a for a, b in FACTS.items())}")
        for key in dict.fromkeys(filter(None, FACTS.values())):
            sorts = [sort for sort, needed in FACTS.items() if needed == key]
            if (getattr(self, key) in ("", None)) == bool(said[0] in sorts):
                raise ValueError(f"`{key}` goes with {' or '.join(f'`{sort}`' for sort in sorts)}, and they with it")
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
        """The sort of fact, one of `FACTS`."""
        return next(sort for sort in FACTS if getattr(self, sort))

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that it is about."""
        words = [word for word in (getattr(self, self.sort), self.by) if word]
        return tuple(word.partition("[")[0].partition(".")[0] for word in words)


class CasePlan(Form):
    """What is to be shown, by what, and how it will be known."""

    name: Name
    event: Line
    """The event that the request asks for, in one sentence."""
    possible: Literal["yes", "partly", "no"] = "yes"
    why: Line = ""
    """What cannot be done, and why."""
    assumptions: Lines = []
    """What the request left open, and how it was read."""
    mode: list[Annotated[str, StringConstraints(max_length=40)]] = []
    """Which physics: rigid, articulated, soft, cloth, rope, granular, liquid, snow."""
    duration: Annotated[float, Field(gt=0, le=600)] = 4.0
    """Simulated time [s]."""
    params: dict[Name, Any] = {}
    bodies: Annotated[dict[Name, PlannedBody], Field(max_length=60)] = {}
    shared: Lines = []
    """What more than one Writer has to agree on: places, sizes, joints, directions, times."""
    assets: Annotated[list[Asset], Field(max_length=8)] = []
    says: dict[Name, Line] = {}
    """For each expectation that the request asks for, the sentence that it stands for."""
    checks: Fragments = Fragments()
    """The same, in the words of the language. Nobody but the Planner may change them."""
    keeps: list[Name] = []
    """Expectations about something that has to stay as it is: they hold from the start."""
    meets: dict[Name, list[Name]] = {}
    """For each requirement, the expectations that fail if it is not met; the others are judged by eye."""
    facts: dict[Name, list[Claim]] = {}
    """For each requirement, what the program itself can tell of it."""
    causes: dict[Name, list[Name]] = {}
    """For requirements of the form "X makes Y": bodies or controls without which Y must not happen."""
    briefs: dict[Owner, Line] = {}
    """What each Writer is to do."""
    cards: dict[str, list[Annotated[str, StringConstraints(max_length=80)]]] = {}
    """Debug Cards to give to each Writer, by role."""


Cites = Annotated[list[Annotated[str, StringConstraints(max_length=120)]], Field(max_length=20)]


class Failure(Answer):
    """Something that is not as the request wants it."""

    what: Line
    cites: Cites = []
    """What it rests on: `expect:`, `measure:`, `event:`, `body:` or `diagnostic:` and a name, `frame:N`, `run`."""
    section: Where


class Patch(Answer):
    """A change to one section that would mend something."""

    section: Owner
    why: Line
    operations: Annotated[list[dict[str, Any]], Field(min_length=1, max_length=100)]
    """RFC 6902, with paths from the root of the case."""


def _a_mark(value: float) -> float:
    if value not in (0, 0.5, 1):
        raise ValueError("a mark is 0, 1/2 or 1")
    return value


class Mark(Answer):
    """How far one requirement is met."""

    mark: Annotated[float, AfterValidator(_a_mark)]
    cites: Cites = []
    why: Line = ""
    """What is missing, if anything is."""

    @model_validator(mode="before")
    @classmethod
    def _short(cls, data: Any) -> Any:
        """Take a mark by itself, or with what it rests on, for the whole; and a half in any spelling."""
        if not isinstance(data, dict | list):
            data = [data]
        if isinstance(data, list):
            texts = [str(row) for row in data[1:]]
            cites = [row for row in texts if row.partition(" ")[0] == row]
            data = {"mark": data[0] if data else None, "cites": cites}
            data["why"] = " ".join(row for row in texts if row not in cites)
        mark = data.get("mark")
        return data | {"mark": _MARKS.get(str(mark).strip().lower(), mark)}


_MARKS = {
    "1": 1, "1.0": 1, "yes": 1, "true": 1, "met": 1, "½": 0.5, "1/2": 0.5, "half": 0.5, "0.5": 0.5, "0": 0, "0.0": 0,
    "no": 0, "false": 0,
}  # fmt: skip


class Critique(Answer):
    """What the Critic makes of a run."""

    seen: Line
    """What the pictures show, in the order of time."""
    requirements: dict[Name, Mark] = {}
    """How far each is met."""
    score: Annotated[float, Field(ge=0, le=100)] = 0
    """How well it agrees with the request; worked out from the marks, if there are any."""
    verdict: Literal["pass", "repair", "cannot_judge"]
    failures: Annotated[list[Failure], Field(max_length=20)] = []
    responsible: Where | None = None
    summary: Line = ""
    """What to change, for the one who does."""
    patches: Annotated[list[Patch], Field(max_length=10)] = []
    unfaithful: Lines = []
    """Restated expectations that ask for less than the request did."""
    refused: Lines = []
    """Patches that could not be applied, and why."""

    @model_validator(mode="before")
    @classmethod
    def _slips(cls, data: Any) -> Any:
        """Forgive what nothing hangs on: who is responsible for nothing, a word for a verdict."""
        if not isinstance(data, dict):
            return data
        data = dict(data)
        if data.get("responsible") not in get_args(Where):
            data.pop("responsible", None)
        word = str(data.get("verdict", "")).strip().lower()
        return data | {"verdict": _VERDICTS.get(word, word)}


_VERDICTS = {"passed": "pass", "accept": "pass", "accepted": "pass", "fail": "repair", "failed": "repair",
             "cannot judge": "cannot_judge"}  # fmt: skip


class Amendment(Answer):
    """Parts of a judgement that were asked for again."""

    requirements: dict[Name, Mark] = {}
    failures: Annotated[list[Failure], Field(max_length=20)] = []
    patches: Annotated[list[Patch], Field(max_length=10)] = []


class Route(Form):
    """Work for one Writer."""

    section: Owner
    instruction: Line
    cards: list[Annotated[str, StringConstraints(max_length=80)]] = []


class Restatement(Form):
    """An expectation that was put into the language wrongly, and how it should have been."""

    why: Line
    checks: Fragments


class PlanPatch(Form):
    """What the Planner changes of its plan."""

    event: Line = ""
    duration: Annotated[float, Field(gt=0, le=600)] | None = None
    """Another length of the run [s], which the case gets at once."""
    rename: dict[Name, Name] = {}
    """Parameters that are called otherwise from now on, in the whole case."""
    bodies: dict[Name, PlannedBody] = {}
    """Bodies that are new, or planned otherwise."""
    drop_bodies: list[Name] = []
    shared: Lines | None = None
    """All of it, in the place of what stood there."""
    assumptions: Lines | None = None
    """All of them, in the place of those that stood there."""
    briefs: dict[Owner, Line] = {}
    """Work for Writers, as `routes`."""
    assets: Annotated[list[Asset], Field(max_length=8)] = []
    """Further models that have to be made."""
    says: dict[Name, Line] = {}
    checks: Fragments = Fragments()
    """Further expectations, with their measures and events."""
    keeps: list[Name] = []
    """Expectations that are meant to hold from the start."""
    facts: dict[Name, list[Claim]] = {}
    """By requirement, in the place of those that were there."""


class Decision(Form):
    """What the Planner does about an attempt that was not accepted."""

    action: Literal["repair", "plan_anew", "give_up"]
    why: Line
    take: list[int] = []
    """Numbers of the Critic's patches to apply."""
    routes: Annotated[list[Route], Field(max_length=8)] = []
    params: dict[Name, Any] = {}
    """Parameters with another value."""
    waive: dict[Annotated[str, StringConstraints(max_length=60)], Line] = {}
    """Rules of the lint whose finding is meant, and why."""
    restate: Restatement | None = None
    plan: PlanPatch | None = None
    patch: Annotated[list[dict[str, Any]], Field(max_length=100)] = []
    """RFC 6902, on what no Writer owns: parameters, waivers, variants, sweeps, prefabs, name and prompt."""


class Refer(Form):
    """A Writer's word that a fault cannot be mended in its own section."""

    section: Where
    why: Line


class Opening(Form):
    """What the Planner makes of a wish about a case that is there already."""

    possible: Literal["yes", "partly", "no"] = "yes"
    why: Line = ""
    event: Line = ""
    routes: Annotated[list[Route], Field(max_length=8)] = []
    params: dict[Name, Any] = {}
    patch: Annotated[list[dict[str, Any]], Field(max_length=100)] = []
    """RFC 6902, on what no Writer owns."""
    says: dict[Name, Line] = {}
    checks: Fragments = Fragments()
    keeps: list[Name] = []
    """New expectations that are meant to hold from the start."""
    facts: dict[Name, list[Claim]] = {}
    """By requirement, what the program itself can tell of it."""
    drop: list[Name] = []
    """Expectations that the wish itself makes wrong."""
