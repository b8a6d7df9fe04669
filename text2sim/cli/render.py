"""The command `text2sim render`."""

import shutil
import sys
from collections.abc import Callable
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from text2sim.cli.film_tracing import ProgressReporter, trace_films
from text2sim.cli.many import Ray, StoreUrl, Workers, trace, where_of
from text2sim.cli.options import AsJson, RunsFolder
from text2sim.cli.output import say, say_json
from text2sim.cli.recorded import Chosen, choose
from text2sim.runtime.stop import Stop
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import RunError

if TYPE_CHECKING:
    from text2sim.cluster.run import Placement
    from text2sim.rendering.budget import FittedFilm
    from text2sim.rendering.film import Filming, FilmProgress, Format, Reel


def render(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder, or a case with a run.")],
    quality: Annotated[
        Literal["draft", "final", "still"],
        typer.Option("--quality", help="draft: 8 samples per pixel; final: 36; still: one picture with 144."),
    ] = "draft",
    frames: Annotated[
        str, typer.Option("--frames", metavar="A:B", help="Only pictures A to B (exclusive), or only picture A.")
    ] = "",
    during: Annotated[
        str, typer.Option("--during", metavar="A:B", help="Only the time from A to B, in simulated seconds.")
    ] = "",
    fps: Annotated[
        float | None, typer.Option("--fps", min=1, max=240, help="Pictures per second; the case's if left out.")
    ] = None,
    camera: Annotated[str, typer.Option("--camera", metavar="NAME", help="Only this camera.")] = "",
    resolution: Annotated[str, typer.Option("--resolution", metavar="WxH", help="The case's if left out.")] = "",
    samples: Annotated[
        int | None, typer.Option("--samples", min=1, max=4096, help="Samples per pixel; the quality's if left out.")
    ] = None,
    frames_only: Annotated[
        Literal["png", "exr"] | None,
        typer.Option("--frames-only", help="Numbered pictures instead of a film; exr keeps radiance."),
    ] = None,
    shard: Annotated[
        str, typer.Option("--shard", metavar="I/N", help="Only the I-th of N parts (from 1), for several processes.")
    ] = "",
    minutes: Annotated[
        float | None,
        typer.Option("--minutes", min=0.1, help="Reduce samples, size and frame rate to finish in about this time."),
    ] = None,
    join: Annotated[bool, typer.Option("--join", help="Only make the film from the pictures of shards.")] = False,
    beside: Annotated[
        Path | None, typer.Option("--beside", metavar="RUN", help="Make one film with this run or case on the right.")
    ] = None,
    suggest: Annotated[
        bool,
        typer.Option("--suggest", help="Propose a camera and light by how well they show the run; render nothing."),
    ] = False,
    write: Annotated[bool, typer.Option("--write", help="With --suggest: write the proposal to the case.")] = False,
    runs: RunsFolder = Path("runs"),
    workers: Workers = 1,
    ray: Ray = "",
    store: StoreUrl = "",
    as_json: AsJson = False,
) -> None:
    """Render a path-traced film of a recorded run, without simulating again.

    For a case, its run in `runs` is filmed with the current `render` section.

    Finished frames are reused: a stopped render resumes, and a change of the case only costs the frames that it
    affects.
    """
    from text2sim.rendering.budget import FittedFilm, fitted
    from text2sim.rendering.film import Filming
    from text2sim.rendering.renderer import find_variant

    span, shard_of, size, times = frame_range(frames), shard_numbers(shard), film_size(resolution), time_range(during)
    if write and not suggest:
        raise typer.BadParameter("needs --suggest", param_hint="'--write'")
    chosen = choose(run, runs)
    if not join:
        variant = find_variant()
        if variant.hint and not as_json:
            say(variant.hint, to=sys.stderr)
    if suggest:
        from text2sim.cli.suggest import propose

        propose(chosen, write=write, as_json=as_json)
        raise typer.Exit(exits.OK)
    filming = Filming(chosen.recording, quality, size=size, samples=samples, fps=fps)
    if beside is not None:
        if quality == "still" or frames_only or shard:
            raise typer.BadParameter("cannot be used with still, --frames-only, --shard", param_hint="'--beside'")
        other = Filming(choose(beside, runs).recording, quality, size=filming.size, samples=samples, fps=fps)
        path = _render_both(filming, other, camera, span, times, join=join, quiet=as_json)
        say_json({"ok": True, "files": [str(path)]}) if as_json else say(f"film: {display_path(path)}")
        raise typer.Exit(exits.OK)

    def wanted(filming: "Filming") -> "list[Reel]":
        reels = filming.reels(camera, span, times)
        return [_still_reel(reel, first=span is not None) for reel in reels[:1]] if quality == "still" else reels

    fit = FittedFilm(filming, wanted(filming)) if minutes is None else fitted(filming, wanted, minutes)
    if (where := where_of(workers, ray, store, runs)) is not None:
        if quality == "still" or shard or join or minutes is not None:
            message = "cannot be used with still, --minutes, --shard, --join"
            raise typer.BadParameter(message, param_hint="'--workers', '--ray'")
        parts = {"camera": camera, "span": span, "during": times}
        _trace_in_many(fit, chosen, where, parts, samples, frames_only or "png", quiet=as_json)
    whole, stop = span is None and times is None, Stop()
    suffix = partial(_suffix, fit.filming, whole=whole)
    reporter = ProgressReporter(fit.reels, quiet=as_json)
    if not join and quality != "still" and not frames_only and shard_of == (0, 1):
        with stop:
            made = trace_films(fit, reporter, stop, minutes or inf, suffix)
        if whole:
            from text2sim.rendering.legibility import write_legibility

            write_legibility(fit.filming, fit.reels)
    else:
        made = dict.fromkeys(_pictures(fit, reporter, shard_of, frames_only, suffix, join=join), 0)
    _say_made(made, reporter, shard_of, as_json)
    raise typer.Exit(exits.INTERRUPTED if stop.count else exits.OK)


