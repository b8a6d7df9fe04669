"""Cloth of solver pbd that bodies pass through, and attachments that act one way or at a distance."""

import math
from collections.abc import Iterator

from text2sim.compiler.placing.body_points import BodyPoints
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import union
from text2sim.compiler.shapes.gjk import distance
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.regions import RegionError
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.compiler.shapes.solid import Solid
from text2sim.compiler.soft.scales import sheet_size
from text2sim.compiler.soft.settings import MAX_OWN_STRETCH, STRETCH_ITERATIONS, own_stretch
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftBody, SoftFacts
from text2sim.lint.words import length, length_of_at_least, length_of_at_most, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.rounding import at_most

CATCH_SPEED, CATCH_SPEED_WITH_MANY = 8.0, 16.0
"""Speed [m/s] at which a sheet still catches a ball, with 4 and with `MANY_ITERATIONS`; at twice that the ball passed
through."""
MANY_ITERATIONS = 20
"""Stretch iterations that catch fast bodies."""
MAX_UNSEEN_STRETCH = 0.02
"""Part by which a cloth may get longer under its own weight without a report: 1 m becomes 1.02 m."""
MIN_WILD_SPEED = 10.0
"""Smallest speed [m/s] of a point of cloth from which air resistance may throw it back faster than it came."""
MIN_FOOT_CELLS = 4.0
"""Width [cells] of what stands on cloth: a candlestick with a foot of 8 cm leaned by 12 degrees on cells of 30 mm, and
by 0.3 on 15 mm (tests/physics/test_squeezed_cloth.py)."""
MIN_VISIBLE_GAP = 0.005
"""Smallest visible gap [m] between a corner and its holder."""


def _passes(facts: Facts) -> Iterator[Problem]:
    """Report cloth and rigid bodies that meet too fast for the contact shell of the cloth."""
    soft = facts.once(SoftFacts)
    room, h = soft.particle / 2, facts.substep
    found: dict[tuple[str, str], tuple[float, SoftBody, Copy]] = {}
    for body, copy in soft.pairs("pbd"):
        speed = _meeting_speed(facts, soft, body, copy)
        if speed > found.get((body.body, copy.body), (0.0,))[0]:
            found[body.body, copy.body] = speed, body, copy
    pbd = facts.settings.soft.pbd if facts.settings.soft is not None else None
    many = pbd is not None and pbd.stretch_iterations >= MANY_ITERATIONS
    limit = CATCH_SPEED_WITH_MANY if many else CATCH_SPEED
    for speed, body, copy in found.values():
        shift = speed * h
        if shift > room * (1 + 1e-6):
            needed = math.ceil(facts.case.scene.dt * speed / room)
            text = (
                f"`{body.name}` and `{copy.name}` meet at up to {speed:.3g} m/s, {length(shift)} in a substep of "
                f"{h:.3g} s, but the contact shell of the cloth is {length(room)} (half of scene.pbd.particle_size): "
                f"particles pass it before they are held; use scene.substeps of {needed}"
            )
        elif speed > limit and facts.free(copy):
            more = f"set `scene.pbd.stretch_iterations: {MANY_ITERATIONS}`"
            text = (
                f"`{copy.name}` meets `{body.name}` at up to {speed:.3g} m/s: the sheet stretches open at that speed, "
                f"and a ball passed through at twice {limit:g} m/s; "
                + ("make it slower" if limit == CATCH_SPEED_WITH_MANY else more)
            )
        else:
            continue
        yield facts.problem("cloth-too-fast", _blame(facts, body, copy), text, key=True)


def _drag_diverges(facts: Facts) -> Iterator[Problem]:
    """Report cloth whose air resistance is too strong for its substeps.

    In a substep h, drag c |v| v changes the speed v of a point of mass m by c v² h / m; beyond 2 m / (c h) that is more
    than 2 v, and the speed grows.
    """
    soft, h = facts.once(SoftFacts), facts.substep
    blown = {row.entity for row in facts.plan.airflows}  # where an airflow replaces it
    for body in soft.of("pbd"):
        resistance = getattr(body.model.material, "air_resistance", None)
        if body.model.kind != "cloth" or not resistance or body.copy.name in blown:
            continue
        wide, tall = sheet_size(body.copy.shape, facts.folder)
        mass = body.model.material.area_density * wide * tall / soft.points(body)
        wild = 2 * mass / (resistance * h)
        if wild < MIN_WILD_SPEED:
            most = 2 * mass / (MIN_WILD_SPEED * h)
            needed = math.ceil(facts.case.scene.dt / h * MIN_WILD_SPEED / wild)
            text = (
                f"drag of {resistance:g} kg/m on points of {1e3 * mass:.2g} g throws those faster than {wild:.2g} m/s "
                f"back faster than they came, in substeps of {h:.3g} s: the cloth diverges in a jerk; use "
                f"{at_most(most)} at most, or scene.substeps of {needed}"
            )
            where = (*facts.where(body.body), "material", "air_resistance")
            yield facts.problem("drag-diverges", where, text)


