"""Checks of a recipe against its cases, with problems at their places in the recipe."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from text2sim.dataset.draws import draw, generator, overlay_of
from text2sim.dataset.recipe import FILM_GROUPS, CaseSource, Draws, Recipe, parse_recipe
from text2sim.dataset.splits import deal_splits
from text2sim.lint.rules import EARLIER_RULES, RULES
from text2sim.service.examined import Examined, case_file, examine, find_cases
from text2sim.spec_schema.errors import Problem, RunError, SpecError, Text2SimError, nearest
from text2sim.spec_schema.reuse.overlay import CaseOverlay
from text2sim.spec_schema.reuse.sweeps import runs_of
from text2sim.spec_schema.text.document import Document, parse_document
from text2sim.spec_schema.text.document import Path as Place
from text2sim.spec_schema.text.source import read_source


def read_recipe(path: Path) -> tuple[Recipe, list[Problem]]:
    """Read a recipe and check it against its cases; return it with the warnings.

    Raises:
        SpecError: with all problems and their places.
    """
    text = read_source(path)
    recipe, document = parse_recipe(text), parse_document(text)
    if problems := list(dict.fromkeys(misfits(recipe, document, path.parent))):
        raise SpecError(problems)
    return recipe, [*_idle_draws(recipe, document)]


def _idle_draws(recipe: Recipe, document: Document) -> Iterator[Problem]:
    """Yield warnings of draws that no film uses: the first film of a simulation is as in the case."""
    for name, source in recipe.sources.items():
        for group in FILM_GROUPS:
            if source.films == 1 and getattr(source, group):
                where = ("sources", name, group)
                message = f"`{group}` is not drawn: the first film of a simulation is as in the case; use `films: 2`"
                yield document.problem(where, message, key=True, rule="unused", severity="warning")


def misfits(recipe: Recipe, document: Document, root: Path) -> Iterator[Problem]:
    """Yield what a recipe needs from its cases and they lack. Problems of the cases themselves are left out.

    Args:
        recipe: The recipe.
        document: Its text.
        root: Folder that its paths are relative to.
    """
    named, known = [], [*(rule.id for rule in RULES), *EARLIER_RULES]
    for key in ("benchmarks", "judged"):
        yield from _missing_cases(document, (key,), getattr(recipe, key), root)
    for name, source in recipe.sources.items():
        where = ("sources", name)
        yield from _missing_cases(document, (*where, "cases"), source.cases, root)
        for k, rule in enumerate(source.refuse):
            if rule not in known:
                message = f"there is no rule `{rule}`; `text2sim check --rules` lists them"
                yield document.problem((*where, "refuse", k), message, rule="unknown-rule", hint=nearest(rule, known))
        for case in find_cases(root / path for path in source.cases):
            plain = examine(case, to="loaded")
            if plain.loaded is not None:
                named.append((name, plain.name))
                yield from _case_misfits(document, where, source, case, plain)
    try:
        deal_splits(recipe, named)
    except RunError as error:
        yield document.problem(("sources",), str(error), rule="inconsistent")


def _missing_cases(document: Document, where: Place, paths: Iterable[str], root: Path) -> Iterator[Problem]:
    for k, path in enumerate(paths):
        if not (root / path).exists():
            message = f"there is no file or folder `{path}` relative to the recipe"
            yield document.problem((*where, k), message, rule="unreadable")
        elif where[-1] != "judged" and not any(case_file(case).is_file() for case in find_cases([root / path])):
            yield document.problem((*where, k), f"there is no case in `{path}`", rule="unreadable")


def _case_misfits(
    document: Document, where: Place, source: CaseSource, case: Path, plain: Examined
) -> Iterator[Problem]:
    """Yield what a source needs from one of its cases and the case lacks."""
    assert plain.loaded is not None
    bases = [CaseOverlay()] if source.plain else []
    for k, variant in enumerate(source.variants):
        found = examine(case, to="loaded", overlay=CaseOverlay(variants=(variant,)))
        lacking = [problem for problem in found.problems if problem.file == "--variant"]
        yield from (_relocated(document, (*where, "variants", k), problem) for problem in lacking)
        bases += [] if lacking else [found.overlay]
    if source.sweep is not None:
        try:
            bases += [overlay for _, overlay in runs_of(plain.loaded.written, source.sweep)]
        except SpecError as error:
            yield from (_relocated(document, (*where, "sweep"), problem) for problem in error.problems)
    for base in bases:
        first = examine(case, to="loaded", overlay=base)
        if first.loaded is None:
            continue
        drawn = yield from _draw_misfits(document, (*where, "physics"), source.physics, case, first)
        yield from _expectation_misfits(document, where, source, drawn)
        tables = {("counterfactuals", name): table for name, table in source.counterfactuals.items()}
        tables |= {(group,): getattr(source, group) for group in FILM_GROUPS}
        for place, table in tables.items():
            yield from _draw_misfits(document, (*where, *place), table, case, drawn)


def _draw_misfits(document: Document, where: Place, table: Draws, case: Path, examined: Examined) -> Any:
    """Yield problems of the paths of a table; return the case with a draw, or without it if the draw is invalid."""
    assert examined.loaded is not None
    overlay, paths = examined.overlay, []
    for path, distribution in table.items():
        try:
            sets = overlay_of(draw({path: distribution}, generator(0, path), examined.loaded.data))
        except Text2SimError as error:
            yield document.problem((*where, path), f"{error} (in {case_file(case)})", rule="unknown-path")
        else:
            overlay, paths = overlay + sets, [*paths, path]
    found = examine(case, to="loaded", overlay=overlay)
    # Each line of `--set` is one value of the overlay.
    wrong = {
        problem.line - 1 - len(examined.overlay.sets): problem for problem in found.problems if problem.file == "--set"
    }
    yield from (
        _relocated(document, (*where, paths[k]), problem, f" (in {case_file(case)})", key=True)
        for k, problem in wrong.items()
        if 0 <= k < len(paths)
    )
    return found if found.loaded is not None else examined


def _expectation_misfits(document: Document, where: Place, source: CaseSource, drawn: Examined) -> Iterator[Problem]:
    assert drawn.loaded is not None
    known = [*drawn.loaded.case.actions.expect]
    for key in ("holds", "fails"):
        names = getattr(source, key)
        if isinstance(names, str) and not known:
            yield document.problem((*where, key), f"{drawn.title} has no expectations", rule="unknown-name")
            continue
        for k, name in enumerate([] if isinstance(names, str) else names):
            if name not in known:
                message = f"{drawn.title} has no expectation `{name}`; there are {', '.join(known) or 'none'}"
                yield document.problem((*where, key, k), message, rule="unknown-name", hint=nearest(name, known))
            elif key == "fails" and (source.holds == "all" or name in source.holds):
                message = f"`{name}` cannot both hold and fail"
                yield document.problem((*where, key, k), message, rule="inconsistent")


def _relocated(document: Document, where: Place, problem: Problem, more: str = "", *, key: bool = False) -> Problem:
    """A problem of an overlay, at the place in the recipe that the overlay comes from."""
    at = document.problem(where, problem.message + more, rule=problem.rule, hint=problem.hint, key=key)
    return replace(at, severity=problem.severity)
