"""The command `text2sim render`."""

import sys
from collections.abc import Callable
from math import inf
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from text2sim.cli.many import Ray, StoreUrl, Workers, where_of
from text2sim.cli.options import AsJson
from text2sim.service import exits
from text2sim.spec_schema.plain import plain_line

if TYPE_CHECKING:
    from text2sim.rendering.budget import FittedFilm
    from text2sim.rendering.film import Filming, FilmProgress, Reel
    from text2sim.runtime.stop import Stop

LINE_INTERVAL = 15.0
"""Wall time [s] between lines of progress."""


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
        int, typer.Option("--samples", min=0, max=4096, help="Samples per pixel; the quality's if left out.")
    ] = 0,
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
    runs: Annotated[Path, typer.Option("--runs", help="Folder of the runs of cases.")] = Path("runs"),
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
    from text2sim.cli.output import say, say_json
    from text2sim.cli.recorded import choose
    from text2sim.rendering.budget import FittedFilm, fitted
    from text2sim.rendering.film import Filming
    from text2sim.rendering.renderer import find_variant
    from text2sim.runtime.stop import Stop
    from text2sim.service.phrases import display_path

    span, part, size, times = _span(frames), _shard(shard), _size(resolution), _times(during)
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

    whole, pictures, stop = span is None and times is None, quality == "still" or bool(frames_only), Stop()
    fit = FittedFilm(filming, wanted(filming)) if minutes is None else fitted(filming, wanted, minutes)
    filming, reels = fit.filming, fit.reels
    if (where := where_of(workers, ray, store, runs)) is not None:
        from text2sim.cli.many import trace

        if quality == "still" or shard or join or minutes is not None:
            message = "cannot be used with still, --minutes, --shard, --join"
            raise typer.BadParameter(message, param_hint="'--workers', '--ray'")
        those = {"camera": camera, "span": span, "during": times}
        how = {
            "quality": quality,
            "size": filming.size,
            "samples": samples,
            "fps": filming.fps,
            "format": frames_only or "png",
        }
        trace(chosen, where, {**how, "reels": those}, sum(len(reel.frames) for reel in reels), quiet=as_json)
    teller = Teller(reels, quiet=as_json)
    if not join and not pictures and part == (0, 1):
        with stop:
            made = trace_films(fit, teller, stop, minutes or inf, lambda reel: _part(filming, reel, whole=whole))
        if whole:
            from text2sim.rendering.legibility import write_legibility

            write_legibility(filming, reels)
    else:
        files: list[Path] = []
        for reel in reels:
            format = frames_only or "png"
            paths = [filming.finished(f, format) for f in reel.frames] if join else []
            paths = paths or filming.render(reel, teller, shard=part, format=format)
            if part == (0, 1):
                suffix = _part(filming, reel, whole=whole)
                files += _numbered(filming, reel, paths) if pictures else [filming.encode(reel, suffix)]
        made = dict.fromkeys(files, 0)
    _say_made(made, teller, part, as_json)
    raise typer.Exit(exits.INTERRUPTED if stop.count else exits.OK)


def _say_made(made: dict[Path, int], teller: "Teller", part: tuple[int, int], as_json: bool) -> None:
    """Print the files, with the numbers of missing pictures."""
    from text2sim.cli.output import say, say_json
    from text2sim.service.phrases import display_path

    if as_json:
        files = [str(path) for path in made]
        say_json({"ok": True, "files": files, "missing": sum(made.values()), "seconds": teller.mean()})
    elif part != (0, 1):
        say(f"part {part[0] + 1} of {part[1]} is rendered; when all are, add --join")
    elif made:
        path, missing = next(iter(made.items()))
        some = f" ({missing} pictures are missing: earlier ones are shown longer; the same command continues)"
        say(f"{'film' if path.suffix == '.mp4' else 'picture'}: {display_path(path)}{some if missing else ''}")


def trace_films(
    fit: "FittedFilm",
    tell: "Callable[[FilmProgress], None]",
    stop: "Stop",
    minutes: float = inf,
    part: "Callable[[Reel], str]" = lambda reel: "",
) -> dict[Path, int]:
    """Trace and encode films; from the finished frames if stopped or out of time.

    Args:
        fit: The films.
        tell: Called after each frame.
        stop: Counter of stop signals.
        minutes: Approximate time after which no further frame is begun [min].
        part: Returns the suffix of a film's file name.

    Returns:
        The number of missing frames of each film.

    Raises:
        KeyboardInterrupt: if it was stopped with hardly any finished frames.
    """
    from text2sim.rendering.budget import OVERTIME, encode_films

    until = monotonic() + 60 * minutes * OVERTIME
    try:
        for reel in fit.reels:
            fit.filming.render(reel, tell, until=until)
    except KeyboardInterrupt:
        stop.request()
    with stop.gently():
        made = encode_films(fit.filming, fit.reels, part)
    if not made:
        raise KeyboardInterrupt
    return made