def _sags(facts: Facts) -> Iterator[Problem]:
    """Report cloth that its solver lets stretch under its own weight; see `own_stretch`."""
    soft = facts.once(SoftFacts)
    pbd = facts.settings.soft.pbd if facts.settings.soft is not None else None
    seen = set()
    for body in soft.of("pbd"):
        assert pbd is not None
        long, size, h = sheet_size(body.copy.shape, facts.folder)[1], pbd.particle_size, facts.substep
        stretch = own_stretch(long, size, h, pbd.stretch_iterations, facts.pull)
        if stretch <= MAX_UNSEEN_STRETCH or body.body in seen:
            continue
        seen.add(body.body)
        times = math.sqrt(stretch / MAX_OWN_STRETCH)
        more = math.ceil(times * facts.case.scene.dt / h)
        remedy = f"use cells of {length(size * times)}, or scene.substeps of {more}"
        if own_stretch(long, size, h, STRETCH_ITERATIONS[-1], facts.pull) <= MAX_OWN_STRETCH:
            remedy = "leave out `stretch_iterations` of scene.pbd"
        text = (
            f"`{body.name}` is {length(long)} long and has cells of {length(size)}: with {pbd.stretch_iterations} "
            f"stretch iterations in substeps of {h:.3g} s, its own weight makes it {100 * stretch:.2g} % longer "
            "where it hangs"
        )
        yield facts.problem("cloth-sags", facts.first_given(body.body, "cell", "shape"), f"{text}; {remedy}")


def _meeting_speed(facts: Facts, soft: SoftFacts, body: SoftBody, copy: Copy) -> float:
    """Return the largest speed [m/s] at which the two may meet, by their start velocities and a fall."""
    own, other = (facts.velocities.get(c.name, (0.0, 0.0, 0.0)) for c in (body.copy, copy))
    fast = math.dist(own, other)
    drop = 0.0
    box, other_box = body.box, facts.box(copy)
    if other_box is not None:
        if facts.free(copy) and soft.comes_down_on(copy, body.copy):
            drop = other_box[0][2] - box[1][2]
        elif facts.loose(body.copy) and soft.comes_down_on(body.copy, copy):
            drop = box[0][2] - other_box[1][2]
    fall = math.sqrt(max(0.0, 2 * facts.pull * drop))
    return math.hypot(fast, fall)


def _blame(facts: Facts, body: SoftBody, copy: Copy) -> tuple[str | int, ...]:
    names = {body.copy.name, copy.name}
    for row in facts.rows.velocities:
        if row.entity in names:
            return ("actions", "controls", row.control)
    return facts.first_given(
        body.body if facts.once(SoftFacts).comes_down_on(body.copy, copy) else copy.body, "place", "pose"
    )


def _one_way(facts: Facts) -> Iterator[Problem]:
    """Report points of fem that are attached to a free body, which they never pull."""
    one_way = {body.body for body in facts.once(SoftFacts).of("fem")}
    for name, control in facts.case.actions.controls.items():
        if control.kind != "attach" or control.to == "world":
            continue
        holders = facts.placed.get(body_of(control.to), [])
        loose = [copy for copy in holders if facts.free(copy)]
        if body_of(control.body) in one_way and loose:
            text = (
                f"`{loose[0].name}`{more_copies(len(loose))} is free, and `{control.body}` is attached to it: points "
                "of solver fem follow their holder but never pull it; use `solver: mpm`, or a holder that is fixed, "
                "driven, or on a joint with a motor"
            )
            yield facts.problem("one-way-hold", ("actions", "controls", name, "to"), text)


def _off_its_holder(facts: Facts) -> Iterator[Problem]:
    """Report corners and points that are attached at a distance."""
    soft, points = facts.once(SoftFacts), BodyPoints({}, facts.folder)
    for name, control in facts.case.actions.controls.items():
        if control.kind != "attach" or control.to == "world" or (region := control.region) is None:
            continue
        if not (region.corner or region.nearest or region.sphere):
            continue
        body = next((body for body in soft.bodies if body.body == body_of(control.body)), None)
        holders = facts.placed.get(body_of(control.to), [])
        pieces = [part.solid for copy in holders for part in facts.parts(copy)]
        if body is None or not pieces or len(facts.placed[body.body]) > 1:
            continue
        try:
            point = points.in_world(body.copy, None, region)
        except RegionError:
            continue  # it is inside the body, where no gap is visible
        near = region.sphere.radius if region.sphere else 0.0
        away = min(distance(Solid(Piece("sphere", size=(near,)), point, IDENTITY), piece) for piece in pieces)
        if away > max(soft.scales.spacing(body.body, body.solver), MIN_VISIBLE_GAP):
            text = (
                f"the attached point of `{body.name}` is {length(away)} away from `{control.to}`: the film shows it "
                "hanging on nothing; move one of them until they touch"
            )
            yield facts.problem("held-at-a-distance", ("actions", "controls", name, "to"), text)


