"""Mesh files of a case: read once for shape and looks, then remembered by content."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from text2sim.compiler.shapes import casemesh
from text2sim.compiler.shapes.casemesh import load_mesh, load_paint
from text2sim.spec_schema.errors import AssetError

TETRAHEDRON = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


@pytest.fixture
def reads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the files that were read, in a user's cache of its own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    found: list[str] = []
    confined = casemesh.call_confined
    monkeypatch.setattr(
        casemesh, "call_confined", lambda do, path, *more: (found.append(path.name), confined(do, path, *more))[1]
    )
    forget()
    return found


def forget() -> None:
    for memory in (casemesh._read_mesh_and_paint, casemesh._mesh, casemesh._paint):
        memory.cache_clear()


def test_a_file_is_read_once_for_both_and_not_again(tmp_path: Path, reads: list[str]) -> None:
    (tmp_path / "it.obj").write_text(TETRAHEDRON)
    mesh, paint = load_mesh("it.obj", tmp_path), load_paint("it.obj", tmp_path)
    assert reads == ["it.obj"]
    forget()
    again, painted = load_mesh("it.obj", tmp_path), load_paint("it.obj", tmp_path)
    assert reads == ["it.obj"]
    for name in ("vertices", "faces", "hull_vertices", "hull_faces", "volume", "closed", "flat"):
        assert np.array_equal(getattr(mesh, name), getattr(again, name)), name
    for one, other in zip(paint, painted, strict=True):
        for name in ("vertices", "faces", "normals"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
        assert (one.uvs, one.picture, one.rgba) == (other.uvs, other.picture, other.rgba)


def test_looks_that_need_another_file_are_read_again(tmp_path: Path, reads: list[str]) -> None:
    (tmp_path / "it.obj").write_text("mtllib it.mtl\nusemtl a\n" + TETRAHEDRON)
    for red in (1.0, 0.0):
        (tmp_path / "it.mtl").write_text(f"newmtl a\nKd {red} 0 0\n")
        forget()
        assert load_paint("it.obj", tmp_path)[0].rgba == (red, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("load", [load_mesh, load_paint])
def test_a_message_names_the_file_once(load: Any, tmp_path: Path) -> None:
    with pytest.raises(AssetError) as caught:
        load("gone.obj", tmp_path)
    assert str(caught.value) == "mesh file `gone.obj` does not exist in the case's folder"