class Teller:
    """Reporter of a render's progress and remaining time: a live line on a terminal, else occasional lines."""

    def __init__(self, reels: "list[Reel]", *, quiet: bool) -> None:
        self._total, self._done, self._traced = sum(len(reel.frames) for reel in reels), 0, 0
        self._begun = self._next = monotonic()
        self._quiet, self._sums = quiet, {}

    def __call__(self, progress: "FilmProgress") -> None:
        """Count a finished frame and report."""
        self._done += 1
        if progress.seconds:
            self._traced += 1
            for name, value in progress.seconds.items():
                self._sums[name] = self._sums.get(name, 0.0) + value
        now = monotonic()
        live = sys.stderr.isatty()
        if self._quiet or not (live or now >= self._next or self._done == self._total):
            return
        self._next = now + LINE_INTERVAL
        left = ""
        if self._traced and self._done < self._total:
            from text2sim.service.phrases import duration_text

            each = (now - self._begun) / self._traced
            left = f", {each:.1f} s each, {duration_text(each * (self._total - self._done))} left"
        text = f"rendering {progress.film}: {self._done} of {self._total} pictures{left}"
        ending = "\n" if not live or self._done == self._total else ""
        print(("\r\x1b[K" if live else "") + plain_line(text), end=ending, file=sys.stderr, flush=True)

    def mean(self) -> dict[str, float]:
        """Return the mean time of a frame by part [s]."""
        return {name: round(value / max(self._traced, 1), 3) for name, value in self._sums.items()}


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
    from text2sim.spec_schema.errors import RunError

    one, other = left.recording, right.recording
    if left.fps != right.fps:
        rates = f"{one.folder} has {left.fps:g}, {other.folder} has {right.fps:g}"
        raise RunError(f"films side by side need one `fps`: {rates}")
    reels = left.reels(camera, span, times)[0], right.reels(camera, span, times)[0]
    if not join:
        teller = Teller(list(reels), quiet=quiet)
        left.render(reels[0], teller)
        right.render(reels[1], teller)
    try:
        first, second = (run.label for run in read_runs([one.folder, other.folder]))
    except RunError:  # a run without evidence can be shown, too
        first, second = one.folder.name, other.folder.name
    longer = max(reels, key=lambda reel: len(reel.frames))
    part = _part(left, longer, whole=span is None and times is None)
    name = f"{reels[0].name}_beside_{other.folder.name}{part}"
    return beside((left, right), reels, (first, second), name)


def _part(filming: "Filming", reel: "Reel", *, whole: bool) -> str:
    """Suffix of a film's file name, so that it does not overwrite the case's own film."""
    rate = "" if filming.fps == filming.recording.film["fps"] else f"_{filming.fps:g}fps"
    return rate + ("" if whole else f"_{reel.frames[0].k}-{reel.frames[-1].k}")


def _still_reel(reel: "Reel", *, first: bool) -> "Reel":
    """Reel of a single frame: the first, or the middle one."""
    from text2sim.rendering.film import Reel

    return Reel(reel.name, [reel.frames[0 if first else len(reel.frames) // 2]])


def _numbered(filming: "Filming", reel: "Reel", paths: list[Path]) -> list[Path]:
    """Copy finished frames to numbered files."""
    import shutil

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


def _span(text: str) -> tuple[int, int] | None:
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


def _times(text: str) -> tuple[float, float] | None:
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


def _shard(text: str) -> tuple[int, int]:
    if not text:
        return 0, 1
    number, _, count = text.partition("/")
    if not (number.isdigit() and count.isdigit() and 1 <= int(number) <= int(count)):
        raise typer.BadParameter(f"{text}: write 1/4 for the first of four", param_hint="'--shard'")
    return int(number) - 1, int(count)


def _size(text: str) -> tuple[int, int] | None:
    if not text:
        return None
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit()) or any(
        not 16 <= int(n) <= 8192 or int(n) % 2 for n in (width, height)
    ):
        raise typer.BadParameter(f"{text}: write 1280x720, even numbers", param_hint="'--resolution'")
    return int(width), int(height)