def _trace_in_many(
    fit: "FittedFilm",
    chosen: Chosen,
    where: "Placement",
    parts: dict[str, Any],
    samples: int | None,
    format: "Format",
    *,
    quiet: bool,
) -> None:
    """Trace the pictures of a film in several processes."""
    film = fit.filming
    how = {"quality": film.quality, "size": film.size, "samples": samples, "fps": film.fps, "format": format}
    trace(chosen, where, {**how, "reels": parts}, sum(len(reel.frames) for reel in fit.reels), quiet=quiet)


def _pictures(
    fit: "FittedFilm",
    report: "Callable[[FilmProgress], None]",
    shard: tuple[int, int],
    frames_only: "Format | None",
    suffix: "Callable[[Reel], str]",
    *,
    join: bool,
) -> list[Path]:
    """Trace pictures, or only gather those of shards; return them, or films made of them, or nothing for a shard."""
    filming, files = fit.filming, list[Path]()
    format: Format = frames_only or "png"
    for reel in fit.reels:
        paths = [filming.finished(f, format) for f in reel.frames] if join else []
        paths = paths or filming.render(reel, report, shard=shard, format=format)
        if shard != (0, 1):
            continue
        if filming.quality == "still" or frames_only:
            files += _numbered(filming, reel, paths)
        else:
            files.append(filming.encode(reel, suffix(reel)))
    return files


def _say_made(made: dict[Path, int], reporter: "ProgressReporter", shard: tuple[int, int], as_json: bool) -> None:
    """Print the files, with the numbers of missing pictures."""
    if as_json:
        files = [str(path) for path in made]
        say_json({"ok": True, "files": files, "missing": sum(made.values()), "seconds": reporter.mean()})
    elif shard != (0, 1):
        say(f"part {shard[0] + 1} of {shard[1]} is rendered; when all are, add --join")
    elif made:
        path, missing = next(iter(made.items()))
        some = f" ({missing} pictures are missing: earlier ones are shown longer; the same command continues)"
        say(f"{'film' if path.suffix == '.mp4' else 'picture'}: {display_path(path)}{some if missing else ''}")


