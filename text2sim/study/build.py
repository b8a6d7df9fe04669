"""The folder of a study: what is compared, its films under names that say nothing, and what people answer.

STUDY/study.json          pairs, prompts, assignments, questions: the key to who made what
STUDY/films/<number>.mp4  films, all encoded alike
STUDY/answers.sqlite      what people answered, see `answers.py`
"""

import random
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from text2sim.evaluation.documents import read_model, write_json
from text2sim.evaluation.method_folder import MethodFolder, MethodName
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.models.base import Model, Name
from text2sim.study.films import anonymised
from text2sim.study.plan import Trial, assignments

STUDY, FILMS = "study.json", "films"
QUESTIONS = {
    "prompt": "Which film shows better what the text describes: the things in it, and what becomes of them?",
    "motion": "In which film does more of the motion happen that the text describes, from its beginning to its end?",
    "physics": "In which film do things move, touch and deform more as they would in reality?",
    "picture": "Which film looks better: shapes, materials, light, camera?",
}
CONSENT = """\
You will see pairs of short films, each pair with the text that both were made from. To each pair you answer four \
questions. It takes about twenty minutes.

Your answers are kept with the time at which you gave them, under a random number. Nothing else about you is kept: no \
name, no address. A cookie with that number lets you go on later in the same browser.

Taking part is voluntary. You can stop at any time by closing the page.\
"""
LONGEST = 20_000
"""Characters of a consent text."""

Text = Annotated[str, StringConstraints(min_length=1, max_length=LONGEST)]


class Study(Model):
    """A study, and the key to it."""

    format: Literal[1] = 1
    seed: int
    anchor: MethodName
    methods: Annotated[list[MethodName], Field(min_length=1)]
    """Those that are compared with the anchor."""
    prompts: dict[Name, Text]
    """By task."""
    films: dict[Name, dict[MethodName, int]]
    """The number of each film, by task and method."""
    assignments: Annotated[list[list[Trial]], Field(min_length=1)]
    left_out: list[Text] = []
    """Comparisons that cannot be shown, and why."""
    consent: Text = CONSENT
    questions: Annotated[dict[Name, Text], Field(min_length=1)] = QUESTIONS

    def film(self, trial: Trial, side: Literal["a", "b"]) -> int:
        """Return the number of the film on a side of a comparison."""
        return self.films[trial.task][trial.method if (side == "a") == trial.first else self.anchor]


def read_study(folder: Path) -> Study:
    """Read a study.

    Raises:
        SpecError: If the folder has none.
    """
    return read_model(folder / STUDY, Study, "a study")[0]


def build(
    folder: Path,
    prompts: Mapping[str, str],
    anchor: MethodFolder,
    methods: Sequence[MethodFolder],
    *,
    seed: int = 0,
    consent: str = CONSENT,
) -> Study:
    """Make the folder of a study.

    Args:
        folder: Where; it must not have a study yet.
        prompts: The text of each task.
        anchor: The method that all are compared with.
        methods: The others.
        seed: Decides assignments, order, sides and numbers of films.
        consent: What people agree to.

    Raises:
        RunError: If there is nothing to compare.
    """
    if (folder / STUDY).exists():
        raise RunError(f"{folder}: there is a study already")
    everyone = [anchor, *methods]
    if len({one.name for one in everyone}) < len(everyone):
        raise RunError(f"two methods have one name: {', '.join(sorted(one.name for one in everyone))}")
    (folder / FILMS).mkdir(parents=True, exist_ok=True)
    left_out: list[str] = []
    films: dict[str, dict[str, int]] = {task: {} for task in prompts}
    wanted = [(task, method) for task in prompts for method in everyone]
    numbers = random.Random(seed).sample(range(len(wanted)), len(wanted))
    for (task, method), number in zip(wanted, numbers, strict=True):
        made = method.made.get(task)
        film = made.path("film") if made is not None else None
        try:
            if film is None:
                raise RunError("there is no film")
            anonymised(film, folder / FILMS / f"{number}.mp4")
            films[task][method.name] = number
        except RunError as error:
            left_out.append(f"{task}, {method.name}: {error}")
    pairs = {
        task: [one.name for one in methods if one.name in made] for task, made in films.items() if anchor.name in made
    }
    if not any(pairs.values()):
        raise RunError(f"no task has a film of {anchor.name} and of another: " + "; ".join(left_out[:5]))
    study = Study(
        seed=seed,
        anchor=anchor.name,
        methods=[one.name for one in methods],
        prompts=dict(prompts),
        films=films,
        assignments=assignments(pairs, seed),
        left_out=left_out,
        consent=consent,
    )
    write_json(folder / STUDY, study.model_dump(mode="json"))
    return study
