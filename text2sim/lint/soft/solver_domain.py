"""Deformable bodies that start outside the bounds of their solver, leave them, or rest on them."""

from collections.abc import Iterator

from text2sim.compiler.shapes.boxes import Bounds, sides
from text2sim.compiler.soft.lowering import mass
from text2sim.compiler.soft.settings import PADDING
from text2sim.compiler.soft.solver_domain import find_surroundings, path_bounds
from text2sim.compiler.soft.travel import travel
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftBody, SoftFacts
from text2sim.lint.words import length, more_copies, vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of

_WIDER = "give larger `scene.{solver}.bounds`, make `cell` larger, or end the run earlier"


def _outside(facts: Facts) -> Iterator[Problem]:
    """Report each body that starts outside once."""
    soft = facts.once(SoftFacts)
    for solver, bounds, pad in _spaces(facts):
        found: dict[str, list[SoftBody]] = {}
        for body in soft.of(solver):
            if _excess(body.box, bounds, pad):
                found.setdefault(body.body, []).append(body)
        for rows in found.values():
            body = rows[0]
            away, side = max(_excess(body.box, bounds, pad))
            edge = f", of which {PADDING} cells ({length(pad)}) at each side are its wall" if pad else ""
            text = (
                f"`{body.name}`{more_copies(len(rows))} is {length(away)} outside scene.{solver}.bounds "
                f"({vector(bounds[0])} to {vector(bounds[1])}{edge}) on the {side} side: the engine "
                + ("refuses it" if solver == "mpm" else "moves it to the wall")
                + "; leave the bounds out, or make them larger"
            )
            yield facts.problem("outside-bounds", ("scene", solver, "bounds"), text, key=True)


def _spaces(facts: Facts) -> Iterator[tuple[str, Bounds, float]]:
    """Yield solver, bounds [m] and wall thickness [m], if the case gives bounds."""
    scene, soft = facts.case.scene, facts.once(SoftFacts)
    if scene.mpm.bounds is not None and soft.of("mpm"):
        yield "mpm", (scene.mpm.bounds.min, scene.mpm.bounds.max), PADDING * soft.cell
    if scene.pbd.bounds is not None and soft.of("pbd"):
        yield "pbd", (scene.pbd.bounds.min, scene.pbd.bounds.max), 0.0


def _excess(box: Bounds, bounds: Bounds, pad: float) -> list[tuple[float, str]]:
    """Return how far [m] a box is outside, and on which sides."""
    found = []
    for axis, name in enumerate("xyz"):
        found += [
            (bounds[0][axis] + pad - box[0][axis], f"-{name}"),
            (box[1][axis] - bounds[1][axis] + pad, f"+{name}"),
        ]
    return [(away, side) for away, side in found if away > 1e-9]


def _floor_of_space(facts: Facts) -> Iterator[Problem]:
    """Report bounds that end so near to a plane that bodies rest on the wall, above the plane."""
    soft = facts.once(SoftFacts)
    for solver, (low, _), pad in _spaces(facts):
        level = low[2] + pad
        for ground in soft.planes:
            if ground.up[2] < 0.999 or level <= ground.level + 1e-6:
                continue
            if any(soft.meets_plane(body, ground) and not _carried(facts, body, level) for body in soft.of(solver)):
                text = (
                    f"scene.{solver}.bounds begin at z {low[2]:g}"
                    + (f", and the {PADDING} cells ({length(pad)}) above are its wall" if pad else "")
                    + f": bodies rest {length(level - ground.level)} above `{ground.copy.name}`; begin the bounds at "
                    f"{ground.level - pad:.4g} or lower"
                )
                yield facts.problem("floats-on-bounds", ("scene", solver, "bounds"), text, key=True)


def _carried(facts: Facts, body: SoftBody, level: float) -> bool:
    """Return whether something at rest, whose top is above a level [m], lies under the whole body at the start."""
    (left, front, bottom), (right, back, _) = body.box
    boxes = (facts.box(copy) for copy in facts.once(SoftFacts).rigid if not facts.moves(copy))
    return any(
        box is not None
        and level <= box[1][2] <= bottom
        and box[0][0] <= left
        and right <= box[1][0]
        and box[0][1] <= front
        and back <= box[1][1]
        for box in boxes
    )


