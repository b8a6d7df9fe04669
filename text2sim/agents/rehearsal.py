"""Rehearsal of a plan: a case of stand-in bodies is checked before the Writers start.

Positions and sizes of bodies are not known yet. A finding of the lint counts only if it appears in very different
arrangements, one of them with all bodies in one place, and one for each region that a measure names, with all of them
in it: then it follows from the definitions of measures and events.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, get_args

from text2sim.agents.contract import numbered_copies
from text2sim.agents.counterfactual import cause_faults
from text2sim.agents.language import body_kinds, mount_kinds, shape_kinds
from text2sim.agents.replies import CasePlan, Fragments
from text2sim.agents.stand_ins import ARRANGEMENTS, Arrangement, prefab_arguments, rehearsal_text
from text2sim.card_library.model import Mode
from text2sim.spec_schema.arithmetic.expressions import RESERVED
from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.resolution import COPY_VARIABLES
from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.errors import Problem, SpecError, Text2SimError, nearest
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.names.selectors import strings_in
from text2sim.spec_schema.reuse.multiples import NUMBER

Data = dict[str, Any]
MAX_REGIONS = 4
"""Largest number of regions in which all bodies are put."""
RESERVED_NAMES = (*sorted({*COPY_VARIABLES, NUMBER}), *sorted(RESERVED))
"""Names that expressions reserve, so that no parameter can have them."""
MODES = get_args(Mode)
IGNORED_RULES = frozenset(
    {"unknown-attach", "unknown-spring", "never-released", "unknown-bond", "not-bonded", "no-domain", "no-thread"}
)
"""Rules about parts and shapes that the Writers will add."""
DEFINITION_RULES = frozenset({"cannot-fail", "cannot-hold", "contradiction", "dead-event"})
PART_REMEDY = "; name a whole body, or plan the part as a body of its own or as a link of an `articulated` one"
MAX_BODIES = 300
"""Largest number of bodies for which the lint runs, since the Planner waits for it."""
JOINT_MEASURES = ("joint_position", "joint_velocity", "joint_force")
_START_VALUE = re.compile(r"at the start it is \S+")
_PATH_PREFIXES = (("/actions/", "/checks/"), ("/scene/duration", "/duration"), ("/params", "/params"))


def plan_faults(plan: CasePlan, path: Path) -> list[str]:
    """Return the faults of a plan that can be found before anything is written."""
    words = [*_shape_faults(plan), *_word_faults(plan), *_bound_faults(plan)]
    if wrong := list(_kind_faults(plan)):
        return wrong + words  # measures can only be checked once the kinds of bodies are known
    try:
        loaded = load_text(rehearsal_text(plan, plan.checks, ARRANGEMENTS[0]), path)
        from text2sim.spec_schema.names.references import check_references

        problems = check_references(loaded)
    except SpecError as error:
        return [*words, *(row for row in _in_terms_of_plan(error.problems) if row not in words)]
    words += _fact_faults(plan, path)
    if wrong := [*words, *(row for row in _in_terms_of_plan(problems) if row not in words)]:
        return wrong
    wrong = cause_faults(loaded.written.data, plan) + _definition_faults(plan, path)
    named = {row.split(":")[0].split("/")[3] for row in wrong if row.startswith("/checks/expect/")}
    return wrong + [row for name, row in _rest_faults(plan, loaded) if name not in named]


def _in_terms_of_plan(problems: Iterable[Problem]) -> Iterator[str]:
    """Yield problems in terms of the plan, without those of the stand-ins."""
    for problem in problems:
        for ours, plans in _PATH_PREFIXES:
            if problem.severity == "error" and problem.rule not in IGNORED_RULES and problem.path.startswith(ours):
                remedy = f"; taken are {', '.join(RESERVED_NAMES)}" if problem.rule == "taken-name" else ""
                remedy = PART_REMEDY if problem.rule == "unknown-link" else remedy
                where = f"{plans}{problem.path.removeprefix(ours)}"
                yield f"{where}: {problem.message}{_hint(problem)}{remedy} [{problem.rule}]"


def _hint(problem: Problem) -> str:
    return f"; did you mean `{problem.hint}`?" if problem.hint else ""


def _fact_faults(plan: CasePlan, path: Path) -> list[str]:
    """Facts about parts that cannot be measured, as the reference check of a case finds them."""
    measures: Data = {}
    events: Data = {}
    about: dict[str, str] = {}
    for requirement, claims in plan.facts.items():
        for claim in claims:
            name, subject = f"fact_{len(about)}", getattr(claim, claim.sort)
            about[name] = requirement
            events |= {f"{name}_{k}": {"kind": "contact", "between": [subject, by]} for k, by in enumerate(claim.by)}
            if claim.sort in ("moved", "count", "seen"):
                measures[name] = {"kind": "position", "of": subject, "axis": "z"}
    checks = Fragments(measures=measures, events=events)
    if not any("." in word for word in strings_in([measures, events])):
        return []
    try:
        from text2sim.spec_schema.names.references import check_references

        problems = check_references(load_text(rehearsal_text(plan, checks, ARRANGEMENTS[0]), path))
    except SpecError:
        return []  # what else is wrong with a fact shows when it is computed
    rows = [
        f"/facts/{about['_'.join(p.path.split('/')[3].split('_')[:2])]}: {p.message}{_hint(p)}{PART_REMEDY}"
        for p in problems
        if p.rule == "unknown-link" and p.path.startswith(("/actions/measures/", "/actions/events/"))
    ]
    return list(dict.fromkeys(rows))


def _bound_faults(plan: CasePlan) -> Iterator[str]:
    """Report both sorts of bounds: one may be left where `changes` gave only the other."""
    for name, row in plan.checks.expect.items():
        if row.get("equals") is not None and not (row.get("above") is None and row.get("below") is None):
            yield f"/checks/expect/{name}: either `equals` with `tolerance`, or `above` and `below` (null removes one)"


# --- words ---------------------------------------------------------------------------------------------------------


def _kind_faults(plan: CasePlan) -> Iterator[str]:
    kinds, mounts = [*body_kinds(), "static", *prefab_arguments()], mount_kinds()
    for name, body in plan.bodies.items():
        if body.kind not in kinds:
            yield _unknown_word(f"/bodies/{name}/kind", body.kind, kinds, "static, a kind of body or a prefab")
        if body.mount and body.mount not in mounts:
            yield _unknown_word(f"/bodies/{name}/mount", body.mount, mounts, "a mount")


def _shape_faults(plan: CasePlan) -> Iterator[str]:
    """Faults of shapes and modes; a shape may be several words, such as `box and cylinders`."""
    shapes = shape_kinds()
    known = {*shapes, *prefab_arguments()}
    for name, body in plan.bodies.items():
        words = re.findall(r"[a-z][a-z_]*", body.shape.lower())
        if body.shape and not known & {*words, *(word.removesuffix("s") for word in words)}:
            yield _unknown_word(f"/bodies/{name}/shape", body.shape, shapes, "a kind of shape")
    for mode in plan.mode:
        if mode not in MODES:
            yield _unknown_word("/mode", mode, MODES, "a mode")


def _unknown_word(where: str, word: str, known: Iterable[str], what: str) -> str:
    known = list(known)
    hint = nearest(word, known)
    return f"{where}: `{word}` is not {what}{f'; did you mean `{hint}`?' if hint else ''}; there are {', '.join(known)}"


def _word_faults(plan: CasePlan) -> Iterator[str]:
    """Faults of `${…}` in texts, which Writers copy."""
    words = [(f"/shared/{k}", line) for k, line in enumerate(plan.shared)]
    words += [(f"/bodies/{name}/what", body.what) for name, body in plan.bodies.items()]
    words += [(f"/briefs/{section}", line) for section, line in plan.briefs.items()]
    known = {*plan.params, *COPY_VARIABLES, NUMBER}
    if NUMBER in plan.params:  # an error as soon as a Writer uses `repeat`
        remedy = f"choose another name; taken are {', '.join(RESERVED_NAMES)} [taken-name]"
        yield f"/params/{NUMBER}: `{NUMBER}` is the number of an entry with repeat; {remedy}"
    for where, text in words:
        if "${" not in text:
            continue
        try:
            strange = parse_interpolation(text).names - known
        except ExpressionError as error:
            yield f"{where}: {error}"
            continue
        for name in sorted(strange):
            hint = nearest(name, known)
            yield f"{where}: `{name}` is not in `params`" + (f"; did you mean `{hint}`?" if hint else "")


# --- findings that follow from definitions -------------------------------------------------------------------------


def _definition_faults(plan: CasePlan, path: Path) -> list[str]:
    """Expectations that cannot hold or cannot fail, wherever the bodies are placed."""
    if sum(body.count for body in plan.bodies.values()) > MAX_BODIES:
        return []
    checks = _without_joints(plan.checks)
    arrangements = (*ARRANGEMENTS, *_in_regions(checks))
    first, *others = (_lint_findings(rehearsal_text(plan, checks, one, loose=True), path) for one in arrangements)
    confirmed = set.intersection(*({_finding(problem) for problem in found} for found in others))
    return list(_in_terms_of_plan(problem for problem in first if _finding(problem) in confirmed))


def _finding(problem: Problem) -> tuple[str, str, str]:
    """Return what a finding says: one that follows from a value at the start needs the same one wherever bodies are."""
    start = _START_VALUE.search(problem.message)
    return problem.path, problem.rule, start[0] if start else ""


def _in_regions(checks: Fragments) -> list[Arrangement]:
    """Return arrangements of small bodies in the middles of the regions of measures, as far as these are numbers."""
    regions = [row["region"] for row in checks.measures.values() if isinstance(row.get("region"), dict)]
    middles = [region.get("center") for region in regions if region.get("frame") is None]
    known = dict.fromkeys(
        (middle[0], middle[1], middle[2])
        for middle in middles
        if isinstance(middle, list) and len(middle) == 3 and all(isinstance(x, int | float) for x in middle)
    )
    return [Arrangement(0.001, middle, (0.0, 0.0, 0.0)) for middle in known][:MAX_REGIONS]


def _lint_findings(text: str, path: Path) -> list[Problem]:
    """Findings of the lint, all treated as errors."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint.facts import Facts
    from text2sim.lint.rules import RULES

    try:
        facts = Facts(resolve_case(load_text(text, path)))
        found = [problem for rule in RULES if rule.id in DEFINITION_RULES for problem in rule.run(facts)]
    except Text2SimError:
        return []  # an invalid stand-in tells nothing
    return [Problem(p.path, p.message, rule=p.rule) for p in found]


