"""From a loaded case to a plan, and from a plan to the program's folder."""

import json
from dataclasses import dataclass, fields, is_dataclass, replace
from hashlib import sha256
from math import ceil, pi
from pathlib import Path
from typing import Any

from text2sim import __version__
from text2sim.compiler.anatomy import known_parts, named_parts, tree_extents
from text2sim.compiler.controls import Rows, lower_controls, lower_motions
from text2sim.compiler.film import resolve_render
from text2sim.compiler.lower import Lowering
from text2sim.compiler.overlap import overlaps
from text2sim.compiler.placement import Copy, place_all
from text2sim.compiler.plan import EntityPlan, Group, Plan
from text2sim.compiler.settings import CRISPNESS, Settings, Traits, derive
from text2sim.spec_schema.errors import AssetError, Problem, SpecError
from text2sim.spec_schema.load import LoadedCase
from text2sim.spec_schema.references import check_references

ENERGY_BOUND = 0.95
"""Largest substep times angular frequency of a bouncing contact at which the engine stays stable."""
SCATTER_BOUND = 0.4
"""The same for a restitution that is met within 0.05, and contacts that gain next to no energy."""
MAX_PIECES = 20_000
"""Convex pieces of a scene. The engine keeps a table of all pairs of them: here it takes 1.6 GB."""
CRISP = 0.02
"""Longest time [s] for which a bouncing contact may last without a warning."""


@dataclass(frozen=True)
class Resolution:
    """A case with everything worked out: its plan, and what the plan was made from."""

    loaded: LoadedCase
    placed: dict[str, list[Copy]]
    """Copies by static or body."""
    lowering: Lowering
    """Pieces, trees, model files, motors."""
    rows: Rows
    """Controls, lowered."""
    settings: Settings
    plan: Plan


def plan_case(loaded: LoadedCase) -> Plan:
    """Resolve a case into a plan; see `resolve_case`."""
    return resolve_case(loaded).plan


def resolve_case(loaded: LoadedCase) -> Resolution:
    """Work a case out.

    Raises:
        SpecError: with every problem found, if there is an error among them.
    """
    parts, problems = known_parts(loaded)
    problems += check_references(loaded, parts)
    _stop_at_errors(problems)
    placed, found = place_all(loaded, tree_extents)
    problems += found
    _stop_at_errors(problems)
    lowering = Lowering(loaded.folder, named_parts(loaded))
    case, scene = loaded.case, loaded.case.scene
    statics = _groups(loaded, placed, tuple(scene.statics), "scene", lowering, problems)
    bodies = _groups(loaded, placed, tuple(case.bodies), None, lowering, problems)
    _stop_at_errors(problems)
    problems += _check_overlaps(loaded, placed, lowering)
    rows = lower_controls(loaded, placed, lowering.initial)
    moving = [copy for name in case.bodies for copy in placed[name]]
    bounce = {c.name: e for group in placed.values() for c in group if (e := _restitution(c)) is not None}
    settings = derive(scene, _traits(lowering, moving, rows, bounce))
    problems += _check_bounce(loaded, settings, bounce)
    _stop_at_errors(problems)
    every = max(1, round(1.0 / (scene.record.rate * scene.dt)))
    plan = Plan(
        case=case.name,
        dt=scene.dt,
        steps=max(1, round(scene.duration / scene.dt)),
        every=every,
        gravity=scene.gravity,
        seed=scene.seed,
        max_speed=scene.max_speed,
        settings=settings,
        statics=statics,
        bodies=bodies,
        motors=tuple(lowering.motors),
        contact=_damping(placed, bounce, set(scene.statics), settings, scene.dt / settings.substeps) if bounce else {},
        initial=lowering.initial,
        velocities=tuple(rows.velocities),
        drives=tuple(rows.drives),
        wrenches=tuple(rows.wrenches),
        welds=tuple(rows.welds),
        prescribed=tuple(lower_motions(placed)),
        render=resolve_render(case.render, placed, tuple(case.bodies), scene.duration, lowering.balls),
        files=lowering.files,
        changes=tuple(lowering.changes),
        unpowered=tuple(lowering.unpowered),
        notes=(*settings.notes(), *lowering.notes),
        warnings=tuple(problems),
    )
    plan = replace(plan, sim_digest=_sim_digest(plan), render_digest=_render_digest(plan))
    return Resolution(loaded, placed, lowering, rows, settings, plan)


def compile_case(loaded: LoadedCase, out: Path) -> Plan:
    """Write the program of a case into the folder `out`, replacing what a compiler wrote there before.

    Raises:
        SpecError: with every problem found.
    """
    from text2sim.compiler.emit import emit

    plan = plan_case(loaded)
    files = emit(plan)
    for path, content in files.items():
        target = out / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
    return plan


def _stop_at_errors(problems: list[Problem]) -> None:
    if any(problem.severity == "error" for problem in problems):
        raise SpecError(problems)


def _groups(
    loaded: LoadedCase,
    placed: dict[str, list[Copy]],
    names: tuple[str, ...],
    section: str | None,
    lowering: Lowering,
    problems: list[Problem],
) -> tuple[Group, ...]:
    groups = []
    for name in names:
        pointer = ("scene", "statics", name) if section else ("bodies", name)
        entities: list[EntityPlan] = []
        for copy in placed[name]:
            try:
                entities.append(lowering.entity(copy.model, copy))
            except AssetError as error:
                key = next((key for key in ("shape", "file") if getattr(copy.model, key, None) is not None), None)
                problems.append(loaded.problem((*pointer, key) if key else pointer, str(error), rule="asset"))
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


