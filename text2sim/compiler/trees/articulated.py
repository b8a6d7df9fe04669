"""Articulated bodies that the case describes: a mapping of links becomes a tree."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from text2sim.compiler.shapes.rotation import quat_of
from text2sim.compiler.trees.joints import joint_of
from text2sim.compiler.trees.tree import Tree, TreeJoint, TreeLink, TreeLoop
from text2sim.spec_schema.models.bodies import Articulated
from text2sim.spec_schema.models.materials import Look, Material
from text2sim.spec_schema.names.selectors import spread_over

Shaped = Callable[[str, Any, Material, Look], TreeLink]
"""(link, shape, material, look) -> the link with its geoms and visuals."""


def articulated_tree(body: Articulated, shaped: Shaped) -> Tree:
    """Return the tree of an inline articulated body; its references were checked before."""
    links = body.links or {}
    children: dict[str | None, list[str]] = {}
    for name, link in links.items():
        children.setdefault(link.parent, []).append(name)

    def build(name: str) -> TreeLink:
        link = links[name]
        bare = shaped(name, link.shape, link.material or body.material, link.look or body.look)
        if link.parent is None:
            joint = TreeJoint("free") if body.base == "free" else None
        else:
            joint = None if link.joint is None or link.joint.kind == "fixed" else joint_of(link.joint)
        return replace(
            bare,
            pos=link.pose.pos,
            quat=quat_of(link.pose),
            joint=joint,
            children=tuple(build(child) for child in children.get(name, ())),
        )

    loops = tuple(
        TreeLoop(loop.kind, first, None if second == "world" else second, loop.anchor, loop.ratio or 0.0)
        for loop in body.loops.values()
        for first, second in [loop.between]
    )
    (root,) = children[None]
    movable = [name for name, link in links.items() if getattr(link.joint, "kind", None) in ("hinge", "slider")]
    return Tree(
        (build(root),), loops, self_collision=bool(body.self_collision), initial=spread_over(movable, body.initial)
    )
