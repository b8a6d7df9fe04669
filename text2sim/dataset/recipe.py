"""What a dataset is made of: a recipe in YAML, checked like a case, with every problem at its place."""

from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool, ValidationError, model_validator

from text2sim.dataset.paths import in_section, parse_path
from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.models.base import Count, Fraction, Length, Model, Name, NonNegative, Positive, Range, Real
from text2sim.spec_schema.text.document import Document, parse_document
from text2sim.spec_schema.text.source import Source as Text
from text2sim.spec_schema.vocabulary.diagnosis import diagnose

Annotation = Literal[
    "cameras", "depth", "normals", "instances", "parts", "flow", "boxes", "keypoints", "contacts", "visibility"
]
Split = Literal["train", "validation", "test"]
SPLITS: tuple[Split, ...] = ("train", "validation", "test")
Group = Literal["physics", "looks", "lights", "cameras"]
GROUPS: tuple[Group, ...] = ("physics", "looks", "lights", "cameras")
LIMIT = 200
"""Draws, films of a run, tries: at most."""
Few = Annotated[Count, Field(le=LIMIT)]


class Draw(Model):
    """A distribution; one of its keys."""

    uniform: Range | None = None
    log_uniform: tuple[Positive, Positive] | None = None
    """Its logarithm is uniform between these."""
    normal: tuple[Real, NonNegative] | None = None
    """Mean and standard deviation."""
    integer: tuple[int, int] | None = None
    """Both ends are drawn, too."""
    choice: Annotated[list[Any], Field(min_length=1, max_length=1000)] | None = None
    """One of these, whatever the case can hold there; null takes a value away."""
    times: tuple[Positive, Positive] | None = None
    """What the case has there, by a factor that is uniform between these."""
    plus: Range | None = None
    """What the case has there, and a number that is uniform between these."""

    @model_validator(mode="after")
    def _one_kind(self) -> "Draw":
        if len(self.model_fields_set) != 1:
            raise ValueError(f"has one of the keys {', '.join(type(self).model_fields)}")
        for pair in (self.log_uniform, self.integer, self.times):
            if pair is not None and pair[1] < pair[0]:
                raise ValueError(f"the second number must not be smaller than the first (got {pair[0]}, {pair[1]})")
        return self


Draws = Annotated[dict[str, Draw], Field(max_length=100)]
"""By path in the case: `params.speed`, `bodies.ball.material.density`, or `/bodies/ball/material/density`."""


class CaseSource(Model):
    """Cases that belong together, and what is made of each."""

    cases: Annotated[list[str], Field(min_length=1, max_length=1000)]
    """Folders of cases, case files, or folders of such; as seen from the recipe."""
    prompt: Annotated[str, Field(max_length=2000)] = ""
    """Request of the cases that have none of their own."""
    plain: StrictBool = True
    """Whether cases are taken as they are, besides their variants and points."""
    variants: list[Name] = []
    sweep: Name | None = None
    draws: Few = 1
    """Simulations of each of these; with other physics, if any is drawn."""
    films: Few = 1
    """Of each simulation; the first as the case has it, the others under looks, lights and cameras that are drawn."""
    physics: Draws = {}
    looks: Draws = {}
    lights: Draws = {}
    cameras: Draws = {}
    counterfactuals: dict[Name, Annotated[Draws, Field(min_length=1, max_length=1)]] = {}
    """Further simulations of every draw, each with one cause changed."""
    holds: list[Name] | Literal["all"] = []
    """Expectations that a draw has to fulfil; it is drawn again otherwise."""
    fails: list[Name] = []
    """Expectations that it has to miss."""
    refuse: list[str] = []
    """Rules of the lint whose warnings refuse a draw, as errors do: `overlap`."""
    split: Split | None = None
    """Where all of it goes; by its share if left out."""


class Film(Model):
    """How items are filmed."""

    quality: Literal["preview", "draft", "final"] = "draft"
    """preview: flat colours by a rasteriser; the others are path traced, see `text2sim render`."""
    size: tuple[Annotated[int, Field(ge=16, le=4096, multiple_of=2)], Annotated[int, Field(ge=16, multiple_of=2)]] = (
        128,
        72,
    )
    """Width and height [pixels]."""
    fps: Annotated[Real, Field(gt=0, le=240)] = 8.0
    """Pictures per second of film, or less, so that there are at most"""
    frames: Annotated[int, Field(ge=2, le=10_000)] = 32
    """pictures."""


class ItemLimits(Model):
    """What an item has to keep to."""

    penetration: Length = 0.02
    """Deepest penetration [m]."""
    energy: NonNegative = 0.05
    """Energy that comes from nowhere, as a part of the largest."""
    seen: Fraction = 0.001
    """Part of a picture that the best seen moving body fills in half of the pictures."""
    alike: Fraction = 0.002
    """Mean distance of two runs of a case, as a part of the room that they take, below which they are the same."""


class Recipe(Model):
    """A dataset."""

    text2sim_dataset: Literal[1]
    """Version of this form."""
    name: Name
    description: Annotated[str, Field(max_length=2000)] = ""
    licence: Annotated[str, Field(max_length=100)] = "unknown"
    """Of the dataset, as its card says it: `cc-by-4.0`."""
    judged: Annotated[list[str], Field(max_length=1000)] = []
    """Folders of `text2sim evaluate judge`, as seen from the recipe: judges' scores of the same simulations."""
    seed: int = 0
    film: Film = Film()
    annotations: list[Annotation] = []
    sources: Annotated[dict[Name, CaseSource], Field(min_length=1, max_length=1000)]
    benchmarks: Annotated[list[str], Field(max_length=1000)] = []
    """Cases, or folders of such, that are exported for other simulators into `benchmarks/`; as seen from the recipe."""
    splits: dict[Split, Fraction] = {"train": 0.7, "validation": 0.15, "test": 0.15}
    """Share of the items; sources are dealt out so that it is nearly kept."""
    limits: ItemLimits = ItemLimits()
    tries: Few = 10
    """Draws for one that is taken."""
    shard_mb: Annotated[Real, Field(ge=1, le=100_000)] = 256.0
    """Size of a shard [MB]."""


def parse_recipe(text: Text) -> Recipe:
    """Return the recipe that a text says. Its cases are not looked at.

    Raises:
        SpecError: if it is not a valid recipe.
    """
    document = parse_document(text)
    data: Any = document.data
    if not isinstance(data, dict):
        message = "a recipe is a mapping with the keys text2sim_dataset, name, sources, …"
        raise SpecError([document.problem((), message, rule="type")])
    try:
        recipe = Recipe.model_validate(data)
    except ValidationError as error:
        raise SpecError(diagnose(document, error, Recipe, data)) from None
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
            message = "further films of a run need `looks`, `lights` or `cameras` that are drawn"
            problems.append(document.problem(("sources", name, "films"), message, rule="inconsistent"))
        if not (source.plain or source.variants or source.sweep):
            message = "without the plain case there have to be `variants` or a `sweep`"
            problems.append(document.problem(("sources", name, "plain"), message, rule="inconsistent"))
    if not any(recipe.splits.values()):
        problems.append(document.problem(("splits",), "some split must have a share above 0", rule="inconsistent"))
    return problems
