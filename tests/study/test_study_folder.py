"""The folder of a study, and its anonymous films."""

import json
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
import pytest
from study.conftest import COLOURS

from text2sim.evaluation.method_folder import MethodFolder, read_method
from text2sim.spec_schema.errors import RunError, SpecError
from text2sim.study.build import Study, build, read_study


def test_only_the_pictures_of_films_differ(study: tuple[Path, Study]) -> None:
    folder, made = study
    assert read_study(folder) == made
    for methods in made.films.values():
        for name, number in methods.items():
            file = folder / "films" / f"{number}.mp4"
            assert not any(word in file.read_bytes() for word in (b"made by", name.encode(), b"Lavf"))
            assert file.stat().st_mtime == 0
            with av.open(str(file)) as film:
                pictures = list(film.decode(video=0))
                assert film.streams.video[0].codec_context.name == "h264"
            frames = [picture.to_ndarray(format="rgb24") for picture in pictures]
            assert [picture.time for picture in pictures] == pytest.approx([0.1 * k for k in range(10)])
            assert np.abs(frames[0][30, 50].astype(int) - COLOURS[name]).max() < 12, "it is the film of this method"


def test_numbers_of_films_follow_no_order(study: tuple[Path, Study]) -> None:
    _, made = study
    rows = [list(methods.values()) for methods in made.films.values()]
    assert sorted(sum(rows, [])) == list(range(12))
    assert len({tuple(np.argsort(row)) for row in rows}) > 1, "no method always comes first"


def test_unreadable_films_are_reported_and_not_dropped(
    tmp_path: Path, methods: Callable[[int], list[MethodFolder]]
) -> None:
    anchor, better, worse = methods(3)
    (worse.folder / "task_1" / "film.mp4").write_bytes(b"no film")
    (anchor.folder / "task_2" / "film.mp4").unlink()
    everyone = [read_method(one.folder) for one in (anchor, better, worse)]
    made = build(tmp_path / "s", {f"task_{k}": "A ball falls." for k in range(4)}, everyone[0], everyone[1:])
    pairs = {(trial.task, trial.method) for trials in made.assignments for trial in trials}
    assert pairs == {("task_0", "better_system"), ("task_0", "worse_system"), ("task_1", "better_system")}
    assert [row.split(":")[0] for row in made.left_out] == [
        "task_1, worse_system", "task_2, anchor_system", *(f"task_3, {name}" for name in COLOURS),
    ]  # fmt: skip
    with pytest.raises(RunError, match="already contains a study"):
        build(tmp_path / "s", {}, everyone[0], everyone[1:])


def test_nothing_to_compare_is_an_error(tmp_path: Path, methods: Callable[[int], list[MethodFolder]]) -> None:
    anchor, better, _ = methods(1)
    with pytest.raises(RunError, match="no task has films"):
        build(tmp_path / "s", {"other": "A ball falls."}, anchor, [better])
    with pytest.raises(RunError, match="the same name"):
        build(tmp_path / "t", {"task_0": "A ball falls."}, anchor, [anchor])


def test_problems_of_a_study_are_located(study: tuple[Path, Study]) -> None:
    folder, made = study
    data = json.loads((folder / "study.json").read_text())
    (folder / "study.json").write_text(json.dumps(data | {"sead": 1}, indent=1))
    with pytest.raises(SpecError) as caught:
        read_study(folder)
    assert "sead" in str(caught.value)
    assert made.seed == 3
