"""Export of the scene of a rigid case as one MJCF model."""

import io
from typing import Any

import numpy as np

from text2sim.compiler.plan import EntityPlan, Plan
from text2sim.engine_benchmark.controls import tables
from text2sim.engine_benchmark.mujoco_door import mujoco

NOT_YET = {
    "prescribed": "driven bodies",
    "belts": "statics whose surfaces move",
    "welds": "welds that begin or end during the simulation",
    "bonds": "bonds and attachments that break",
    "springs": "springs between bodies",
    "removals": "bodies that are removed",
    "fields": "fields",
    "airflows": "moving air",
    "watches": "releases on events",
    "holds": "held points",
    "pushes": "pushes on points",
    "frictions": "friction of pairs",
    "changes": "changed joints of model files",
    "damped": "damping of free bodies",
}


def obstacles(plan: Plan) -> list[str]:
    """Return what prevents exporting a case as one MJCF model, in words."""
    found = [words for name, words in NOT_YET.items() if getattr(plan, name)]
    entities = [entity for group in (*plan.statics, *plan.bodies) for entity in group.entities]
    found += sorted({f"bodies of the family {entity.family}" for entity in entities if entity.family != "rigid"})
    if any(entity.morph == "URDF" for entity in entities):
        found.append("URDF files")
    if any(entity.options.get("contact") == "decompose" for entity in entities):
        found.append("decomposed shapes")
    if any(entity.options.get("contact") == "exact" for entity in entities):
        found.append("meshes with exact contact")
    if any(drive.later or len({segment.mode for segment in drive.segments}) > 1 for drive in plan.drives):
        found.append("drives that wait for events or change their mode")
    if any(wrench.point is not None or wrench.local for wrench in plan.wrenches):
        found.append("forces that rotate with a body, or act beside its centre")
    if any(wrench.scale is not None for wrench in plan.wrenches):
        found.append("forces that change with time")
    return found


def build(plan: Plan) -> Any:
    """Return the scene as an `MjSpec`.

    Bodies have the names of the copies; a link of a mechanism is `COPY/LINK`, its joint `COPY/JOINT`, and a motor has
    the name of its joint. The `ctrl` of a motor is stiffness x target + damping x target velocity.
    """
    mj = mujoco()
    spec = mj.MjSpec()
    spec.modelname = plan.case
    settings = plan.settings
    spec.option.timestep = plan.dt / settings.substeps
    spec.option.gravity = plan.gravity
    spec.option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = getattr(mj.mjtCone, f"mjCONE_{settings.cone.upper()}")
    for group in plan.statics:
        for entity in group.entities:
            _add(spec, plan, entity, fixed=True)
    for group in plan.bodies:
        for entity in group.entities:
            _add(spec, plan, entity, fixed=bool(entity.options.get("fixed")))
    for equality in spec.equalities:
        equality.solref = [settings.timeconst, 1.0]
    for row in tables(plan):
        kp = row["stiffness"] if row["mode"] == "position" else 0.0
        kv = 0.0 if row["mode"] == "force" else row["damping"]
        name = f"{row['body']}/{row['joint']}"
        motor = spec.add_actuator(name=name, target=name, trntype=mj.mjtTrn.mjTRN_JOINT)
        motor.gaintype, motor.biastype = mj.mjtGain.mjGAIN_FIXED, mj.mjtBias.mjBIAS_AFFINE
        motor.gainprm[0], motor.biasprm[:3] = 1.0, [0.0, -kp, -kv]
        if row["max_force"] is not None:
            motor.forcelimited, motor.forcerange = True, [-row["max_force"], row["max_force"]]
    return spec


def _add(spec: Any, plan: Plan, entity: EntityPlan, *, fixed: bool) -> None:
    mj = mujoco()
    if entity.morph == "MJCF":
        _attach(spec, plan, entity)
        return
    body = spec.worldbody.add_body(name=entity.name, pos=entity.pos, quat=entity.quat)
    if not fixed and entity.morph != "Plane":
        body.add_freejoint(name=entity.name)
    options: Any = entity.options
    shapes = {
        "Box": lambda: (mj.mjtGeom.mjGEOM_BOX, [size / 2 for size in options["size"]]),
        "Sphere": lambda: (mj.mjtGeom.mjGEOM_SPHERE, [options["radius"], 0, 0]),
        "Cylinder": lambda: (mj.mjtGeom.mjGEOM_CYLINDER, [options["radius"], options["height"] / 2, 0]),
        "Plane": lambda: (mj.mjtGeom.mjGEOM_PLANE, [0, 0, 1]),
        "Mesh": lambda: (mj.mjtGeom.mjGEOM_MESH, [0, 0, 0]),
    }
    kind, size = shapes[entity.morph]()
    geom = body.add_geom(name=entity.name, type=kind, size=size, density=entity.rho or 0.0)
    if entity.morph == "Mesh":
        vertices = np.asarray(_mesh(plan.files[options["file"]], options["file"])) * options.get("scale", 1.0)
        spec.add_mesh(name=entity.name, uservert=vertices.ravel().tolist())
        geom.meshname = entity.name
    torques = [entity.material_options.get(key, 0.0) for key in ("friction_torsional", "friction_rolling")]
    geom.friction = [entity.friction or 0.0, *torques]
    _touch(geom, plan, entity.name)


def _attach(spec: Any, plan: Plan, entity: EntityPlan) -> None:
    """Add a mechanism; its collision masks, which only apply within one model, become excluded pairs."""
    mj = mujoco()
    file = str(entity.options["file"])
    folder = file.rpartition("/")[0]
    text = plan.files[file].decode()
    assets = {name: data for path, data in plan.files.items() if (name := path.removeprefix(f"{folder}/")) in text}
    child = mj.MjSpec.from_string(text, assets=assets)
    apart = False
    for geom in list(child.geoms):
        if not geom.contype and not geom.conaffinity:
            child.delete(geom)  # only drawn
            continue
        apart |= geom.contype != geom.conaffinity
        geom.contype = geom.conaffinity = 1
        _touch(geom, plan, entity.name, geom.parent.name)
    used = {geom.meshname for geom in child.geoms}
    for mesh in [mesh for mesh in child.meshes if mesh.name not in used]:
        child.delete(mesh)
    for thing in (*child.materials, *child.textures):
        child.delete(thing)
    links = [body.name for body in child.bodies if body.name != "world"]
    for k, one in enumerate(links if apart else []):
        for other in links[k + 1 :]:
            child.add_exclude(bodyname1=one, bodyname2=other)
    frame = spec.worldbody.add_frame(pos=entity.pos, quat=entity.quat)
    spec.attach(child, prefix=f"{entity.name}/", frame=frame)


def _touch(geom: Any, plan: Plan, name: str, link: str = "") -> None:
    usual = plan.contact.get(name, (plan.settings.timeconst, 1.0))
    geom.solref = plan.contact.get(f"{name}.{link}", usual)
    if plan.settings.rolls:
        geom.condim = 6


def _mesh(data: bytes, name: str) -> Any:
    import trimesh

    return trimesh.load_mesh(io.BytesIO(data), file_type=name.rpartition(".")[2]).vertices
