"""Values of the options of `text2sim render`."""

import sys

import typer


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
    if not (number.isdigit() and count.isdigit() and 1 <= int(number) <= int(count)):
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
    if not (width.isdigit() and height.isdigit()) or any(
        not 16 <= int(n) <= 8192 or int(n) % 2 for n in (width, height)
    ):
        raise typer.BadParameter(f"{text}: write 1280x720, even numbers", param_hint="'--resolution'")
    return int(width), int(height)