def _without_joints(checks: Fragments) -> Fragments:
    """The checks without those about joints, which loose stand-ins lack."""
    measures = {name: row for name, row in checks.measures.items() if row.get("kind") not in JOINT_MEASURES}
    measures = {name: row for name, row in measures.items() if {*row.get("measures", ())} <= measures.keys()}
    events = {
        name: row
        for name, row in checks.events.items()
        if row.get("kind") not in ("joint_limit", "released", "left_domain")
        if row.get("measure") is None or row["measure"] in measures
    }
    while lost := [name for name, row in events.items() if row.get("after") is not None and row["after"] not in events]:
        events = {name: row for name, row in events.items() if name not in lost}
    expect = {
        name: row
        for name, row in checks.expect.items()
        if row.get("measure") in (None, *measures)
        and all(row.get(key) in (None, *events) for key in ("event", "before", "on"))
    }
    return Fragments(measures=measures, events=events, expect=expect)


def _rest_faults(plan: CasePlan, loaded: LoadedCase) -> Iterator[tuple[str, str]]:
    """Yield the name and the reason for each expectation that holds if nothing happens, whatever the bodies are.

    An expectation that a measure returns to its rest value is allowed if another one requires the same measure to
    differ from it at some time.
    """
    from text2sim.lint.script.outcomes import bound_of

    case = loaded.case
    kept = {copy for name in plan.keeps for copy in numbered_copies(name, case.actions.expect)}
    holding, active = {}, set()
    for name, expect in case.actions.expect.items():
        if expect.on is not None:
            continue  # the event does not happen, so the expectation fails
        if expect.measure is not None:
            value = rest_value(case.actions.measures[expect.measure])
            bound = bound_of(expect, case.scene.duration)
            value = None if value is None else bound.of_constant(value)
            if value is not None and not bound.low < value < bound.high:
                active.add(expect.measure)
            elif value is not None and bound.first > 0.0:
                holding[name] = (expect.measure, f"`{expect.measure}` is {value:g} then")
        else:
            event = case.actions.events[expect.event or ""]
            settled = event.kind == "rest" and event.after is None and not (expect.never or expect.before)
            if settled and expect.count is None:
                what = f"`{expect.event}` has come before anything moves; `after: EVENT` makes it wait"
                holding[name] = ("", what)
    for name, (measure, what) in holding.items():
        if name not in kept and measure not in active:
            yield name, f"/checks/expect/{name}: {HOLDS_AT_REST.format(what)}"


