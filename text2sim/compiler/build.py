"""From a loaded case to its plan, and from a plan to a folder with the program."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import acos, radians
from pathlib import Path

from text2sim.assets.mechanism import Mechanisms
from text2sim.compiler.action_rows import Friction
from text2sim.compiler.belts import carriers, check_belts, lower_belts
from text2sim.compiler.contact_materials import Restitutions, contact_damping, resists_rolling, restitutions
from text2sim.compiler.controls import ControlRows, breaking_welds, lower_controls, lower_motions
from text2sim.compiler.film import resolve_render, spring_looks
from text2sim.compiler.film_cameras import check_targets
from text2sim.compiler.grips import grips
from text2sim.compiler.lower import Lowering
from text2sim.compiler.masses import known_speeds
from text2sim.compiler.placing.body_points import BodyPoints
from text2sim.compiler.placing.divisions import part_counts
from text2sim.compiler.placing.placement import Copy, file_path, place_all
from text2sim.compiler.plan import EntityPlan, Group, Plan
from text2sim.compiler.release_events import lower_watches
from text2sim.compiler.rope_frequencies import taut_frequencies
from text2sim.compiler.selection import select
from text2sim.compiler.settings import Settings, Traits, derive
from text2sim.compiler.shapes.rotation import vector_dot, vector_minus, vector_unit
from text2sim.compiler.shapes.sizes import MAX_PIECES
from text2sim.compiler.slopes import has_slopes
from text2sim.compiler.soft.controls import SoftControls
from text2sim.compiler.soft.resolution import soft_lowering, soft_settings
from text2sim.compiler.soft.setup import MAX_SPEED
from text2sim.compiler.trees.beams import beam_frequency
from text2sim.compiler.trees.carried import smallest_share
from text2sim.compiler.trees.generators import rope_frequency
from text2sim.compiler.trees.link_trees import known_parts, link_frames, named_parts, tree_extents, tree_standing
from text2sim.spec_schema.errors import AssetError, Problem, SpecError
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.bodies import LINKED
from text2sim.spec_schema.models.placed import Deformable
from text2sim.spec_schema.models.repeat import Fragments
from text2sim.spec_schema.models.soft_bodies import Beam, Rope, Round
from text2sim.spec_schema.names.references import check_references
from text2sim.spec_schema.whole_files import naming

WOUND, SHARP = radians(150), radians(80)
"""Angle by which the points of a rope turn in all if it goes round something, and that of a corner, where it is folded
instead."""


@dataclass(frozen=True)
class Resolution:
    """A case with everything worked out: its plan, and what the plan was made from."""

    loaded: LoadedCase
    placed: dict[str, list[Copy]]
    """Copies by static or body."""
    lowering: Lowering
    """Pieces, trees, model files, motors."""
    rows: ControlRows
    """Controls, lowered."""
    settings: Settings
    plan: Plan


def plan_case(loaded: LoadedCase) -> Plan:
    """Resolve a case into a plan; see `resolve_case`."""
    return resolve_case(loaded).plan


def resolve_case(loaded: LoadedCase) -> Resolution:
    """Place, lower and settle everything in a case.

    Raises:
        SpecError: with every problem found, if there is an error among them.
    """
    mechanisms: Mechanisms = {}
    parts, problems = known_parts(loaded, mechanisms)
    counts, found = part_counts(loaded)
    problems += [*found, *check_references(loaded, parts, counts), *check_belts(loaded)]
    _stop_at_errors(problems)
    placed, found = place_all(loaded, tree_extents, tree_standing, link_frames)
    problems += found
    _stop_at_errors(problems)
    case, scene = loaded.case, loaded.case.scene
    rolls = resists_rolling((*scene.statics.values(), *case.bodies.values()))
    lowering = Lowering(loaded.folder, named_parts(loaded), mechanisms=mechanisms, rolls=rolls)
    lowering.soft = soft_lowering(loaded, placed, lowering.files)
    statics = _groups(loaded, placed, ("scene", "statics"), tuple(scene.statics), lowering, problems)
    bodies = _groups(loaded, placed, ("bodies",), tuple(case.bodies), lowering, problems)
    _stop_at_errors(problems)
    points = BodyPoints(lowering.trees, loaded.folder)
    soft_controls = None if lowering.soft is None else SoftControls(scene, lowering.soft.scales, loaded.folder)
    rows = lower_controls(loaded, placed, lowering.initial, points, soft_controls, lowering.held_joints())
    watches, found = lower_watches(loaded, placed, soft_controls)
    problems += rows.problems + found + check_targets(loaded, placed, points)
    _stop_at_errors(problems)
    bounce = restitutions(copy for group in placed.values() for copy in group)
    soft = soft_settings(loaded, placed, lowering.soft, bodies, rows)
    settings = derive(scene, _traits(loaded, placed, lowering, bodies, rows, bounce), soft)
    every = max(1, round(1.0 / (case.record_rate * scene.dt)))
    plan = Plan(
        case=case.name,
        dt=scene.dt,
        steps=max(1, round(scene.duration / scene.dt)),
        every=every,
        gravity=scene.gravity,
        seed=scene.seed,
        max_speed=soft.max_speed if soft else scene.max_speed or MAX_SPEED,
        settings=settings,
        statics=statics,
        bodies=bodies,
        motors=tuple(lowering.motors),
        contact=contact_damping(placed, bounce, set(scene.statics), settings, scene.dt / settings.substeps),
        silent=tuple(c.name for name in scene.statics for c in placed[name] if bounce and c.name not in bounce),
        initial=lowering.initial,
        joint_velocities=lowering.joint_velocities,
        velocities=tuple(rows.velocities),
        drives=tuple(rows.drives),
        wrenches=tuple(rows.wrenches),
        welds=tuple(weld for weld in rows.welds if weld.strength is None),
        springs=tuple(rows.springs),
        prescribed=tuple(lower_motions(placed)),
        belts=lower_belts(placed),
        holds=tuple(rows.holds),
        pushes=tuple(rows.pushes),
        airflows=tuple(rows.airflows),
        fields=tuple(rows.fields),
        frictions=tuple(_frictions(loaded, placed)),
        removals=tuple(rows.removals),
        bonds=(*rows.bonds, *breaking_welds(rows.welds)),
        watches=tuple(watches),
        render=resolve_render(case.render, placed, tuple(case.bodies), scene.duration, lowering.balls, points)
        | spring_looks(case.actions.controls),
        files=lowering.files,
        changes=tuple(lowering.changes),
        damped=lowering.damped,
        unpowered=tuple(lowering.unpowered),
        notes=(*settings.notes(), *lowering.notes),
        warnings=tuple(problems),
    )
    return Resolution(loaded, placed, lowering, rows, settings, plan)


def compile_case(loaded: LoadedCase, out: Path) -> Plan:
    """Write the program of a case into the folder `out`, replacing the program that was there.

    Raises:
        SpecError: with every problem found.
    """
    from text2sim.compiler.emit import emit

    plan = plan_case(loaded)
    files = emit(plan)
    for path, content in files.items():
        target = out / path
        target.parent.mkdir(parents=True, exist_ok=True)
        with naming(target):
            target.write_bytes(content)
    return plan


def _stop_at_errors(problems: list[Problem]) -> None:
    if any(problem.severity == "error" for problem in problems):
        raise SpecError(problems)


def _groups(
    loaded: LoadedCase,
    placed: dict[str, list[Copy]],
    section: tuple[str, ...],
    names: tuple[str, ...],
    lowering: Lowering,
    problems: list[Problem],
) -> tuple[Group, ...]:
    groups = []
    for name in names:
        pointer = (*section, name)
        entities: list[EntityPlan] = []
        for copy in placed[name]:
            try:
                entity = lowering.entity(copy.model, copy)
                if lowering.soft is not None:
                    entity = lowering.soft.coupled(entity, copy.model, lowering.trees.get(copy.name))
                entities.append(entity)
            except AssetError as error:
                problems.append(loaded.problem((*pointer, *file_path(copy.model)), str(error), rule="asset"))
                break
            if lowering.pieces > MAX_PIECES:
                message = f"with this, the scene has more than {MAX_PIECES:,} convex pieces, too many for the engine"
                raise SpecError([*problems, loaded.problem(pointer, message, key=True, rule="too-many")])
        if len({entity.morph for entity in entities}) > 1:
            problems.append(
                loaded.problem(
                    (*pointer, "shape"), "copies of one body must have the same kind of shape", rule="mixed-shapes"
                )
            )
        groups.append(Group(name, loaded.line(pointer), tuple(entities)))
    return tuple(groups)


def _traits(
    loaded: LoadedCase,
    placed: dict[str, list[Copy]],
    lowering: Lowering,
    groups: tuple[Group, ...],
    rows: ControlRows,
    bounce: Restitutions,
) -> Traits:
    bodies, gravity = loaded.case.bodies, loaded.case.scene.gravity
    moving = [copy for name in bodies for copy in placed[name]]
    trees = lowering.trees.values()
    loose = sum(copy.model.startable for copy in moving if not isinstance(copy.model, Deformable))
    return Traits(
        loose=loose,
        geoms=lowering.pieces,
        chains=sum(joint.kind == "ball" for tree in trees for _, joint in tree.joints()),
        loops=sum(len(tree.loops) for tree in trees),
        linked=any(copy.model.kind in LINKED for copy in moving),
        attaches=sum(weld.on for weld in rows.welds) + len(rows.bonds),
        fastest=max(known_speeds(lowering, groups, moving, rows).values(), default=0.0),
        thinnest=lowering.thinnest,
        bounciest=max(bounce.values(), default=0.0),
        rolls=lowering.rolls,
        swiftest=max(map(_spring_frequency, moving), default=0.0),
        tautest=max(taut_frequencies(lowering, groups, moving, rows, gravity).values(), default=0.0),
        wound=any(isinstance(body, Rope) and _is_wound(body) for body in bodies.values()),
        slightest=min((smallest_share(tree) for tree in trees), default=1.0),
        fragments=any(isinstance(getattr(body, "repeat", None), Fragments) for body in bodies.values()),
        carries=any(True for _ in carriers(placed)),
        slopes=has_slopes((copy for group in placed.values() for copy in group), gravity),
        grips=any(True for _ in grips(moving, lowering.trees, rows)),
    )


def _spring_frequency(copy: Copy) -> float:
    """Return the angular frequency [rad/s] of the springs that keep a rope or beam straight; 0 for other bodies."""
    if isinstance(copy.model, Rope):
        return rope_frequency(copy.model)
    return beam_frequency(copy.model) if isinstance(copy.model, Beam) else 0.0


def _is_wound(rope: Rope) -> bool:
    """Return whether a rope goes round something: it says so, or its points turn by almost half a turn bit by bit."""
    along = rope.along or []
    points = [point for point in along if not isinstance(point, Round)]
    ways = [vector_unit(vector_minus(b, a)) for a, b in pairwise(points) if a != b]
    bends = [acos(max(-1.0, min(1.0, vector_dot(a, b)))) for a, b in pairwise(ways)]
    return len(points) < len(along) or sum(bend for bend in bends if bend < SHARP) > WOUND


def _frictions(loaded: LoadedCase, placed: dict[str, list[Copy]]) -> Iterator[Friction]:
    for name, pair in loaded.case.scene.contact.pairs.items():
        (first, link), (second, other) = (select(selector, placed) for selector in pair.between)
        these, those = (tuple(copy.name for copy in copies) for copies in (first, second))
        line = loaded.line(("scene", "contact", "pairs", name))
        yield Friction(these, link, those, other, pair.friction, line)