def _narrow_foot(facts: Facts) -> Iterator[Problem]:
    """Report free rigid bodies that come down on flat cloth on something rigid, on few of its points."""
    soft = facts.once(SoftFacts)
    wanted, seen = MIN_FOOT_CELLS * soft.particle, set()
    for body in soft.of("pbd"):
        low, high = body.box[0][2], body.box[1][2]
        if high - low > soft.particle or soft.model != "particle":
            continue
        beds = [copy for copy in soft.rigid if 0.0 <= low - _top(facts, copy) <= soft.particle]
        grounds = [ground.copy for ground in soft.planes if 0.0 <= low - ground.level <= soft.particle]
        for load in soft.rigid:
            if load.body in seen or load in beds or not (facts.free(load) and soft.comes_down_on(load, body.copy)):
                continue
            wide = _foot(facts, load)
            if wide < wanted * (1 - 1e-6) and (grounds or any(soft.comes_down_on(load, bed) for bed in beds)):
                seen.add(load.body)
                text = (
                    f"`{load.name}` stands on `{body.name}` with a foot {length(wide)} wide, "
                    f"{wide / soft.particle:.2g} cells of the cloth: that few points do not keep it upright; give it a "
                    f"foot of {length_of_at_least(wanted)} or more, the cloth a `cell` of "
                    f"{length_of_at_most(wide / MIN_FOOT_CELLS)} or less, or `material: {{touch_soft: false}}`, so "
                    "that it stands on what is below"
                )
                yield facts.problem("foot-on-cloth", facts.first_given(load.body, "shape"), text, key=True)


def _foot(facts: Facts, copy: Copy) -> float:
    """Return the smaller horizontal extent [m] of the lowest pieces of a rigid copy."""
    boxes = [part.box for part in facts.parts(copy)]
    if not boxes:
        return math.inf
    bottom = min(box[0][2] for box in boxes)
    lowest = union(box for box in boxes if box[0][2] <= bottom + MIN_VISIBLE_GAP)
    return min(lowest[1][k] - lowest[0][k] for k in (0, 1))


def _top(facts: Facts, copy: Copy) -> float:
    box = facts.box(copy)
    return math.inf if box is None else box[1][2]


