"""Folder of a study: the comparisons, the anonymised films, and the answers.

STUDY/study.json          prompts, assignments, questions, and the method behind each film
STUDY/films/<number>.mp4  films, all encoded in the same way
STUDY/answers.sqlite      answers, see `answers.py`
"""

import os
import random
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from text2sim.evaluation.documents import read_model
from text2sim.evaluation.method_folder import MethodFolder, MethodName
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.models.base import Model, Name
from text2sim.spec_schema.whole_files import write_json
from text2sim.study.plan import Trial, assignments

STUDY, FILMS = "study.json", "films"
QUESTIONS = {
    "prompt": "Which film better shows what the text describes: the objects in it, and what happens to them?",
    "motion": "Which film shows more of the motion that the text describes, from beginning to end?",
    "physics": "In which film do objects move, touch and deform more realistically?",
    "picture": "Which film looks better: shapes, materials, light, camera?",
}
CONSENT = """\
You will see pairs of short films. Both films of a pair were made from the same text, which is shown with them. You \
answer four questions about each pair. It takes about twenty minutes.

Your answers are stored with the time at which you gave them, under a random number. Nothing else about you is stored: \
no name, no address. A cookie with that number lets you continue later in the same browser.

Participation is voluntary. You can stop at any time by closing the page.\
"""
MAX_TEXT_LENGTH = 20_000
"""Largest number of characters of a text."""

Text = Annotated[str, StringConstraints(min_length=1, max_length=MAX_TEXT_LENGTH)]
MOST_FRAMES = 18_000
"""Frames of a film: five minutes at 60 per second."""
LONGEST_SIDE = 4096
"""Largest width or height of a frame [pixels]."""


class Study(Model):
    """A study: films, comparisons and questions."""

    format: Literal[1] = 1
    seed: int
    anchor: MethodName
    methods: Annotated[list[MethodName], Field(min_length=1)]
    """The methods that are compared with the anchor."""
    prompts: dict[Name, Text]
    """The prompt of each task."""
    films: dict[Name, dict[MethodName, int]]
    """The number of each film, by task and method."""
    assignments: Annotated[list[list[Trial]], Field(min_length=1)]
    left_out: list[Text] = []
    """Films that are missing or unreadable, and why."""
    consent: Text = CONSENT
    questions: Annotated[dict[Name, Text], Field(min_length=1)] = QUESTIONS

    def film(self, trial: Trial, side: Literal["a", "b"]) -> int:
        """Return the number of the film on one side of a comparison."""
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
        folder: The folder; it must not contain a study.
        prompts: The text of each task.
        anchor: The method that all others are compared with.
        methods: The other methods.
        seed: Determines assignments, order, sides and numbers of films.
        consent: The text that participants agree to.

    Raises:
        RunError: If the folder has a study, two methods have the same name, or there is nothing to compare.
    """
    if (folder / STUDY).exists():
        raise RunError(f"{folder}: it already contains a study")
    names = [method.name for method in methods]
    if anchor.name in names or len(set(names)) < len(names):
        raise RunError(f"two methods have the same name: {', '.join(sorted([anchor.name, *names]))}")
    films, left_out = _copy_films(folder / FILMS, prompts, [anchor, *methods], seed)
    pairs = {
        task: [name for name in names if name in numbers] for task, numbers in films.items() if anchor.name in numbers
    }
    if not any(pairs.values()):
        raise RunError(f"no task has films of both {anchor.name} and another method: " + "; ".join(left_out[:5]))
    study = Study(
        seed=seed,
        anchor=anchor.name,
        methods=names,
        prompts=dict(prompts),
        films=films,
        assignments=assignments(pairs, seed),
        left_out=left_out,
        consent=consent,
    )
    write_json(folder / STUDY, study.model_dump(mode="json"))
    return study


def _copy_films(
    folder: Path, tasks: Iterable[str], methods: Sequence[MethodFolder], seed: int
) -> tuple[dict[str, dict[str, int]], list[str]]:
    """Write anonymised films, numbered at random; return numbers by task and method, and what is missing."""
    folder.mkdir(parents=True, exist_ok=True)
    films: dict[str, dict[str, int]] = {task: {} for task in tasks}
    pairs = list(product(films, methods))
    numbers = random.Random(seed).sample(range(len(pairs)), len(pairs))
    left_out: list[str] = []
    for (task, method), number in zip(pairs, numbers, strict=True):
        result = method.made.get(task)
        film = result.path("film") if result is not None else None
        try:
            if film is None:
                raise RunError("there is no film")
            anonymise_film(film, folder / f"{number}.mp4")
            films[task][method.name] = number
        except RunError as error:
            left_out.append(f"{task}, {method.name}: {error}")
    return films, left_out


def anonymise_film(source: Path, target: Path) -> None:
    """Re-encode a film with the settings of all others, without sound, tags, names and dates.

    Raises:
        RunError: If it is not a film, or is too large.
    """
    import av
    import av.error

    try:
        with av.open(str(source)) as film, av.open(str(target), "w", format="mp4", options=_OPTIONS) as output:
            if not film.streams.video:
                raise RunError(f"{source}: the film has no frames")
            pictures = film.streams.video[0]
            old = pictures.codec_context
            if max(old.width, old.height) > LONGEST_SIDE:
                raise RunError(f"{source}: its frames are larger than {LONGEST_SIDE} pixels")
            rate = pictures.average_rate or Fraction(25)
            stream = output.add_stream("libx264", rate=rate)
            stream.width, stream.height, stream.pix_fmt = old.width // 2 * 2, old.height // 2 * 2, "yuv420p"
            stream.options = {"crf": "14", "preset": "veryfast", "threads": "2"}
            for name in ("colorspace", "color_primaries", "color_trc", "color_range"):
                setattr(stream.codec_context, name, getattr(old, name))
            count = 0
            for count, frame in enumerate(film.decode(pictures), 1):
                if count > MOST_FRAMES:
                    raise RunError(f"{source}: it has more than {MOST_FRAMES:,} frames")
                plain = frame.reformat(stream.width, stream.height, "yuv420p")
                plain.pts, plain.time_base, plain.pict_type = count - 1, 1 / rate, 0
                output.mux(stream.encode(plain))
            output.mux(stream.encode())
        if not count:
            raise RunError(f"{source}: the film has no frames")
    except (av.error.FFmpegError, ValueError, OverflowError) as error:
        raise RunError(f"{source}: the film cannot be read: {error}") from None
    os.utime(target, (0, 0))


_OPTIONS = {"movflags": "+faststart", "fflags": "+bitexact"}
