"""The cache of answers about model files: hits, misses, damaged entries."""

import json
from pathlib import Path

import numpy as np
import pytest

from text2sim.assets import answer_cache as memory
from text2sim.assets.answer_cache import cached_answer, cached_net, packed
from text2sim.assets.inspection import inspect_model
from text2sim.assets.mechanism import load_mechanism

MEMBERS = {"bodies": list, "motors": int}
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
    assert cached_answer([b"a", b"b"], MEMBERS, ask) == cached_answer([b"a", b"b"], MEMBERS, ask) == ANSWER
    assert ask.times == 1
    assert [path.suffix for path in cache.iterdir()] == [".json"]


def test_any_other_content_is_another_question(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ask = Asked()
    for question in ([b"ab"], [b"a", b"b"], [b"", b"ab"], [b"b", b"a"]):
        cached_answer(question, MEMBERS, ask)
    assert ask.times == 4
    monkeypatch.setattr(memory, "_version", lambda name: "99")
    cached_answer([b"ab"], MEMBERS, ask)
    assert ask.times == 5, "another version of MuJoCo may say something else"
    monkeypatch.setattr(memory, "_source_of", lambda module: b"changed")
    cached_answer([b"ab"], MEMBERS, ask)
    assert ask.times == 6, "and so may other code of ours"


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "[" * 100_000, "null", '{"bodies": []}', '{"bodies": 1, "motors": 1}', "\x00"]
)
def test_odd_answers_are_not_believed(cache: Path, text: str) -> None:
    ask = Asked()
    cached_answer([b"a"], MEMBERS, ask)
    (path,) = cache.iterdir()
    path.write_text(text)
    assert cached_answer([b"a"], MEMBERS, ask) == ANSWER
    assert ask.times == 2
    assert json.loads(path.read_text()) == ANSWER, "the right one is kept instead"


def test_faults_and_refusals_are_not_kept(cache: Path) -> None:
    with pytest.raises(KeyError):
        cached_answer([b"a"], MEMBERS, Asked(KeyError("no")))
    assert cached_answer([b"a"], MEMBERS, Asked({"error": "is refused"})) == {"error": "is refused"}
    assert not cache.exists()


def test_nothing_is_needed_to_write_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert cached_answer([b"a"], MEMBERS, Asked()) == ANSWER


def test_the_oldest_go(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "MAX_ANSWERS", 3)
    for number in range(6):
        cached_answer([b"%d" % number], MEMBERS, Asked())
    assert len(list(cache.iterdir())) == 3


def test_a_net_is_made_once_and_again_when_it_is_damaged(cache: Path) -> None:
    made: list[int] = []

    def make() -> tuple[np.ndarray, np.ndarray]:
        made.append(1)
        return np.eye(3), np.array([[0, 1, 2]])

    for number in range(3):
        vertices, faces = cached_net([b"net"], make)
        assert vertices.tolist() == np.eye(3).tolist() and faces.tolist() == [[0, 1, 2]]
        assert len(made) == max(number, 1)
        if number == 1:  # a triangle with a corner that is not there
            (path,) = cache.iterdir()
            path.write_text(json.dumps(json.loads(path.read_text()) | {"faces": packed(np.array([[0, 1, 3]]))}))


def test_a_model_comes_out_the_same(cache: Path, tmp_path: Path) -> None:
    link = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    joint = (
        '<parent link="a"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="9"/>'
    )
    (tmp_path / "arm.urdf").write_text(
        f'<robot name="r"><link name="a"/><link name="b">{link}</link><joint name="j" type="revolute">{joint}</joint></robot>'
    )
    first = load_mechanism(tmp_path, "arm.urdf")
    assert len(list(cache.iterdir())) == 2, "what MuJoCo says, and what the reader of URDF says"
    inspect_model.cache_clear()
    assert load_mechanism(tmp_path, "arm.urdf") == first
    assert first.joints[0].limit == 9