RULES = (
    Rule(
        id="foot-on-cloth",
        title="A rigid body stands on cloth with a foot of few cells.",
        reason=f"""\
Cloth that lies on something carries what stands on it by its points, which are a cell apart and irregular. A
candlestick with a foot of 8 cm leaned by 12 degrees on cells of 30 mm, and stood on 15 mm. It takes
{MIN_FOOT_CELLS:g} cells or more.""",
        remedy="""\
Make the foot wider or the `cell` of the cloth smaller; or let it stand on what the cloth lies on, with
`material: {touch_soft: false}`: its lower edge is then hidden in the cloth.""",
        example="""\
bodies:
  rug: {kind: cloth, solver: pbd, cell: 0.03, shape: {kind: sheet, size: [0.6, 0.4]}, pose: {pos: [0, 0, 0.015]}}
  stick: {kind: rigid, shape: {kind: cylinder, radius: 0.04, height: 0.24}, pose: {pos: [0, 0, 0.16]}}
""",
        fix="bodies: {rug: {cell: 0.02, pose: {pos: [0, 0, 0.01]}}}",
        run=_narrow_foot,
    ),
    Rule(
        id="cloth-too-fast",
        title="A cloth and a rigid body meet so fast that one passes through the other.",
        reason=f"""\
At the end of a substep, particles of cloth closer to a rigid body than half of `particle_size` are pushed out: a body
that moves farther per substep may be on the other side. Walls may be thin: 4 mm held a tumbling cloth as long as speed
times substep stayed below the shell. A sheet of 20 mm particles caught a ball at 4 and 8 m/s and let it pass at 16;
with {MANY_ITERATIONS} stretch iterations and half the substep it caught it at 16 and not at 32.""",
        remedy="""\
Use the `scene.substeps` of the message, larger particles, or more `scene.pbd.stretch_iterations`.""",
        example="""\
scene: {dt: 0.01, substeps: 2}
bodies:
  sheet: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.6, 0.6]}, pose: {pos: [0, 0, 0.8]}}
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.08}, pose: {pos: [0, 0, 2.0]}}
actions:
  controls:
    pin: {kind: attach, body: sheet, region: {edge: left}, to: world}
""",
        fix="scene: {dt: null, substeps: null}",
        run=_passes,
    ),
    Rule(
        id="one-way-hold",
        title="A soft body of solver fem is attached to a free body, which does not feel it.",
        reason="""\
The engine moves the attached points of fem bodies with their holder, without a reaction force: a free body to which a
soft one is attached falls as if it were alone, and takes it along. Soft bodies of solver mpm and cloth of solver pbd
do pull their holder.""",
        remedy="""\
Use solver mpm; attach it to a body that is fixed, driven, or moved by a motor, or to the `world`; or put a load on top
of a soft body, which feels it.""",
        example="""\
bodies:
  slab: {kind: soft, solver: fem, cell: 0.02, shape: {kind: box, size: [0.6, 0.1, 0.1]}, pose: {pos: [0, 0, 1.0]}}
  load: {kind: rigid, shape: {kind: sphere, radius: 0.05}, pose: {pos: [0, 0, 0.8]}}
actions:
  controls:
    hang: {kind: attach, body: slab, region: {face: left}, to: world}
    carry: {kind: attach, body: slab, region: {face: bottom}, to: load}
""",
        fix="actions: {controls: {carry: null}}",
        run=_one_way,
    ),
    Rule(
        id="drag-diverges",
        title="The air resistance of a cloth is too strong for its substeps.",
        reason=f"""\
The engine subtracts the drag of a whole substep from the speed of each point: beyond 2 m / (c h), the point is thrown
back faster than it came (`pytest tests/physics/test_soft_controls.py -k drag`). Single points of a cloth that is hit or
jerked get to some m/s; the rule reports less than {MIN_WILD_SPEED:g} m/s.""",
        remedy="Use a smaller `air_resistance`, or more substeps.",
        example="""\
bodies:
  sheet:
    kind: cloth
    cell: 0.03
    shape: {kind: sheet, size: [0.9, 0.9]}
    material: {air_resistance: 1.0}
    pose: {pos: [0, 0, 1]}
""",
        fix="bodies: {sheet: {material: {air_resistance: 0.02}}}",
        run=_drag_diverges,
    ),
    Rule(
        id="cloth-sags",
        title="A cloth of fine cells stretches under its own weight.",
        reason="""\
The solver corrects the threads a few times in each substep, which carries the weight of what hangs only a few cells
up: a cloth of length L gets longer by a part 3 g h^2 L / (n cell^2), with n iterations in substeps h, whatever its
material: half a metre in cells of 5 mm by 3.6 % with 4 iterations in substeps of 0.5 ms, and 0.9 % with 16. By default
there are as many iterations as keep it below a percent, up to 32.""",
        remedy="""\
Leave out `stretch_iterations`, or use larger cells or more `substeps`: twice as many stretch it a quarter as much. For
a cloth that lies on something all over, waive the rule.""",
        example="""\
scene: {pbd: {stretch_iterations: 4}}
bodies:
  banner:
    kind: cloth
    cell: 0.005
    shape: {kind: sheet, size: [0.1, 1.0]}
    pose: {pos: [0, 0, 1.2], euler_deg: [90, 0, 0]}
actions:
  controls:
    hang: {kind: attach, body: banner, region: {edge: back}, to: world}
""",
        fix="scene: {pbd: null}",
        run=_sags,
    ),
    Rule(
        id="held-at-a-distance",
        title="A corner or point is attached to a body that it does not touch.",
        reason="""\
Attached points follow their holder at the distance that they have at the start: the physics is correct, but the film
shows a napkin that hangs on nothing below its peg.""",
        remedy="Place the body, or its holder, so that they touch.",
        example="""\
scene: {statics: {peg: {shape: {kind: sphere, radius: 0.01}, pose: {pos: [0.2, 0, 1.03]}}}}
bodies:
  napkin:
    kind: cloth
    cell: 0.01
    shape: {kind: sheet, size: [0.4, 0.4]}
    pose: {pos: [0, 0, 0.8], euler_deg: [90, 0, 0]}
actions:
  controls:
    hang: {kind: attach, body: napkin, region: {corner: [right, back]}, to: peg}
""",
        fix="scene: {statics: {peg: {pose: {pos: [0.2, 0, 1.005]}}}}",
        run=_off_its_holder,
    ),
)
