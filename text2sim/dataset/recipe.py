"""Recipe of a dataset in YAML, checked like a case, with every problem at its place."""

from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool, model_validator

from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.models.base import Count, Fraction, Length, Model, Name, NonNegative, Positive, Range, Real
from text2sim.spec_schema.paths import dotted, parse_dotted
from text2sim.spec_schema.text.document import Document, Path, parse_document, parse_pointer
from text2sim.spec_schema.text.source import Source as Text
from text2sim.spec_schema.vocabulary.typed_document import model_of

Annotation = Literal[
    "cameras", "depth", "normals", "instances", "parts", "flow", "boxes", "keypoints", "contacts", "visibility"
]
Split = Literal["train", "validation", "test"]
SPLITS: tuple[Split, ...] = ("train", "validation", "test")
Group = Literal["physics", "looks", "lights", "cameras"]
GROUPS: tuple[Group, ...] = ("physics", "looks", "lights", "cameras")
FILM_GROUPS: tuple[Group, ...] = GROUPS[1:]
"""What further films of a simulation are drawn from."""
MAX_DRAWS = 200
"""Largest number of draws, of films of a run, and of tries."""
Few = Annotated[Count, Field(le=MAX_DRAWS)]
LOOKS = ("background", "backdrop", "tone")
"""Keys of `render` that belong to neither lights nor cameras."""
LIGHTS = ("lights", "exposure")
CAMERAS = ("cameras", "shots")
"""Keys of `render` that belong to cameras: shots choose which of them films."""


class Draw(Model):
    """A distribution, with exactly one of these keys."""

    uniform: Range | None = None
    log_uniform: tuple[Positive, Positive] | None = None
    """The logarithm is uniform between these."""
    normal: tuple[Real, NonNegative] | None = None
    """Mean and standard deviation."""
    integer: tuple[int, int] | None = None
    """Both ends are included."""
    choice: Annotated[list[Any], Field(min_length=1, max_length=1000)] | None = None
    """One of these values, of any type that the case allows there; null removes the value."""
    times: tuple[Positive, Positive] | None = None
    """The case's value, times a factor that is uniform between these."""
    plus: Range | None = None
    """The case's value, plus a number that is uniform between these."""

    @model_validator(mode="after")
    def _one_kind(self) -> "Draw":
        if len(self.model_fields_set) != 1:
            raise ValueError(f"has one of the keys {', '.join(type(self).model_fields)}")
        for pair in (self.log_uniform, self.integer, self.times):
            if pair is not None and pair[1] < pair[0]:
                raise ValueError(f"the second number must not be smaller than the first (got {pair[0]}, {pair[1]})")
        return self


Draws = Annotated[dict[str, Draw], Field(max_length=100)]
"""Distributions by path in the case: `params.speed`, `bodies.ball.look.color` or `/bodies/ball/look/color`."""


class CaseSource(Model):
    """Cases that belong together, and the items that are made from each."""

    cases: Annotated[list[str], Field(min_length=1, max_length=1000)]
    """Folders of cases, case files, or folders of such, relative to the recipe."""
    prompt: Annotated[str, Field(max_length=2000)] = ""
    """Request for cases without their own."""
    plain: StrictBool = True
    """Whether plain cases are used besides their variants and points of the sweep."""
    variants: list[Name] = []
    sweep: Name | None = None
    draws: Few = 1
    """Simulations of each of these, each with its own draw of `physics`."""
    films: Few = 1
    """Films of each simulation: the first as in the case, the others with drawn looks, lights and cameras."""
    physics: Draws = {}
    looks: Draws = {}
    lights: Draws = {}
    cameras: Draws = {}
    counterfactuals: dict[Name, Annotated[Draws, Field(min_length=1, max_length=1)]] = {}
    """Further simulations of every draw, each with one cause changed."""
    holds: list[Name] | Literal["all"] = []
    """Expectations that a draw must meet; it is drawn again otherwise."""
    fails: list[Name] = []
    """Expectations that a draw must miss."""
    refuse: list[str] = []
    """Rules of the lint whose warnings refuse a draw, as errors do: `overlap`."""
    split: Split | None = None
    """Split of the source; chosen by the shares if left out."""


Side = Annotated[int, Field(ge=16, le=4096, multiple_of=2)]


class Film(Model):
    """Film settings of the items."""

    quality: Literal["preview", "draft", "final"] = "draft"
    """preview: flat colours by a rasteriser; the others are path traced, see `text2sim render`."""
    size: tuple[Side, Side] = (128, 72)
    """Width and height [pixels]."""
    fps: Annotated[Real, Field(gt=0, le=240)] = 8.0
    """Pictures per second of film; less where a film would have more pictures than `frames`."""
    frames: Annotated[int, Field(ge=2, le=10_000)] = 32
    """Largest number of pictures."""


