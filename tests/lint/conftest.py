"""Fixtures for the tests of the lint: mesh files, and a folder of a case with them."""

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh


@pytest.fixture(scope="session")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with meshes: a closed box, one without a side, one inside out, and a ring of very many triangles."""
    folder = tmp_path_factory.mktemp("meshes")
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    box.export(folder / "closed.obj")
    trimesh.Trimesh(box.vertices, box.faces[2:]).export(folder / "open.obj")
    trimesh.Trimesh(box.vertices, np.fliplr(box.faces), process=False).export(folder / "inverted.obj")
    trimesh.creation.torus(0.2, 0.05, major_sections=160, minor_sections=80).export(folder / "fine.obj")
    trimesh.creation.torus(0.2, 0.04).export(folder / "ring.obj")
    channel = trimesh.boolean.difference(
        [trimesh.creation.box((0.2, 0.2, 0.1)), trimesh.creation.box(bounds=[[-0.05, -0.2, 0], [0.05, 0.2, 0.2]])]
    )
    channel.export(folder / "channel.obj")
    return folder


@pytest.fixture
def assets(tmp_path: Path, meshes: Path) -> Path:
    """A case's folder, with the files that examples name."""
    for mesh in meshes.iterdir():
        os.link(mesh, tmp_path / mesh.name)
    return tmp_path