def _traits(lowering: Lowering, moving: list[Copy], rows: Rows, bounce: dict[str, float]) -> Traits:
    trees = [tree for tree in lowering.trees.values()]
    joints = [joint for tree in trees for link in tree.links() for _, joint in link.all_joints()]
    loose = sum(
        1
        for copy in moving
        if copy.model.kind == "ragdoll" or getattr(getattr(copy.model, "mount", None), "kind", "") == "free"
    )
    fastest = max((sum(x * x for x in row.linear) ** 0.5 for row in rows.velocities), default=0.0)
    return Traits(
        loose=loose,
        geoms=lowering.pieces,
        chains=sum(joint.kind == "ball" for joint in joints),
        loops=sum(len(tree.loops) for tree in trees),
        attaches=sum(weld.on for weld in rows.welds),
        fastest=fastest,
        thinnest=lowering.thinnest,
        bounciest=max(bounce.values(), default=0.0),
    )


def _restitution(copy: Copy) -> float | None:
    material = getattr(copy.model, "material", None)
    return None if material is None else material.restitution


def _damping(
    placed: dict[str, list[Copy]], bounce: dict[str, float], statics: set[str], settings: Settings, step: float
) -> dict[str, tuple[float, float]]:
    """Time constant [s] and damping ratio for every copy.

    The engine takes the means of the two bodies' values. A static without a restitution of its own takes the largest
    of the scene, so that a ball bounces with its own value on a floor that says nothing.
    """
    largest = max(bounce.values())
    values = {}
    for name, group in placed.items():
        for copy in group:
            restitution = bounce.get(copy.name, largest if name in statics else 0.0)
            time, ratio = settings.contact_damping(restitution, step)
            values[copy.name] = (round(time, 9), round(ratio, 6))
    return values


def _check_bounce(loaded: LoadedCase, settings: Settings, bounce: dict[str, float]) -> list[Problem]:
    if not settings.bounce_time:
        return []
    largest = max(bounce.values())
    scene, time = loaded.case.scene, settings.bounce_time
    step = scene.dt / settings.substeps
    name = next(copy for copy, value in bounce.items() if value == largest).split("[")[0]
    section = ("scene", "statics", name) if name in scene.statics else ("bodies", name)
    pointer = (*section, "material", "restitution")
    needed = ceil(scene.dt / (SCATTER_BOUND * time))
    if step > ENERGY_BOUND * time * (1 + 1e-9):
        return [
            loaded.problem(
                pointer,
                f"restitution {largest:g} with contact timeconst {settings.timeconst:g} s would gain energy at a "
                f"substep of {step:g} s; it needs scene.substeps of at least {needed}, or a longer timeconst",
                rule="restitution-step",
            )
        ]
    if step > SCATTER_BOUND * time * (1 + 1e-9):
        return [
            loaded.problem(
                pointer,
                f"restitution {largest:g} scatters by up to 0.15 with the moment of touch, for a contact lasts only "
                f"{pi * time / step:.0f} substeps; it would be met with scene.substeps of {needed} or more",
                rule="rough-bounce",
                severity="warning",
            )
        ]
    if pi * time > CRISP:
        needed = ceil(scene.dt * pi / (CRISP * CRISPNESS))
        return [
            loaded.problem(
                pointer,
                f"contacts that bounce last {pi * time:.2g} s and are soft; with scene.substeps of {needed} or more "
                "they would be crisp",
                rule="soft-bounce",
                severity="warning",
            )
        ]
    return []


def _check_overlaps(loaded: LoadedCase, placed: dict[str, list[Copy]], lowering: Lowering) -> list[Problem]:
    """One warning for each pair of bodies, however many of their copies overlap."""
    pairs: dict[tuple[str, str], list[tuple[Copy, Copy]]] = {}
    for a, b in overlaps(placed, lowering):
        pairs.setdefault((a.body, b.body), []).append((a, b))
    found = []
    for (name, _), group in pairs.items():
        a, b = group[0]
        more = f" (and {len(group) - 1} more of their copies)" if len(group) > 1 else ""
        under = getattr(b.shape, "kind", None) == "plane"
        says = f"{a.name} is partly or wholly under {b.name}" if under else f"{a.name} and {b.name} overlap"
        then = "throw it out or let it fall; move it up" if under else "throw them apart; move one"
        pointer = ("scene", "statics", name) if name in loaded.case.scene.statics else ("bodies", name)
        text = f"{says} at the start{more}: the engine will {then}, or use place"
        found.append(loaded.problem(pointer, text, key=True, rule="overlap", severity="warning"))
    return found


# --- digests --------------------------------------------------------------------------------------------------


def _digest(content: Any) -> str:
    return sha256(json.dumps(content, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def _sim_digest(plan: Plan) -> str:
    """Digest of what the simulation depends on: no looks, no lines of the case, no film, no notes."""
    skipped = {"render", "notes", "warnings", "sim_digest", "render_digest", "why", "line", "surface", "control"}
    return _digest({"plan": _plain(plan, skipped), "compiler": __version__})


def _render_digest(plan: Plan) -> str:
    """Digest of what the film depends on besides the states."""
    surfaces = [_plain(e.surface, set()) for g in (*plan.statics, *plan.bodies) for e in g.entities]
    return _digest({"render": plan.render, "surfaces": surfaces, "compiler": __version__})


def _plain(value: Any, skipped: set[str]) -> Any:
    """Return a value as data that JSON can hold, without the fields named in `skipped`."""
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name), skipped) for f in fields(value) if f.name not in skipped}
    if isinstance(value, dict):
        return {key: _plain(item, skipped) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item, skipped) for item in value]
    return sha256(value).hexdigest() if isinstance(value, bytes) else value
