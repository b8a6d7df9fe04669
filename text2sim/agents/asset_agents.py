"""Asset agents: specialists that make mechanisms and shapes before the bodies are written."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, StringConstraints

from text2sim.agents import language
from text2sim.agents.asset_proof import Proof, try_body
from text2sim.agents.conversation import Conversation, Wrong, typed_parser
from text2sim.agents.inputs import describe_joint
from text2sim.agents.planning import Request, plan_text
from text2sim.agents.replies import Answer, Asset, CasePlan, Line, Lines
from text2sim.agents.roles import ROLES, render, system_prompt
from text2sim.spec_schema.models.bodies import LINKED


class MechanismAnswer(Answer):
    """A mechanism: a body and the controls that it offers."""

    body: dict[str, Any]
    controls: Lines = []


class MeshWish(Answer):
    """Request to a text-to-3D service."""

    prompt: Annotated[str, StringConstraints(min_length=3, max_length=600)]
    size: Annotated[float, Field(gt=0, le=100)]
    """Largest extent [m]."""


class ShapeAnswer(Answer):
    """A shape, or a request for a generated mesh."""

    shape: dict[str, Any] | None = None
    generate: MeshWish | None = None
    note: Line = ""


@dataclass
class Supplies:
    """Output of the asset agents."""

    bodies: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Complete bodies, which go into the case unchanged."""
    shapes: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Shapes, which go unchanged into bodies and statics that Writers write."""
    words: list[str] = field(default_factory=list)
    """Notes on them for the Writers."""


def make_asset(chat: Conversation, asset: Asset, plan: CasePlan, request: Request, case: Path) -> Supplies:
    """Have one asset made.

    Args:
        chat: The conversation with the models.
        asset: The asset that the plan asks for.
        plan: The plan.
        request: The user's request.
        case: The case folder.
    """
    maker = _mechanism if asset.kind == "mechanism" else _shape
    return maker(chat, asset, plan, request, case)


def _mechanism(chat: Conversation, asset: Asset, plan: CasePlan, request: Request, case: Path) -> Supplies:
    proofs: list[Proof] = []

    def check(answer: MechanismAnswer) -> None:
        if answer.body.get("kind") not in LINKED:
            raise Wrong([f"/body/kind: a mechanism is one of {', '.join(LINKED)}"])
        proof = try_body(asset.body, answer.body, plan, case, asset.what)
        if proof.faults:
            raise Wrong(proof.faults)
        proofs.append(proof)

    kinds = {"articulated", "hinge", "slider", "ball", "fixed", "free", "compound", "cylinder", "capsule", "tube"}
    system = system_prompt(
        ROLES["articulation"], rules=language.rules(), pages=language.reference_pages("bodies", kinds)
    )
    question, images = _question(asset, plan, request), request.images
    answer = chat.ask("articulation", system, question, typed_parser(MechanismAnswer, check), images)
    links = ", ".join(f"{asset.body}.{name}" for name in answer.body.get("links") or {})
    words = f"`{asset.body}`: a mechanism, complete. Links and joints: {links or 'see its kind'}."
    joints = [describe_joint(f"{asset.body}.{name}", one) for name, one in (proofs[-1].control or {}).items()]
    probed = [f"Tried in the engine: {'; '.join(joints)}."] if joints else []
    return Supplies({asset.body: answer.body}, words=[" ".join([words, *answer.controls, *probed, *proofs[-1].notes])])


def _shape(chat: Conversation, asset: Asset, plan: CasePlan, request: Request, case: Path) -> Supplies:
    kind = plan.bodies[asset.body].kind
    takes = language.shapes_of(kind) or language.shapes_of("rigid")

    def check(answer: ShapeAnswer) -> None:
        if answer.shape is None and answer.generate is None:
            raise Wrong(["answer with `shape` or with `generate`"])
        if answer.generate is not None and not _text_to_3d():
            raise Wrong(["/generate: there is no text-to-3D service here; build the shape"])
        if answer.shape is None:
            return
        if answer.shape.get("kind") not in takes:
            got = f"`{answer.shape.get('kind')}` is not a shape of a {kind} body"
            raise Wrong([f"/shape/kind: {got}, which takes {', '.join(takes)}"])
        # A static is tried as a rigid body. A deformable body keeps its kind, since its mesh must be watertight.
        body = {"kind": "rigid" if kind not in language.body_kinds() else kind, "shape": answer.shape}
        if wrong := try_body(asset.body, body, plan, case, asset.what).faults:
            raise Wrong(wrong)

    pages = language.reference_pages("bodies", set(takes) - _BARE | _SCULPTED)
    system = system_prompt(ROLES["mesh"], rules=language.rules(), pages=pages, text_to_3d=_text_to_3d())
    question = _question(asset, plan, request, f"It is for a `{kind}` body, which takes the shapes {', '.join(takes)}.")
    answer = chat.ask("mesh", system, question, typed_parser(ShapeAnswer, check), request.images)
    shape = answer.shape
    if shape is None:
        assert answer.generate is not None
        shape = _generated(asset.body, answer.generate, case)
    return Supplies(shapes={asset.body: shape}, words=[f"`{asset.body}`: its `shape`. {answer.note}"])


_BARE = frozenset({"plane", "stream"})
"""Shapes that give a body no form: they are not described to the mesh agent."""
_SCULPTED = frozenset({"limb", "revolve", "loft"})
"""Parts of a sculpt, which are not shapes by themselves."""


def _text_to_3d() -> bool:
    return bool(os.environ.get("MESHY_API_KEY"))


def _generated(name: str, wish: MeshWish, case: Path) -> dict[str, Any]:
    """Generate a mesh with Meshy, repair it, and register it in the case's manifest."""
    from text2sim.asset_intake.register import generate
    from text2sim.assets.mesh_repair import RepairGoal
    from text2sim.assets.meshy import BASE_URL, Meshy, Order3D

    meshy = Meshy(case, base=os.environ.get("TEXT2SIM_MESHY_URL", BASE_URL))
    added = generate(case, name, Order3D(wish.prompt), meshy, goal=RepairGoal(wish.size))
    return {"kind": "mesh", "file": added.asset.file}


def _question(asset: Asset, plan: CasePlan, request: Request, receiver: str = "") -> str:
    return render(
        "asset_ask",
        request=request.text,
        plan=plan_text(plan),
        body=asset.body,
        what=asset.what,
        receiver=receiver,
        inputs=request.inputs,
    )


def merge_supplies(parts: Sequence[Supplies]) -> Supplies:
    """Merge the output of several agents."""
    whole = Supplies()
    for part in parts:
        whole.bodies |= part.bodies
        whole.shapes |= part.shapes
        whole.words += part.words
    return whole
