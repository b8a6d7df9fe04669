"""Export of a case to files that any simulator can read.

benchmark.json   everything except shapes: links, joints, start, controls, observables with references
scene.xml        shapes, masses and joints of rigid and articulated scenes as MJCF; scene.usda as OpenUSD (UsdPhysics)
meshes/          shapes that are not primitives
case.yaml        the case, which defines the measures
"""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from text2sim.cluster.task import Done
from text2sim.compiler.plan import EntityPlan, Plan
from text2sim.engine_benchmark.controls import tables
from text2sim.engine_benchmark.mjcf import build, obstacles
from text2sim.engine_benchmark.reference import Runs, collect, references
from text2sim.engine_benchmark.statement import Statement, read_statement
from text2sim.engine_benchmark.usd import write_usd
from text2sim.harness.folder import staging
from text2sim.recording.states import RunStates
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.reuse.expanded import expanded_text
from text2sim.spec_schema.whole_files import write_atomically

FORMAT = 1
JOINTS = ("hinge", "slider")


def export(loaded: LoadedCase, plan: Plan, out: Path, done: Sequence[Done]) -> dict[str, Any]:
    """Write the benchmark of a case into a folder, replacing an older one.

    Args:
        loaded: The case.
        plan: Its plan.
        out: The folder.
        done: Results of the runs of `reference.tasks_of`.

    Returns:
        The content of `benchmark.json`.

    Raises:
        SpecError: if `benchmark.yaml` is invalid.
        RunError: if a run did not finish, or `out` is not a benchmark.
    """
    statement = read_statement(loaded)
    ran = collect(loaded, list(statement.observables), done)
    scene = _scene(loaded, plan, statement, ran)
    with staging(out.absolute().parent) as stage:
        folder = stage / "benchmark"
        folder.mkdir()
        write_atomically(folder / "case.yaml", expanded_text(loaded))
        write_atomically(folder / "benchmark.json", json.dumps(scene, indent=1, allow_nan=False) + "\n")
        if scene["complete"]:
            _write_models(plan, folder)
        else:
            for path, data in plan.files.items():
                (folder / "meshes" / path).parent.mkdir(parents=True, exist_ok=True)
                (folder / "meshes" / path).write_bytes(data)
        if out.exists():
            if not (out / "benchmark.json").is_file():
                raise RunError(f"{out} exists and is not a benchmark; choose another folder")
            shutil.rmtree(out)
        folder.rename(out.absolute())
    return scene


def _scene(loaded: LoadedCase, plan: Plan, statement: Statement, ran: Runs) -> dict[str, Any]:
    """Content of `benchmark.json`."""
    layout = json.loads((ran.folders[0] / "states/layout.json").read_text("utf-8"))
    why_not = obstacles(plan)
    morphs = {entity.name: entity.morph for group in (*plan.statics, *plan.bodies) for entity in group.entities}
    return {
        "text2sim_benchmark": FORMAT,
        "name": plan.case,
        "about": statement.about or loaded.case.prompt,
        "units": "SI: m, kg, s, rad; quaternions are (w, x, y, z)",
        "duration": plan.dt * plan.steps,
        "step": plan.dt / plan.settings.substeps,
        "gravity": plan.gravity,
        "contact": {
            "friction_cone": plan.settings.cone,
            "timeconst": plan.settings.timeconst,
            "of_bodies": {name: {"timeconst": t, "dampratio": ratio} for name, (t, ratio) in plan.contact.items()},
        },
        "complete": not why_not,
        "left_out": why_not,
        "bodies": [_entity(e, why_not) for group in plan.bodies for e in group.entities],
        "statics": [_entity(e, why_not) for group in plan.statics for e in group.entities],
        "links": _links(layout, ran, morphs),
        "joints": layout["joints"],
        "initial_joints": [
            {"body": body, "joint": joint, "position": position}
            for body, joints in plan.initial.items() for joint, position in joints.items()
        ],
        "initial_joint_velocities": [
            {"body": body, "joint": joint, "velocity": velocity}
            for body, joints in plan.joint_velocities.items() for joint, velocity in joints.items()
        ],
        "initial_velocities": [
            {"body": row.entity, "linear": row.linear, "angular": row.angular} for row in plan.velocities
        ],
        "controls": [] if why_not else tables(plan),
        "forces": [_force(row, morphs) for row in plan.wrenches],
        "times": [float(f"{t:.9g}") for t in ran.times],
        "observables": references(ran, statement),
        "ours": _engine_and_cost(ran),
        "layout": layout,
    }  # fmt: skip


def _write_models(plan: Plan, folder: Path) -> None:
    spec = build(plan)
    model = spec.compile()
    for mesh in spec.meshes:
        if mesh.file:
            target = folder / "meshes" / Path(mesh.file).name
            target.parent.mkdir(exist_ok=True)
            target.write_bytes(next(data for path, data in plan.files.items() if Path(path).name == target.name))
            mesh.file = f"meshes/{target.name}"
    write_atomically(folder / "scene.xml", spec.to_xml())
    write_usd(model, plan, folder / "scene.usda")


def _entity(entity: EntityPlan, why_not: list[str]) -> dict[str, Any]:
    row: dict[str, Any] = {"name": entity.name, "shape": entity.morph, "pos": entity.pos, "quat": entity.quat}
    if entity.morph == "MJCF" and not why_not:
        return {**row, "shape": "mechanism: see links, joints and scene.xml"}
    row |= {key: value for key, value in entity.options.items() if key not in ("fixed", "visualization")}
    row |= {"density": entity.rho, "friction": entity.friction}
    row |= {key: value for key, value in entity.material_options.items() if key.startswith("friction_")}
    if entity.family != "rigid":
        row |= {"material": entity.material, "parameters": entity.material_options}
        row["mass"] = entity.soft.mass if entity.soft else None
    return row


def _links(layout: dict[str, Any], ran: Runs, morphs: dict[str, str]) -> list[dict[str, Any]]:
    states, rows = RunStates.load(ran.folders[0]), []
    for k, row in enumerate(layout["links"]):
        name = f"{row['body']}/{row['link']}" if morphs.get(row["body"]) == "MJCF" else row["body"]
        rows.append({**row, "pos": states.pos[0, k].tolist(), "quat": states.quat[0, k].tolist(), "mjcf": name})
    return rows


def _force(row: Any, morphs: dict[str, str]) -> dict[str, Any]:
    link = f"{row.entity}/{row.link}" if row.link else row.entity
    if not row.link and morphs[row.entity] == "MJCF":
        link = f"{row.entity}/{row.entity.partition('[')[0]}"
    return {
        "body": row.entity, "link": row.link, "mjcf": link, "start": row.start, "end": row.end,
        "force": row.force, "torque": row.torque,
    }  # fmt: skip


def _engine_and_cost(ran: Runs) -> dict[str, Any]:
    record = ran.records[0]
    return {
        "engine": f"Genesis {record.versions.get('genesis-world', '')}",
        "seconds": record.timings.get("simulate", record.wall),
        "memory": record.peak_memory,
    }
