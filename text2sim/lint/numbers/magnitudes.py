"""Sizes, masses and positions that the engine's contacts or single precision cannot handle."""

import math
from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.settings import MIN_TIMECONST
from text2sim.compiler.shapes.boxes import sides
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.words import length, more_copies, vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.rounding import at_most

SAG_FACTOR = 0.11
"""Depth [m] to which a sphere sinks into its support, over gravity [m/s2] and the timeconst [s] squared. Measured:
spheres of 0.5 to 10 mm at 10 ms: 0.11 mm; boxes half of that."""
MAX_SUNK_SHARE, SUNK_ERROR_SHARE = 0.05, 0.25
"""Shares of its thickness by which a body sinks: the largest without a warning, and the smallest that is an error."""
MAX_WALL_SUNK_SHARE = 0.1
"""Like `MAX_SUNK_SHARE`, for the compliance of contacts: the wall of a glass may yield by a tenth of a millimetre."""
MIN_SIZE = 2e-5
"""Size [m] below which the engine fails: at 1 um it does not build, at 10 um bodies fall through the floor."""
LARGE_BODY, VAST_BODY = 50.0, 1e6
"""Sizes [m] of bodies that are probably in millimetres, and at which single precision resolves 6 cm."""
LARGE_STATIC, THICK_STATIC, GIANT_STATIC = 1e5, 10.0, 1000.0
"""Size [m] from which any static is too large; thickness [m] from which one is more than a floor or a wall; and the
largest ratio of such a static to the largest moving body."""
SINKING_PER_MASS = 1.4e-11
"""Depth [m] to which a body sinks per kilogram, at any stiffness: the solver's inverse masses end at 1e-7. Measured: a
box of 1e8 kg sinks 1.4 mm, one of 1e11 kg falls through."""
ROUNDING = 1.2e-7
"""Relative spacing of numbers in single precision."""


def kinds_of(facts: Facts, name: str) -> Iterator[Copy]:
    """Yield one copy of each different shape of a body or static."""
    seen = set()
    for copy in facts.placed[name]:
        key = id(copy.model if copy.shape is None else copy.shape)
        if key not in seen:
            seen.add(key)
            yield copy


def _too_small(facts: Facts) -> Iterator[Problem]:
    settings, scene = facts.settings, facts.case.scene
    sag = SAG_FACTOR * facts.pull * (settings.bounce_time or settings.timeconst) ** 2
    for name in facts.case.bodies:
        thin = min((facts.thinnest(copy) for copy in kinds_of(facts, name) if facts.free(copy)), default=math.inf)
        if thin < MIN_SIZE:
            text = f"`{name}` has a piece of {length(thin)}: the engine fails below 0.02 mm; is the size in metres?"
            yield facts.problem("too-small", facts.first_given(name, "shape"), text, key=True, severity="error")
        elif facts.own_contact and sag > MAX_WALL_SUNK_SHARE * thin and scene.contact.timeconst is None:
            longest = float(at_most(math.sqrt(MAX_WALL_SUNK_SHARE * thin / (SAG_FACTOR * facts.pull))))
            text = (
                f"`{name}` has a piece of {length(thin)} and will sink by {length(sag)} ({sag / thin:.0%} of it) into "
                f"its support at a contact timeconst of {settings.timeconst:g} s"
            )
            if longest >= MIN_TIMECONST and not settings.bounce_time:
                substeps = math.ceil(2 * scene.dt / longest - 1e-9)
                text += f"; use scene.contact.timeconst of {longest:g} s with scene.substeps of {substeps} or more"
            else:
                text += "; simulate such small bodies in a scene of their own, at a larger scale"
            severity = "error" if sag > SUNK_ERROR_SHARE * thin else None
            yield facts.problem("too-small", facts.first_given(name, "shape"), text, key=True, severity=severity)


def _too_large(facts: Facts) -> Iterator[Problem]:
    sizes = {name: max(map(max, _sizes(facts, name)), default=0.0) for name in facts.case.bodies}
    largest = max(sizes.values(), default=0.0)
    for name in (*facts.case.scene.statics, *facts.case.bodies):
        static = name in facts.case.scene.statics
        for copy, box in zip(kinds_of(facts, name), _sizes(facts, name), strict=True):
            size = max(box)
            giant = min(box) > THICK_STATIC and size > max(LARGE_BODY, GIANT_STATIC * largest) and bool(sizes)
            if size <= LARGE_BODY or (static and size <= LARGE_STATIC and not giant):
                continue
            text = f"`{name}` is {length(size)} large{_unit(copy)}"
            if static and giant:
                text += f", and the largest moving body is {length(largest)}"
            text += f"; is its size in metres ({size:.4g} mm are {size / 1000:.4g} m)?"
            severity = "error" if size > VAST_BODY else None
            yield facts.problem("huge-body", facts.first_given(name, "shape"), text, key=True, severity=severity)
            break


def _sizes(facts: Facts, name: str) -> list[tuple[float, ...]]:
    """Return width, depth and height [m] of each different shape of a body or static; 0 for a plane."""
    boxes = [facts.box(copy) for copy in kinds_of(facts, name)]
    return [(0.0,) if box is None else sides(box) for box in boxes]


def _unit(copy: Copy) -> str:
    """Return the advice on the scale of a mesh."""
    shape = copy.shape
    if getattr(shape, "kind", None) != "mesh" or shape.scale != 1.0:
        return ""
    return " (`scale: 0.001` if the file is in millimetres)"


