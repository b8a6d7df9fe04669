"""Runs that nobody simulated: a few meshes, some frames, a film section."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from filmed import BOX, BOX_FACES, FILM, MakeRun

from text2sim.rendering import renderer
from text2sim.rendering.renderer import Variant


@pytest.fixture(autouse=True, scope="session")
def scalar() -> Iterator[None]:
    """Pictures of some hundred pixels are done before the kernels of another variant would be compiled."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(renderer, "find_variant", lambda: Variant("scalar"))
        yield


@pytest.fixture
def make_run(tmp_path: Path) -> MakeRun:
    """Write a run of boxes: name -> half sizes, way over the film, look; `of` names the body that it is a link of."""

    def make(boxes: dict[str, dict[str, Any]], name: str = "run", **film: Any) -> Path:
        folder = tmp_path / name
        for part in ("states", "geometry", "program"):
            (folder / part).mkdir(parents=True, exist_ok=True)
        times = np.linspace(0, 0.4, 5)
        index, links = {}, []
        for k, (body, what) in enumerate(boxes.items()):
            mesh = f"{body}.npz"
            np.savez(folder / "geometry" / mesh, vertices=BOX * what["half"], faces=BOX_FACES)
            color = [*what.get("color", (0.5, 0.5, 0.5)), 1.0]
            index[str(k)] = [{"mesh": mesh, "pos": [0, 0, 0], "quat": [1, 0, 0, 0], "color": color}]
            links.append({"body": what.get("of", body), "link": body, "mass": 1.0, "fixed": "velocity" not in what})
        layout = {"dt": 0.1, "every": 1, "gravity": [0, 0, -9.81], "links": links, "joints": []}
        start = np.array([what["pos"] for what in boxes.values()], float)
        speed = np.array([what.get("velocity", (0, 0, 0)) for what in boxes.values()], float)
        spans = np.array([what.get("during", (0.0, 0.4)) for what in boxes.values()], float)
        moved = np.clip(times[:, None], *spans.T) - spans[:, 0]
        pos = (start + speed * moved[..., None]).astype(np.float32)
        half = times[:, None] * [what.get("spin", 0.0) / 2 for what in boxes.values()]  # about y [rad/s]
        quat = np.stack([np.cos(half), 0 * half, np.sin(half), 0 * half], axis=2).astype(np.float32)
        np.savez(
            folder / "states" / "chunk_00000.npz",
            time=times, qpos=np.zeros((5, 0), np.float32), links_pos=pos, links_quat=quat,
        )  # fmt: skip
        looks = {
            what.get("of", body): {"color": what.get("color", (0.5, 0.5, 0.5)), "opacity": what.get("opacity", 1.0),
                   "finish": what.get("finish", "rough"), "visible": True, "picture": None}
            for body, what in boxes.items()
        }  # fmt: skip
        (folder / "states" / "layout.json").write_text(json.dumps(layout))
        (folder / "geometry" / "index.json").write_text(json.dumps(index))
        (folder / "program" / "looks.json").write_text(json.dumps(looks))
        rows = [f"{key.upper()} = {value!r}\n" for key, value in (FILM | film).items()]
        (folder / "program" / "render.py").write_text("".join(rows))
        return folder

    return make