def _render_both(
    left: "Filming",
    right: "Filming",
    camera: str,
    span: tuple[int, int] | None,
    times: tuple[float, float] | None,
    *,
    join: bool,
    quiet: bool,
) -> Path:
    """Render the main films of two runs, and combine them into one."""
    from text2sim.comparison.runs import read_runs
    from text2sim.rendering.beside import beside

    one, other = left.recording, right.recording
    if left.fps != right.fps:
        rates = f"{one.folder} has {left.fps:g}, {other.folder} has {right.fps:g}"
        raise RunError(f"films side by side need one `fps`: {rates}")
    reels = left.reels(camera, span, times)[0], right.reels(camera, span, times)[0]
    if not join:
        reporter = ProgressReporter(list(reels), quiet=quiet)
        left.render(reels[0], reporter)
        right.render(reels[1], reporter)
    try:
        first, second = (run.label for run in read_runs([one.folder, other.folder]))
    except RunError:  # a run without evidence can be shown, too
        first, second = one.folder.name, other.folder.name
    longer = max(reels, key=lambda reel: len(reel.frames))
    suffix = _suffix(left, longer, whole=span is None and times is None)
    name = f"{reels[0].name}_beside_{other.folder.name}{suffix}"
    return beside((left, right), reels, (first, second), name)


def _suffix(filming: "Filming", reel: "Reel", *, whole: bool) -> str:
    """Suffix of a film's file name, so that it does not overwrite the case's own film."""
    from text2sim.rendering.trace import QUALITIES

    rate = "" if filming.fps == filming.recording.film["fps"] else f"_{filming.fps:g}fps"
    samples = "" if filming.samples == QUALITIES[filming.quality].samples else f"_{filming.samples}spp"
    return rate + samples + ("" if whole else f"_{reel.frames[0].k}-{reel.frames[-1].k}")


def _still_reel(reel: "Reel", *, first: bool) -> "Reel":
    """Reel of a single frame: the first, or the middle one."""
    from text2sim.rendering.film import Reel

    return Reel(reel.name, [reel.frames[0 if first else len(reel.frames) // 2]])


def _numbered(filming: "Filming", reel: "Reel", paths: list[Path]) -> list[Path]:
    """Copy finished frames to numbered files."""
    from text2sim.rendering.frames import save

    folder, made = filming.folder / reel.name, []
    if not paths or paths[0].suffix == ".exr":
        for frame, path in zip(reel.frames, paths, strict=True):
            made.append(folder / f"{frame.k:05d}.exr")
            save(made[-1], lambda part, path=path: shutil.copyfile(path, part))
        return made
    from PIL import Image

    for frame, image in zip(reel.frames, filming.pictures(reel, paths), strict=True):
        single = filming.quality == "still"
        made.append(filming.folder / f"{reel.name}.png" if single else folder / f"{frame.k:05d}.png")
        save(made[-1], lambda part, image=image: Image.fromarray(image).save(part, format="png"))
    return made


def frame_range(text: str) -> tuple[int, int] | None:
    """Return the first picture of `--frames` and the one after the last; None if the option is left out.

    Raises:
        typer.BadParameter: If the text cannot be understood.
    """
    first, colon, end = text.partition(":")
    try:
        if not text:
            return None
        start = int(first or 0)
        span = start, (int(end) if end else sys.maxsize) if colon else start + 1
    except ValueError:
        span = (0, 0)
    if not 0 <= span[0] < span[1]:
        raise typer.BadParameter(f"{text}: write 10:20, or 10", param_hint="'--frames'")
    return span


def time_range(text: str) -> tuple[float, float] | None:
    """Return the times of `--during` [s]; None if the option is left out.

    Raises:
        typer.BadParameter: If the text cannot be understood.
    """
    first, colon, end = text.partition(":")
    try:
        if not text:
            return None
        begin, until = float(first), float(end if colon else "")
    except ValueError:
        begin, until = 1.0, 0.0
    if not 0 <= begin <= until < float("inf"):
        raise typer.BadParameter(f"{text}: write 0.2:1.5, from and to in seconds", param_hint="'--during'")
    return begin, until


def shard_numbers(text: str) -> tuple[int, int]:
    """Return the number of the part of `--shard`, from 0, and the number of parts.

    Raises:
        typer.BadParameter: If the text cannot be understood.
    """
    if not text:
        return 0, 1
    number, _, count = text.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise typer.BadParameter(f"{text}: write 1/4 for the first of four", param_hint="'--shard'")
    return int(number) - 1, int(count)


def film_size(text: str) -> tuple[int, int] | None:
    """Return width and height of `--resolution` [pixels]; None if the option is left out.

    Raises:
        typer.BadParameter: If the text cannot be understood.
    """
    if not text:
        return None
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()) or any(
        not 16 <= int(n) <= 8192 or int(n) % 2 for n in (width, height)
    ):
        raise typer.BadParameter(f"{text}: write 1280x720, even numbers", param_hint="'--resolution'")
    return int(width), int(height)