HOLDS_AT_REST = (
    "it holds if nothing happens at all: {}. Ask for what is true only after what it stands for has happened; if it is "
    "about something that has to stay as it is, name this expectation in `keeps`"
)


def rest_value(measure: Any) -> float | None:
    """Return the value of a measure while nothing happens, whatever the case; None if there is none such."""
    value, stat = measure.at_rest, getattr(measure, "stat", None)
    changes = measure.change_from is not None or measure.so_far == "range"
    if value is None or changes or stat not in ("count", "range", "sum"):
        return value
    if stat == "count":
        above, below = measure.above, measure.below
        none = (above is not None and value <= above) or (below is not None and value >= below)
        return 0.0 if none else None
    return None if stat == "sum" and value else 0.0


def held_at_start(loaded: LoadedCase, names: Iterable[str]) -> dict[str, str]:
    """Return which named expectations hold if nothing happens, although they apply after the start, and why.

    What is asked of the time before anything happens is not meant: it describes the start.
    """
    from text2sim.compiler.build import resolve_case
    from text2sim.lint.facts import Facts
    from text2sim.lint.script.at_rest import beginning, passes
    from text2sim.lint.script.outcomes import bound_of

    facts, found = Facts(resolve_case(loaded)), {}
    begins = beginning(facts)
    for name in (copy for written in names for copy in numbered_copies(written, loaded.case.actions.expect)):
        expect = loaded.case.actions.expect.get(name)
        if expect is None or expect.measure is None:
            continue
        bound = bound_of(expect, loaded.case.scene.duration)
        if bound.first <= 0.0 or bound.last <= begins:
            continue
        if passes(facts, expect):
            found[name] = f"/actions/expect/{name}: " + HOLDS_AT_REST.format(
                f"`{expect.measure}` is so at the start already"
            )
    return found
