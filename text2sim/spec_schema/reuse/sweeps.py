"""Sweeps: checks of their form, and their runs."""

from dataclasses import replace
from itertools import product
from typing import Any

from pydantic import ValidationError

from text2sim.spec_schema.errors import Problem, SpecError, nearest, there_are
from text2sim.spec_schema.models.sweep_models import MAX_RUNS, Sweep
from text2sim.spec_schema.paths import parse_dotted
from text2sim.spec_schema.reuse.migration import migrate
from text2sim.spec_schema.reuse.overlay import CaseOverlay
from text2sim.spec_schema.reuse.overlay_check import check_names, check_overlay, unknown_overlay
from text2sim.spec_schema.text.document import Document, Path, mapping_at, parse_document
from text2sim.spec_schema.text.source import Source, check_source
from text2sim.spec_schema.text.writing import flow_text
from text2sim.spec_schema.vocabulary.diagnosis import diagnose
from text2sim.spec_schema.vocabulary.slot_path import NoSuchSlot, PrefabInterfaces, check_path


def check_sweeps(document: Document, interfaces: PrefabInterfaces) -> list[Problem]:
    """Return the problems of the sweeps of a case."""
    problems: list[Problem] = []
    variants = mapping_at(document.data, "variants")
    others = list(variants.values())
    for name, data in check_names(document, "sweeps", problems).items():
        path = ("sweeps", name)
        try:
            sweep = Sweep.model_validate(data, by_alias=True, by_name=False)
        except ValidationError as error:
            problems += diagnose(document, error, Sweep, data, path)
            continue
        for dots, values in (sweep.grid or {}).items():
            problems += _check_axis(document, (*path, "grid", dots), values, interfaces)
        for point in sweep.points or ():
            problems += check_overlay(document, (*path, "points", point), others, interfaces)
        for index, variant in enumerate(sweep.variants or ()):
            if variant not in variants:
                existing = there_are(variants, None) or ": the case has no variants"
                message, hint = f"there is no variant `{variant}`{existing}", nearest(variant, variants)
                place = (*path, "variants", index)
                problems.append(document.problem(place, message, rule="unknown-variant", hint=hint))
    return problems


def _check_axis(document: Document, path: Path, values: list[Any], interfaces: PrefabInterfaces) -> list[Problem]:
    """Return the problems of one axis of a grid."""
    try:
        new = any(isinstance(value, dict) for value in values)
        check_path(document.data, parse_dotted(str(path[-1])), interfaces, new=new)
    except NoSuchSlot as error:
        return [document.problem(path, str(error), key=True, rule="unknown-path", hint=error.hint)]
    except ValueError as error:
        return [document.problem(path, f"`{path[-1]}`: {error}", key=True, rule="form")]
    return []


def runs_of(written: Document, name: str) -> list[tuple[str, CaseOverlay]]:
    """Return the runs of a sweep: labels and overlays.

    Args:
        written: The case as it is in its file, with valid sweeps.
        name: Name of the sweep.

    Raises:
        SpecError: If there is no such sweep.
    """
    sweeps = migrate(written)[0].data.get("sweeps")
    if not isinstance(sweeps, dict) or name not in sweeps:
        raise SpecError([unknown_overlay(written, "sweep", name, sweeps)])
    sweep = Sweep.model_validate(sweeps[name], by_alias=True, by_name=False)
    if sweep.points is not None:
        return [(point, CaseOverlay(point=(name, point))) for point in sweep.points]
    if sweep.variants is not None:
        return [(variant, CaseOverlay(variants=(variant,))) for variant in sweep.variants]
    return grid_runs({path: [flow_text(value) for value in values] for path, values in (sweep.grid or {}).items()})


def grid_runs(grid: dict[str, list[str]]) -> list[tuple[str, CaseOverlay]]:
    """Return the runs of a grid, which has values as text by path."""
    short = _short_names(list(grid))
    runs = []
    for values in product(*grid.values()):
        label = ", ".join(f"{name}={value[:30]}" for name, value in zip(short, values, strict=True))
        sets = tuple(f"{path}={value}" for path, value in zip(grid, values, strict=True))
        runs.append((label, CaseOverlay(sets=sets)))
    return runs


def parse_grid(options: list[str]) -> dict[str, list[str]]:
    """Return the values, as text by path, of options `path=[a, b, c]`.

    Raises:
        SpecError: If an option is invalid, or there are too many runs.
    """
    source = Source("\n".join(options), "--grid")
    grid: dict[str, list[str]] = {}
    size, start = 1, 0
    for words in options:
        path, _, text = words.partition("=")
        line, column = source.place(start)
        start += len(words) + 1
        try:
            values = parse_document(check_source(Source(text, "--grid"))).data if text.strip() else None
        except SpecError as error:
            found = replace(error.problems[0], path="", line=line, column=len(path) + 2, file="--grid")
            raise SpecError([found]) from None
        if not isinstance(values, list) or not values or not path.strip():
            message = (
                f"`{words[:80]}` is not an axis: write PATH=[a, b, c], as in bodies.ball.material.density=[500, 1000]"
            )
            raise SpecError([Problem("", message, line, column, "--grid", rule="form")])
        if path.strip() in grid:
            message = f"`{path.strip()[:80]}` is given twice; put all its values into one list"
            raise SpecError([Problem("", message, line, column, "--grid", rule="form")])
        grid[path.strip()] = [flow_text(value) for value in values]
        size *= len(values)
    if size > MAX_RUNS:
        message = f"a sweep may have at most {MAX_RUNS} runs (got {size})"
        raise SpecError([Problem("", message, 1, 1, "--grid", rule="length")])
    return grid


def _short_names(paths: list[str]) -> list[str]:
    """Return the shortest unique suffix of each path."""
    for count in (1, 2, 3):
        names = [".".join(path.split(".")[-count:]) for path in paths]
        if len(set(names)) == len(names):
            return names
    return paths