def _leaving(facts: Facts) -> Iterator[Problem]:
    """Report bodies that may move out of the bounds of their solver."""
    settings = facts.plan.settings.soft
    if settings is None:
        return
    soft, case = facts.once(SoftFacts), facts.case
    spaces = {"mpm": (settings.mpm, PADDING * soft.cell), "pbd": (settings.pbd, 0.0)}
    spaces = {solver: (space, pad) for solver, (space, pad) in spaces.items() if space is not None and soft.of(solver)}
    if not spaces:
        return
    masses = {body.name: mass(body.copy, facts.folder) for body in soft.bodies}
    controls = case.actions.controls.values()
    travels = travel(facts.rows, controls, facts.placed, masses, facts.pull, case.scene.duration)
    around = find_surroundings(facts.placed, case.scene, travels, facts.folder)
    for solver, (space, pad) in spaces.items():
        is_given = getattr(case.scene, solver).bounds is not None
        seen = set()
        for body in soft.of(solver):
            if body.body in seen or _excess(body.box, (space.low, space.high), pad):
                continue
            reached = path_bounds(body.copy, around)
            if _is_held(facts, body):
                reached = _hung(body.box, reached)
            out = [
                row
                for row in _excess(reached, (space.low, space.high), pad)
                if row[0] > soft.scales.spacing(body.body, solver)
            ]
            if not out:
                continue
            seen.add(body.body)
            away, side = max(out)
            text = (
                f"`{body.name}` may move {length(away)} beyond the {side} side of the bounds of {solver} "
                f"({vector(space.low)} to {vector(space.high)}) by its fall and by the script, but there is an "
                "invisible wall; "
                + ("leave the bounds out, or make them larger" if is_given else _WIDER.format(solver=solver))
            )
            where = ("scene", solver, "bounds") if is_given else facts.where(body.body)
            yield facts.problem("leaves-bounds", where, text, key=True)


def _is_held(facts: Facts, body: SoftBody) -> bool:
    """Return whether a cloth is held somewhere for the whole run."""
    controls = facts.case.actions.controls
    holds = {n for n, c in controls.items() if c.kind == "attach" and body_of(c.body) == body.body and not c.at}
    let_go = {c.attach for c in controls.values() if c.kind == "release"}
    return body.copy.model.kind == "cloth" and bool(holds - let_go)


def _hung(box: Bounds, there: Bounds) -> Bounds:
    """Return the reach of a hanging cloth: no lower than its longest side below its top."""
    low = max(there[0][2], box[1][2] - max(sides(box)))
    return (there[0][0], there[0][1], min(low, box[0][2])), there[1]


RULES = (
    Rule(
        id="outside-bounds",
        severity="error",
        title="A deformable body starts outside the bounds of its solver.",
        reason=f"""\
The mpm grid covers a box, and {PADDING} cells at each side are walls: the engine refuses particles that start in or
beyond them. The bounds of pbd are walls: particles outside are moved onto them at once.""",
        remedy="Leave the bounds out: they are derived from the reach of the bodies.",
        example="""\
scene: {mpm: {bounds: {min: [-0.5, -0.5, -0.2], max: [0.5, 0.5, 0.6]}}}
bodies:
  jelly: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="scene: {mpm: {bounds: {max: [0.5, 0.5, 1.0]}}}",
        run=_outside,
    ),
    Rule(
        id="floats-on-bounds",
        title="The bounds of a solver begin above the ground, and bodies rest on them.",
        reason=f"""\
Bounds are walls for the bodies of their solver, and those of mpm are {PADDING} cells thick: with bounds that begin at a
floor, bodies come to rest {PADDING} cells above it.""",
        remedy=f"Leave the bounds out, or begin them {PADDING} cells below the ground.",
        example="""\
scene: {mpm: {bounds: {min: [-0.5, -0.5, 0], max: [0.5, 0.5, 1.0]}}}
bodies:
  jelly: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.3]}}
""",
        fix="scene: {mpm: {bounds: {min: [-0.5, -0.5, -0.1]}}}",
        run=_floor_of_space,
    ),
    Rule(
        id="leaves-bounds",
        title="A deformable body may leave the bounds of its solver, which are walls.",
        reason="""\
The mpm grid and the pbd hash cover a box and stop bodies at its sides, without an error. Derived bounds have room for
falls, start velocities, forces, fields and carriers; but a body is followed for at most 2 m, and there are at most 3
million cells of mpm, or one million of pbd, because each step processes all cells.""",
        remedy="Leave the bounds out, make them as large as the message says, or limit the motion of the body.",
        example="""\
scene: {mpm: {bounds: {min: [-0.5, -0.5, -0.2], max: [0.5, 0.5, 1.0]}}}
bodies:
  jelly: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.5]}}
actions: {controls: {throw: {kind: initial_velocity, body: jelly, linear: [3, 0, 0]}}}
""",
        fix="scene: {mpm: null}",
        run=_leaving,
    ),
)
