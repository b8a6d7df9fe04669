"""Deformable bodies in the resolution of a case: what lowers them, and the settings of their solvers."""

from dataclasses import replace
from math import hypot

from text2sim.compiler.controls import ControlRows
from text2sim.compiler.files import Files
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.plan import Group
from text2sim.compiler.soft.lowering import SoftLowering
from text2sim.compiler.soft.meshes import MeshFiles
from text2sim.compiler.soft.scales import scales
from text2sim.compiler.soft.settings import derive_soft
from text2sim.compiler.soft.setup import SoftSettings
from text2sim.compiler.soft.solvers import contact_model, is_soft
from text2sim.compiler.soft.speeds import impact_speed, speed_limit
from text2sim.compiler.soft.travel import travel
from text2sim.spec_schema.errors import AssetError, SpecError
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.names.selectors import body_of


def soft_lowering(loaded: LoadedCase, placed: dict[str, list[Copy]], files: Files) -> SoftLowering | None:
    """Return what lowers deformable bodies, with their resolution; None if there are none.

    Args:
        loaded: The case.
        placed: Copies by static and body.
        files: Files of the program, to which meshes are added.

    Raises:
        SpecError: if the file of a shape cannot be used.
    """
    case = loaded.case
    if not any(is_soft(body) for body in case.bodies.values()):
        return None
    try:
        fine = scales(case.scene, placed, loaded.folder)
    except AssetError as error:
        raise SpecError([loaded.problem(("bodies",), str(error), rule="asset")]) from error
    model = contact_model(case.bodies.values(), case.scene)
    controls = case.actions.controls.values()
    acted_on = frozenset(body_of(name) for one in controls for name in listed(getattr(one, "body", None)))
    return SoftLowering(case.scene, model, fine, MeshFiles(loaded.folder, files), acted_on)


def soft_settings(
    loaded: LoadedCase,
    placed: dict[str, list[Copy]],
    lowering: SoftLowering | None,
    bodies: tuple[Group, ...],
    rows: ControlRows,
) -> SoftSettings | None:
    """Return the settings of the solvers of deformable bodies; None if there are none.

    Args:
        loaded: The case.
        placed: Copies by static and body.
        lowering: What lowered them.
        bodies: Their entities.
        rows: Controls, lowered.
    """
    if lowering is None:
        return None
    case, scene = loaded.case, loaded.case.scene
    masses = {entity.name: entity.soft.mass for group in bodies for entity in group.entities if entity.soft}
    gravity = hypot(*scene.gravity)
    travels = travel(rows, case.actions.controls.values(), placed, masses, gravity, scene.duration)
    fastest = max((hypot(*row.linear) for row in rows.velocities if row.entity in masses), default=0.0)
    impact = impact_speed(scene, rows, placed, loaded.folder)
    settings = derive_soft(scene, lowering.model, lowering.scales, placed, travels, fastest, impact, loaded.folder)
    if scene.max_speed is not None:
        return replace(settings, max_speed=scene.max_speed)
    limit, why = speed_limit(scene, case.actions.controls.values(), rows, placed, masses, loaded.folder)
    return replace(settings, max_speed=limit, why=settings.why | {"max_speed": why})
