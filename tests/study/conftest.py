"""Methods with films of one colour each, and studies of them."""

from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
import pytest

from text2sim.evaluation.method_folder import (
    CaseResult,
    MethodFolder,
    MethodRecord,
    read_method,
    write_method,
    write_result,
)
from text2sim.study.build import Study, build

COLOURS = {"anchor_system": (200, 40, 40), "better_system": (40, 200, 40), "worse_system": (40, 40, 200)}


def film(path: Path, colour: tuple[int, int, int], title: str = "") -> None:
    """Write a film of one second with a tag that tells whose it is."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as made:
        made.metadata["title"] = title
        stream = made.add_stream("mpeg4", rate=10)
        stream.width, stream.height = 64, 48
        for k in range(10):
            picture = np.full((48, 64, 3), colour, np.uint8)
            picture[:, 6 * k : 6 * k + 6] = 255
            made.mux(stream.encode(av.VideoFrame.from_ndarray(picture)))
        made.mux(stream.encode())


@pytest.fixture(scope="session")
def methods(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], list[MethodFolder]]:
    """Return a function that makes methods with films of so many tasks; the first is the anchor."""

    def make(tasks: int) -> list[MethodFolder]:
        root = tmp_path_factory.mktemp("methods")
        for name, colour in COLOURS.items():
            write_method(root / name, MethodRecord(name=name, suite="test"))
            for k in range(tasks):
                folder = root / name / f"task_{k}"
                film(folder / "film.mp4", colour, f"made by {name}")
                write_result(folder, CaseResult(prompt=f"task_{k}", status="finished", film="film.mp4"))
        return [read_method(root / name) for name in COLOURS]

    return make


@pytest.fixture
def study(tmp_path: Path, methods: Callable[[int], list[MethodFolder]]) -> tuple[Path, Study]:
    """A study of two methods and an anchor with four tasks."""
    anchor, *others = methods(4)
    prompts = {f"task_{k}": f"Ball {k} <b>falls</b> & bounces." for k in range(4)}
    return tmp_path / "study", build(tmp_path / "study", prompts, anchor, others, seed=3)