def _too_heavy(facts: Facts) -> Iterator[Problem]:
    if not any(facts.case.scene.gravity):
        return
    for name in facts.case.bodies:
        for copy in kinds_of(facts, name):
            mass, thin = facts.masses.get(copy.name, 0.0), facts.thinnest(copy)
            if SINKING_PER_MASS * mass <= MAX_SUNK_SHARE * thin:
                continue
            text = (
                f"`{name}` has {mass:.2g} kg: the engine's contacts yield by {length(SINKING_PER_MASS * mass)} under "
                f"it at any timeconst, and it is {length(thin)} thick; make it lighter or larger"
            )
            severity = "error" if SINKING_PER_MASS * mass > SUNK_ERROR_SHARE * thin else None
            yield facts.problem("too-heavy", facts.first_given(name, "material"), text, key=True, severity=severity)
            break


def _far_away(facts: Facts) -> Iterator[Problem]:
    for name in facts.case.bodies:
        far = [(copy, thin) for copy in facts.placed[name] if (thin := _remote(facts, copy)) is not None]
        if far:
            copy, thin = far[0]
            away = max(map(abs, copy.pos))
            grain = ROUNDING * away
            text = (
                f"`{copy.name}` starts at {vector(copy.pos)}{more_copies(len(far))}: this far from the origin, the "
                f"engine's single precision has a resolution of {length(grain)}, and it is {length(thin)} thick; "
                "build the scene around the origin"
            )
            severity = "error" if grain > MAX_SUNK_SHARE * thin else None
            where = facts.first_given(name, "pose", "place", "repeat")
            yield facts.problem("far-away", where, text, key=True, severity=severity)


def _remote(facts: Facts, copy: Copy) -> float | None:
    """Return the thickness [m] of the thinnest piece of a copy so far from the origin that rounding matters."""
    away = max(map(abs, copy.pos))
    if away < 100.0:
        return None
    thin = facts.thinnest(copy)
    return thin if ROUNDING * away > MAX_SUNK_SHARE / 10 * thin else None


RULES = (
    Rule(
        id="too-small",
        title="A body is too thin for the contacts of the scene.",
        reason=f"""\
Contacts are soft. A body sinks into its support by about {SAG_FACTOR:g} g T^2 (measured), where T is the contact's
timeconst: 0.1 mm at the usual 10 ms, for any size. For a free body, more than {MAX_WALL_SUNK_SHARE:.0%} of its thinnest
piece is a warning, more than {SUNK_ERROR_SHARE:.0%} an error: stacks collapse into each other. The rule skips cases
that give a timeconst. Bodies of 10 um and less do not simulate at all.""",
        remedy="""\
Shorten `scene.contact.timeconst` (it must be at least two substeps), or check the unit: all lengths are in metres.""",
        example="""\
bodies:
  coin: {kind: rigid, shape: {kind: cylinder, radius: 0.01, height: 0.002}, place: {on: floor}}
""",
        fix="scene: {contact: {timeconst: 0.005}, substeps: 4}",
        run=_too_small,
    ),
    Rule(
        id="huge-body",
        title="A body is so large that its unit is probably wrong.",
        reason=f"""\
Lengths are in metres, but drawings and mesh files often are not. The rule reports bodies of more than {LARGE_BODY:g} m:
a brick of 240 x 115 x 71 is in millimetres, and falls for minutes. It reports statics of more than {LARGE_STATIC:g} m,
or if they are {THICK_STATIC:g} m thick and {GIANT_STATIC:g} times as large as all moving bodies. More than
{VAST_BODY:g} m is an error: single precision resolves 6 cm there.""",
        remedy="Divide millimetres by 1000; give a mesh its `scale`: 0.001 for a file in millimetres.",
        example="""\
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [1200, 800, 800]}, place: {on: floor}}
""",
        fix="bodies: {crate: {shape: {size: [1.2, 0.8, 0.8]}}}",
        run=_too_large,
    ),
    Rule(
        id="too-heavy",
        title="A body is so heavy that the engine's contacts cannot carry it.",
        reason=f"""\
The solver's inverse masses end at 1e-7: a heavier body sinks by {SINKING_PER_MASS:g} m per kilogram, however stiff its
contacts are (measured: 1.4 mm at 1e8 kg; at 1e11 kg a box of 0.1 m falls through the floor). More than
{MAX_SUNK_SHARE:.0%} of the thinnest piece is a warning, more than {SUNK_ERROR_SHARE:.0%} an error.""",
        remedy="Check `density` and `mass`; a scene moves the same if all its masses are divided by one number.",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {mass: 1.0e+9}, place: {on: floor}}
""",
        fix="bodies: {ball: {material: {mass: 100}}}",
        run=_too_heavy,
        own_contact=True,
    ),
    Rule(
        id="far-away",
        title="A body starts so far from the origin that rounding affects it.",
        reason=f"""\
The engine computes in single precision, which rounds a position to {ROUNDING:g} of its value, 1 mm at 10 km. More than
{MAX_SUNK_SHARE / 10:.1%} of the thinnest piece is a warning, more than {MAX_SUNK_SHARE:.0%} an error.""",
        remedy="Build the scene around the origin.",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 9000, 1]}}
""",
        fix="bodies: {ball: {pose: {pos: [0, 9, 1]}}}",
        run=_far_away,
    ),
)
