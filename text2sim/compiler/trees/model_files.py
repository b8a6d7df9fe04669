"""The model files of a program, and the meshes beside them."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path, PurePosixPath
from typing import Any

from text2sim.assets.mechanism import Mechanism
from text2sim.compiler.digests import unpainted
from text2sim.compiler.files import Files
from text2sim.compiler.looks import Rgba
from text2sim.compiler.shapes.casemesh import load_mesh
from text2sim.compiler.shapes.distance_field import LEAST_NODES, DistanceField
from text2sim.compiler.shapes.piece import Ball
from text2sim.compiler.shapes.sculpting import DIGEST_PREFIX, sculpted_obj
from text2sim.compiler.shapes.surface import learn_digests
from text2sim.compiler.trees.mjcf import write_mjcf
from text2sim.compiler.trees.tree import Tree, link_colors, tree_balls, uncolored
from text2sim.spec_schema.errors import AssetError

PIECES_OF_A_MESH = 16
"""Assumed number of convex pieces of a decomposed mesh; only the engine knows the true one."""

MAX_SURFACES = 250
"""Most different surfaces of a scene; each is a file that the engine reads and prepares."""


@dataclass(frozen=True)
class Written:
    """A tree with its model file."""

    tree: Tree
    options: dict[str, Any]
    """Keyword arguments of the morph."""
    color: Rgba | None
    """The colour of all of it, which the file then lacks; None if there are several."""
    balls: list[Ball]
    """Balls around its pieces, in its own frame."""
    pieces: int
    """How many convex pieces it has."""
    grid: dict[str, Any]
    """Keyword arguments of the engine's material for exact contact."""
    notes: tuple[str, ...]
    """What to tell about exact contact."""


def count_pieces(tree: Tree) -> int:
    """Return how many convex pieces a tree has."""
    return sum(PIECES_OF_A_MESH if g.piece.collision == "decompose" else 1 for g in (*tree.geoms(), *tree.fixtures))


def _exact(fields: dict[str, DistanceField | None]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return keyword arguments of the engine's material for the fields of meshes by file, and notes about them."""
    made = {file: field for file, field in fields.items() if field is not None}
    if not made:
        return {}, ()
    grid = {
        "sdf_cell_size": float(f"{min(field.cell for field in made.values()):.4g}"),
        "sdf_min_res": LEAST_NODES,
        "sdf_max_res": max(field.most for field in made.values()),
    }
    names = {file: "the sculpt" if file.startswith(DIGEST_PREFIX) else f"`{file}`" for file in made}
    return grid, tuple(f"{names[file]} touches by its surface, {field}" for file, field in made.items())


@dataclass
class ModelFiles:
    """Collects files by their path in the program's folder; equal content is kept once."""

    folder: Path
    """The case's folder, for meshes."""
    files: Files = field(default_factory=Files)
    _surfaces: set[str] = field(default_factory=set)
    """Digests of the surfaces so far."""

    def write(self, body: str, tree: Tree) -> Written:
        """Write the model file of a tree.

        Raises:
            AssetError: if the engine cannot use its meshes.
        """
        meshes: dict[str, str] = {}
        learn_digests(visual.mesh for link in tree.links() for visual in link.visuals)
        collisions: set[str] = set()
        for link in tree.links():
            for visual in link.visuals:
                mesh, digest = visual.mesh, visual.mesh.digest
                meshes[digest] = self._add(f"{digest[:12]}.obj", mesh.obj)
                self._surfaces.add(digest)
                if len(self._surfaces) > MAX_SURFACES:
                    raise AssetError(
                        f"with this, the scene has more than {MAX_SURFACES} different surfaces, too many for the "
                        "engine; let copies have the same shape"
                    )
                if mesh.picture is not None:
                    meshes[f"{digest}.png"] = self._add(f"{digest[:12]}.png", lambda mesh=mesh: mesh.picture or b"")
            for piece in (geom.piece for geom in link.geoms if geom.piece.file is not None):
                meshes[str(piece.file)] = self._mesh(str(piece.file))
                collisions.add(piece.collision)
        if len(collisions) > 1:
            raise AssetError("the engine treats all meshes of a body alike: give all of them the same `collision`")
        # A single colour is given to the entity, so that copies of different colours share one file.
        colors = {rgba for link in tree.links() for rgba in link_colors(link)} | {geom.rgba for geom in tree.fixtures}
        color = colors.pop() if len(colors) == 1 else None
        if color is not None:
            tree = uncolored(tree)
        text = write_mjcf(tree, body, meshes).encode()
        path = f"models/{body}.xml"
        if self.files.get(path, text) != text:
            # Looks are not part of the name: a body in other colours is the same simulation.
            stem, number = f"models/{body}_{sha256(unpainted(text)).hexdigest()[:8]}", 1
            path = f"{stem}.xml"
            while self.files.get(path, text) != text:
                number += 1
                path = f"{stem}_{number}.xml"
        self.files[path] = text
        options: dict[str, Any] = {"file": path}
        if collisions:
            options["contact"] = collisions.pop()
        fields = {str(geom.piece.file): geom.piece.field for geom in tree.geoms()}
        return Written(tree, options, color, tree_balls(tree), count_pieces(tree), *_exact(fields))

    def add_mechanism(self, body: str, mechanism: Mechanism) -> str:
        """Put a file's body into the program, in a folder of its own; return the path of the document."""
        name = f"{body}.{'urdf' if mechanism.kind == 'urdf' else 'xml'}"
        contents = {name: mechanism.text.encode(), **dict(mechanism.files)}
        folder = f"models/{body}"
        if any(self.files.get(f"{folder}/{file}", content) != content for file, content in contents.items()):
            folder = f"{folder}_{sha256(contents[name]).hexdigest()[:8]}"
        self.files.update({f"{folder}/{file}": content for file, content in contents.items()})
        return f"{folder}/{name}"

    def _add(self, name: str, content: Callable[[], str | bytes]) -> str:
        """Put a file beside the models, once, and return its name."""
        self.files.later(f"models/{name}", content)
        return name

    def _mesh(self, file: str) -> str:
        """Put the surface of a mesh file or sculpt beside the models, for contact and mass; return its name."""
        if file.startswith(DIGEST_PREFIX):
            return self._add(f"{file.removeprefix(DIGEST_PREFIX)[:12]}_whole.obj", lambda: sculpted_obj(file))
        mesh = load_mesh(file, self.folder)
        if mesh.flat:
            raise AssetError(f"mesh file `{file}` is flat: rigid bodies and links need thickness")
        stem = re.sub(r"\W+", "_", PurePosixPath(file).stem)
        digest = sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest()
        return self._add(f"{stem}_{digest[:12]}.obj", lambda: mesh.obj())
