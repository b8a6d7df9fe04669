"""Trials of bodies that asset agents wrote: each is resolved, drawn, driven in the engine, and registered."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from text2sim.agents.assembly import examine, format_problem
from text2sim.agents.replies import CasePlan
from text2sim.assets.manifest import Asset, Control, read_manifest, register
from text2sim.assets.safe_write import FOLDER, digest, write_asset
from text2sim.compiler.lower import PLACEMENT_KEYS
from text2sim.spec_schema.errors import AssetError, MachineError, SpecError
from text2sim.spec_schema.text.canonical import format_text
from text2sim.spec_schema.whole_files import write_atomically

PREVIEWS = "generation/previews"


@dataclass(frozen=True)
class Proof:
    """Result of a trial."""

    faults: tuple[str, ...] = ()
    """Faults, in words for the agent that wrote the body."""
    control: dict[str, Control] | None = None
    notes: tuple[str, ...] = ()


def try_body(name: str, body: dict[str, Any], plan: CasePlan, case: Path, prompt: str) -> Proof:
    """Try a body by itself and register it in the manifest if it is valid; the same body is not tried twice.

    Args:
        name: Name of the body in the plan.
        body: The body as written in a case; its pose is ignored.
        plan: The plan, which defines the parameters.
        case: The case folder.
        prompt: The agent's task, which is recorded in the manifest.
    """
    placed = _without_place(body) | {"pose": {"pos": [0, 0, 2]}}
    text = format_text(json.dumps(_document(name, placed, plan), ensure_ascii=False))
    content = format_text(json.dumps({"params": plan.params, "body": body}, ensure_ascii=False)).encode()
    assets = read_manifest(case).assets if case.is_dir() else {}
    asset_name = name if name not in assets or assets[name].source == "procedural" else f"{name[:40]}_written"
    file, known = f"{FOLDER}/{asset_name}.yaml", assets.get(asset_name)
    if known is not None and known.sha256 == digest(content):
        return Proof(control=dict(known.control), notes=known.notes)
    examination = examine(text, case / "case.yaml")
    faults = [
        format_problem(problem)
        for problem in examination.errors
        if problem.path.startswith(f"/bodies/{name}") or not problem.path
    ]
    if faults or examination.loaded is None:
        return Proof(tuple(faults or [format_problem(problem) for problem in examination.errors]))
    if (failure := _draw(name, examination.loaded, case)) is not None:
        return Proof((f"/body: it cannot be drawn: {failure}",))
    proof = _drive_joints(examination.loaded.data["bodies"][name], case)
    if proof.faults:
        return proof
    case.mkdir(parents=True, exist_ok=True)
    write_asset(case, file, content)
    kind = "mechanism" if body.get("kind") == "articulated" else "shape"
    asset = Asset(file=file, kind=kind, source="procedural", licence="written for this case", sha256=digest(content),
                  bytes=len(content), prompt=prompt, notes=proof.notes, control=proof.control or {})  # fmt: skip
    register(case, asset_name, asset)
    return proof


def _without_place(body: dict[str, Any]) -> dict[str, Any]:
    return {key: row for key, row in body.items() if key not in PLACEMENT_KEYS}


def _document(name: str, body: dict[str, Any], plan: CasePlan) -> dict[str, Any]:
    scene: dict[str, Any] = {"duration": 0.3, "dt": 0.005, "statics": {"floor": {"shape": {"kind": "plane"}}}}
    return {"text2sim": 2, "name": "trial", "params": plan.params, "scene": scene, "bodies": {name: body}}


def _draw(name: str, loaded: Any, case: Path) -> str | None:
    """Save a picture of the case; return the reason if that fails."""
    from text2sim.compiler.build import resolve_case
    from text2sim.drawing.portrait import portrait

    try:
        picture = portrait(resolve_case(loaded))
    except AssetError as error:
        return str(error)
    except SpecError as error:  # some faults of shapes show only here
        return "; ".join(problem.message for problem in error.problems)
    folder = case / PREVIEWS
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(folder / f"{name}.png", picture)
    return None


def _drive_joints(body: dict[str, Any], case: Path) -> Proof:
    """Drive the joints that have motors, and report those that do not respond."""
    from text2sim.asset_intake.mechanism_check import check_mechanism
    from text2sim.asset_intake.probe import probe

    if body.get("kind") != "articulated":
        return Proof()
    alone = _without_place(body) | {"base": "fixed"}
    try:
        report = check_mechanism(alone, case)
    except AssetError as error:
        return Proof((f"/body: {error}",))
    try:
        motorised = [
            name for name, joint in report.control.items() if joint.actuator is not None and joint.kind != "ball"
        ]
        if not motorised:
            return Proof(control=dict(report.control), notes=report.notes)
        found = probe(alone, case)
    except AssetError as error:
        return Proof((f"/body: {error}",))
    except MachineError as error:
        return Proof(control=dict(report.control), notes=(*report.notes, f"not probed: {error}"))
    unresponsive = [
        f"/body/links/{name}/joint: asked to go {joint.target:.3g}, without gravity, it came {joint.moved:.3g}: its "
        "motor is too weak or too soft, or something is in its way"
        for name, joint in found.joints.items()
        if name in motorised and not joint.answers
    ]
    if unresponsive and not report.loops:
        return Proof(tuple(unresponsive))
    if found.state != "finished":
        return Proof((f"/body: alone in the engine it ends as {found.state}: {found.message}",))
    return Proof(control=dict(found.control), notes=(*report.notes, *unresponsive))
