"""Functions of tasks: simulate a case, render a part of a film."""

import os
import shutil
from typing import Any

from text2sim.cluster.task import TaskPlace
from text2sim.recording.record import COMPLETE
from text2sim.spec_schema.errors import RunError


def simulate(
    place: TaskPlace,
    *,
    file: str = "case.yaml",
    variants: list[str],
    sets: list[str],
    point: list[str] | None,
    lint: list[dict[str, Any]],
    **options: Any,
) -> dict[str, Any]:
    """Bring the run of a case up to date, in the folder `place.output`.

    Args:
        place: Has the folder of the case as input `case`, and the user's prefabs, if any, as `prefabs`.
        file: Name of the case's file in it.
        variants: As in `CaseOverlay`, like `sets` and `point`.
        sets: See there.
        point: See there.
        lint: Findings to record with the run.
        options: Options of `run_case`.

    Returns:
        The result, as in `RunResult.as_dict`.
    """
    from text2sim.harness.run import run_case
    from text2sim.spec_schema.load import load_case
    from text2sim.spec_schema.reuse.library import VARIABLE
    from text2sim.spec_schema.reuse.overlay import CaseOverlay

    if "prefabs" in place.inputs:
        os.environ[VARIABLE] = str(place.inputs["prefabs"])
    overlay = CaseOverlay(tuple(variants), tuple(sets), (point[0], point[1]) if point else None)
    loaded = load_case(place.inputs["case"] / file, overlay)
    result = run_case(loaded, runs=place.output, stop=place.stop, runner=place.runner, lint=lint, **options)
    again = result.state not in COMPLETE or result.stopped or bool(result.film_message)
    return {**result.as_dict(), "folder": result.folder.name, "stopped": result.stopped, "again": again}


def render(
    place: TaskPlace,
    *,
    quality: str,
    size: list[int] | None,
    fps: float | None,
    reels: dict[str, Any],
    shard: list[int],
    format: str,
    cores: int,
    file: str = "case.yaml",
    samples: int | None = None,
) -> dict[str, Any]:
    """Render a part of the films of a run into `place.output`, which has the finished pictures.

    Args:
        place: Has the run folder as input `run`, and the case as `case` to film it with its current settings.
        quality: As for `Filming`, like `size`, `samples` and `fps`.
        size: See there.
        samples: See there.
        fps: See there.
        reels: Arguments of `Filming.reels`.
        shard: Part, from 0, and number of parts.
        format: Format of the pictures.
        cores: Number of threads.
        file: Name of the case's file.
    """
    from text2sim.compiler.build import plan_case
    from text2sim.recording.film_record import read_recording
    from text2sim.rendering.film import Filming
    from text2sim.rendering.renderer import mitsuba
    from text2sim.spec_schema.load import load_case

    mitsuba()
    import drjit  # after `mitsuba`, which sets the path of its compiler

    drjit.set_thread_count(cores)
    plan = plan_case(load_case(place.inputs["case"] / file)) if "case" in place.inputs else None
    filming = Filming(
        read_recording(place.inputs["run"], plan),
        quality,
        size=(size[0], size[1]) if size else None,
        samples=samples,
        fps=fps,
    )
    span, during = reels.get("span"), reels.get("during")
    names, traced = [], 0
    for reel in filming.reels(
        reels.get("camera", ""), tuple(span) if span else None, tuple(during) if during else None
    ):

        def tell(progress: Any) -> None:
            nonlocal traced
            traced += bool(progress.seconds)
            if place.stop.count:
                raise RunError("stopped on request; finished pictures are kept")

        for path in filming.render(reel, tell, shard=(shard[0], shard[1]), format=format):  # type: ignore[arg-type]
            names.append(path.name)
            target = place.output / path.name
            if target != path and not target.exists():
                place.output.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, target)
    return {"pictures": names, "traced": traced}
