"""Bodies of links before they are placed: their parts and their bounds."""

import re
from pathlib import Path
from typing import Any

from text2sim.assets.mechanism import Mechanism, Mechanisms, load_mechanism
from text2sim.compiler.lower import Lowering
from text2sim.compiler.memory import Memory, ObjectKey
from text2sim.compiler.placing.patterns import SINGLE
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import IDENTITY, ORIGIN, Quaternion, Vec
from text2sim.compiler.trees.file_bodies import mechanism_parts
from text2sim.compiler.trees.joints import joint_model
from text2sim.compiler.trees.tree import Tree, tree_bounds, tree_links, tree_pieces
from text2sim.spec_schema.errors import AssetError, Problem
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.bodies import Articulated, Rope
from text2sim.spec_schema.models.placed import Linked
from text2sim.spec_schema.names.name_table import Parts
from text2sim.spec_schema.names.selectors import strings_in

SELECTOR = re.compile(r"(?P<body>\w+)(?:\[[^\]]+\])?\.(?P<part>[\w*]+)\Z")
"""A link or joint of a body; an expression may stand in the brackets."""
_TREES: Memory[Tree] = Memory(16)
"""Recent trees, since placing asks for the same ones repeatedly. Every load makes new models, so none is stale."""


def tree_of(model: Any, folder: Path) -> Tree:
    """Return the tree of a chain, rope, net, ragdoll or articulated body, in its own frame.

    Raises:
        AssetError: if one of its files cannot be used.
    """

    def make() -> Tree:
        lowering = Lowering(folder)
        lowering.entity(model, Copy("body", "body", None, SINGLE, model, ORIGIN, IDENTITY, None, 1))
        return lowering.trees["body"]

    return _TREES.recall((ObjectKey(model), folder), make)


def tree_extents(model: Any, quat: Quaternion, folder: Path) -> Bounds:
    """Return the bounds [m] of a tree of links at the start, about its origin, turned by `quat`.

    Args:
        model: The body or static.
        quat: Orientation of the tree (w, x, y, z).
        folder: Folder of the case, for its files.

    Raises:
        AssetError: if one of its files cannot be used.
    """
    return tree_bounds(tree_of(model, folder), quat)


def tree_standing(model: Any, folder: Path) -> list[tuple[Piece, Vec, Quaternion]]:
    """Return the pieces of a tree of links at the start, each with the pose [m] of its link in the tree's frame.

    Raises:
        AssetError: if one of its files cannot be used.
    """
    return [standing[:3] for standing in tree_pieces(tree_of(model, folder))]


def link_frames(model: Any, folder: Path) -> dict[str, tuple[Vec, Quaternion]]:
    """Return the frames [m] of the links of a tree at the start, by name, in the tree's frame.

    Raises:
        AssetError: if one of its files cannot be used.
    """
    return {standing.link.name: (standing.pos, standing.quat) for standing in tree_links(tree_of(model, folder))}


def known_parts(loaded: LoadedCase, mechanisms: Mechanisms) -> tuple[dict[str, Parts], list[Problem]]:
    """Return what selectors can name of bodies whose links are not written in the case, and what is wrong there.

    Files that are read are added to `mechanisms`. If the file differs from copy to copy, that of the first copy counts.
    """
    parts: dict[str, Parts] = {}
    problems: list[Problem] = []
    for name, body in loaded.case.bodies.items():
        if isinstance(body, Articulated) and body.file is not None:
            try:
                mechanism = mechanisms.get((body.file, body.base))
                if mechanism is None:
                    mechanism = load_mechanism(loaded.folder, body.file, base=body.base)
                    mechanisms[body.file, body.base] = mechanism
            except AssetError as error:
                problems.append(loaded.problem(("bodies", name, "file"), str(error), rule="asset"))
                continue
            parts[name] = mechanism_parts(mechanism, body)
            problems += _check_meaning(loaded, name, body, mechanism)
        elif isinstance(body, Rope):
            # Its tree is known only when it is placed, as it may be laid round other bodies.
            links = tuple(f"link_{k}" for k in range(body.segments))
            parts[name] = Parts(links, {link: joint_model("ball") for link in links[not body.anchored :]})
        elif isinstance(body, Linked):
            try:
                tree = tree_of(body, loaded.folder)
            except AssetError:
                continue  # reported where the body is lowered
            joints = {key: joint_model(one.kind, one.range) for key, one in tree.joints() if one.kind != "free"}
            parts[name] = Parts(tuple(link.name for link in tree.links()), joints)
    return parts, problems


def named_parts(loaded: LoadedCase) -> dict[str, set[str]]:
    """Return the links and joints that the case names, by body: whatever looks like a selector counts."""
    found: dict[str, set[str]] = {}
    for text in strings_in([loaded.data.get("actions"), loaded.data.get("render")]):
        if match := SELECTOR.match(text):
            found.setdefault(match["body"], set()).add(match["part"])
    return found


def _check_meaning(loaded: LoadedCase, name: str, body: Articulated, mechanism: Mechanism) -> list[Problem]:
    """Report what the case says about a body although its file decides it."""
    root = ("bodies", name)
    found = []

    def report(key: tuple[str, ...], message: str) -> None:
        found.append(loaded.problem((*root, *key), message, key=True, rule="file-decides"))

    if body.self_collision is not None:
        report(
            ("self_collision",),
            "the file decides which of its links touch each other: contype, conaffinity, exclude",
        )
    if body.material.mass is not None:
        report(("material", "mass"), "the masses are those of the file; change them there")
    if "density" in body.material.model_fields_set and not mechanism.inertialess:
        report(("material", "density"), "the masses are those of the file; change them there")
    return found
