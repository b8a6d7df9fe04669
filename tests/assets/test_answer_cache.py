"""The cache of answers about model files: hits, misses, damaged entries."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from text2sim.assets import answer_cache as memory
from text2sim.assets.answer_cache import cached_answer
from text2sim.assets.inspection import inspect_model
from text2sim.assets.mechanism import load_mechanism

ANSWER = {"bodies": [1, {"name": "a"}], "motors": 2}


class Asked:
    """Counts how often it is asked."""

    def __init__(self, answer: object = ANSWER) -> None:
        self.answer, self.times = answer, 0

    def __call__(self) -> dict:
        self.times += 1
        if isinstance(self.answer, Exception):
            raise self.answer
        return dict(self.answer)  # type: ignore[call-overload]


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "text2sim" / "models"


def test_an_answer_is_computed_once(cache: Path) -> None:
    ask = Asked()
    assert cached_answer([b"a", b"b"], ask) == cached_answer([b"a", b"b"], ask) == ANSWER
    assert ask.times == 1
    assert [path.suffix for path in cache.iterdir()] == [".answer"]


def test_any_other_content_is_another_question(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ask = Asked()
    for question in ([b"ab"], [b"a", b"b"], [b"", b"ab"], [b"b", b"a"]):
        cached_answer(question, ask)
    assert ask.times == 4
    monkeypatch.setattr(memory, "_version", lambda name: "99")
    cached_answer([b"ab"], ask)
    assert ask.times == 5, "another version of MuJoCo may say something else"
    monkeypatch.setattr(memory, "_source_of", lambda module: b"changed")
    cached_answer([b"ab"], ask)
    assert ask.times == 6, "and so may other code of ours"


@pytest.mark.parametrize("damage", [
    lambda text: "", lambda text: text[:-1], lambda text: text.replace("2", "3"), lambda text: text.partition("\n")[2],
    lambda text: "\0", lambda text: "[" * 100_000,
])  # fmt: skip
def test_a_damaged_answer_is_computed_again(cache: Path, damage: Callable[[str], str]) -> None:
    ask = Asked()
    cached_answer([b"a"], ask)
    (path,) = cache.iterdir()
    right = path.read_text()
    path.write_text(damage(right))
    assert cached_answer([b"a"], ask) == ANSWER
    assert ask.times == 2
    assert path.read_text() == right, "the right one is kept instead"


def test_faults_are_not_kept(cache: Path) -> None:
    with pytest.raises(KeyError):
        cached_answer([b"a"], Asked(KeyError("no")))
    assert not cache.exists()


def test_nothing_is_needed_to_write_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert cached_answer([b"a"], Asked()) == ANSWER


def test_the_oldest_go(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "MAX_ANSWERS", 3)
    for number in range(6):
        cached_answer([b"%d" % number], Asked())
    assert len(list(cache.iterdir())) == 3


def test_arrays_and_bytes_are_the_same_from_the_cache(cache: Path) -> None:
    faces, points = np.array([[0, 1, 2]], np.int32), np.array([[0.1, np.inf], [1 / 3, -0.0]])
    ask = Asked({"net": (points, faces), "none": np.zeros((0, 2)), "picture": b"\x89\0"})
    for _ in range(2):
        found = cached_answer([b"a"], ask)
        (again, sides), none = found["net"], found["none"]
        assert again.tobytes() == points.tobytes() and (again.shape, again.dtype) == ((2, 2), np.float64)
        assert sides.tolist() == [[0, 1, 2]] and sides.dtype == np.int64
        assert (none.shape, none.dtype, found["picture"]) == ((0, 2), np.float64, b"\x89\0")
    assert ask.times == 1


@pytest.mark.parametrize("name", ["j", "base64"])
def test_a_model_comes_out_the_same(name: str, cache: Path, tmp_path: Path) -> None:
    link = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    joint = (
        '<parent link="a"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="9"/>'
    )
    (tmp_path / "arm.urdf").write_text(
        f'<robot name="r"><link name="a"/><link name="b">{link}</link><joint name="{name}" type="revolute">{joint}</joint></robot>'
    )
    first = load_mechanism(tmp_path, "arm.urdf")
    assert len(list(cache.iterdir())) == 2, "what MuJoCo says, and what the reader of URDF says"
    inspect_model.cache_clear()
    assert load_mechanism(tmp_path, "arm.urdf") == first
    assert first.joints[0].limit == 9