class ItemLimits(Model):
    """Limits that items must meet."""

    penetration: Length = 0.02
    """Deepest penetration [m]."""
    energy: NonNegative = 0.05
    """Energy gain without a source, as a part of the largest kinetic energy or of the work of motors."""
    seen: Fraction = 0.001
    """Part of a picture that the largest moving body fills in half of the pictures."""
    alike: Fraction = 0.002
    """Mean distance of two runs of a case, as a part of the space of their bodies, below which they are duplicates.

    Runs in two splits are compared with the default.
    """


class Recipe(Model):
    """A dataset."""

    text2sim_dataset: Literal[1]
    """Version of the format."""
    name: Name
    description: Annotated[str, Field(max_length=2000)] = ""
    licence: Annotated[str, Field(max_length=100)] = "unknown"
    """Licence of the dataset for its card: `cc-by-4.0`."""
    judged: Annotated[list[str], Field(max_length=1000)] = []
    """Folders of `text2sim evaluate judge`, relative to the recipe, with judges' scores of the same simulations."""
    seed: int = 0
    film: Film = Film()
    annotations: list[Annotation] = []
    sources: Annotated[dict[Name, CaseSource], Field(min_length=1, max_length=1000)]
    benchmarks: Annotated[list[str], Field(max_length=1000)] = []
    """Cases or folders of cases, relative to the recipe, that are exported to `benchmarks/` for other simulators."""
    splits: dict[Split, Fraction] = {"train": 0.7, "validation": 0.15, "test": 0.15}
    """Shares of the items; whole sources are assigned, so that they are met approximately."""
    limits: ItemLimits = ItemLimits()
    tries: Few = 10
    """Largest number of draws for one that is accepted."""
    shard_mb: Annotated[Real, Field(ge=1, le=100_000)] = 256.0
    """Size of a shard [MB]."""


def parse_recipe(text: Text) -> Recipe:
    """Parse a recipe, without reading its cases.

    Raises:
        SpecError: if it is not a valid recipe.
    """
    document = parse_document(text)
    recipe = model_of(document, Recipe, "a recipe is a mapping with the keys text2sim_dataset, name, sources, …")
    if problems := _check_paths(recipe, document):
        raise SpecError(problems)
    return recipe


def _check_paths(recipe: Recipe, document: Document) -> list[Problem]:
    problems = []
    for name, source in recipe.sources.items():
        tables = {(group,): getattr(source, group) for group in GROUPS}
        tables |= {("counterfactuals", key): table for key, table in source.counterfactuals.items()}
        for place, table in tables.items():
            section = place[0] if place[0] in GROUPS else "physics"
            for path in table:
                where = ("sources", name, *place, path)
                try:
                    steps = parse_path(path)
                except ValueError as error:
                    problems.append(document.problem(where, f"`{path}`: {error}", key=True, rule="form"))
                    continue
                if (wrong := in_section(steps, section)) is not None:
                    problems.append(document.problem(where, f"`{path}` {wrong}", key=True, rule="section"))
        if source.films > 1 and not (source.looks or source.lights or source.cameras):
            message = "further films of a run need draws in `looks`, `lights` or `cameras`"
            problems.append(document.problem(("sources", name, "films"), message, rule="inconsistent"))
        if not (source.plain or source.variants or source.sweep):
            message = "without the plain case, the source needs `variants` or a `sweep`"
            problems.append(document.problem(("sources", name, "plain"), message, rule="inconsistent"))
    if not any(recipe.splits.values()):
        problems.append(document.problem(("splits",), "at least one share must be above 0", rule="inconsistent"))
    if (total := sum(recipe.splits.values())) > 1 + 1e-9:
        message = f"the shares must add up to at most 1 (got {total:g})"
        problems.append(document.problem(("splits",), message, rule="range"))
    return problems


def parse_path(text: str) -> Path:
    """Return the steps of `bodies.ball.pose.pos[2]` or `/bodies/ball/pose/pos/2`.

    Raises:
        ValueError: if it is neither.
    """
    if not text.startswith("/"):
        return parse_dotted(text)
    return parse_dotted(dotted(parse_pointer(text)))


def in_section(path: Path, group: str) -> str | None:
    """Return why a path does not belong to `physics`, `looks`, `lights` or `cameras`; None if it does."""
    steps = [str(step) for step in path]
    film = steps[0] == "render"
    if group == "physics":
        if not film and "look" not in steps:
            return None
        takers = [other for other in ("looks", "lights", "cameras") if in_section(path, other) is None]
        return f"changes the film: draw it under `{takers[0]}`" if takers else "changes the film, and cannot be drawn"
    inner = steps[1] if film and len(steps) > 1 else ""
    if group == "looks":
        ok, wanted = "look" in steps or inner in LOOKS, f"a `look`, or render.{', render.'.join(LOOKS)}"
    elif group == "lights":
        ok, wanted = inner in LIGHTS, f"a path that begins with render.{' or render.'.join(LIGHTS)}"
    else:
        ok, wanted = inner in CAMERAS, f"a path that begins with render.{' or render.'.join(CAMERAS)}"
    return None if ok else f"does not belong to {group}, which takes {wanted}"
