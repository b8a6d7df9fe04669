"""The page of the replay: its contents, and escaping of untrusted text."""

import base64
import json
import re
import shutil
import zlib
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exchange.recorded import FRAMES, write_run

from text2sim.cli.main import app
from text2sim.compiler.build import plan_case
from text2sim.evidence.report import write_report
from text2sim.exchange.scenery import Scenery
from text2sim.replay import motion, page
from text2sim.replay.motion import evenly_spaced, pack_contacts, pack_figures, pack_links
from text2sim.replay.packing import Blob
from text2sim.replay.page import write_replay
from text2sim.replay.pictures import Pictures
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.models.case import Case

NUMPY = {"Float32Array": np.float32, "Uint32Array": np.uint32, "Uint16Array": np.uint16, "Int16Array": np.int16,
         "Int8Array": np.int8}  # fmt: skip


class Opened:
    """The page as its own script reads it."""

    def __init__(self, path: Path) -> None:
        self.text = path.read_text("utf-8")
        self.contents = json.loads(self._element("contents"))
        self.blob = zlib.decompress(base64.b64decode(self._element("blob")))

    def _element(self, name: str) -> str:
        found = re.findall(rf'<script id="{name}" type="[^"]*">(.*?)</script>', self.text, re.S)
        assert len(found) == 1
        return found[0]

    def array(self, row: dict[str, Any]) -> np.ndarray:
        kind = NUMPY[row["type"]]
        return np.frombuffer(self.blob, kind, row["count"], row["at"])

    def points(self, row: dict[str, Any], *shape: int) -> np.ndarray:
        low, step = (np.array(row[name]).reshape(-1, 3) for name in ("low", "step"))
        return low + step * self.array(row).reshape(*shape, 3)


@pytest.fixture
def opened(judged: Path, case: Case) -> Opened:
    return Opened(write_replay(judged, case))


def recorded(folder: Path) -> dict[str, np.ndarray]:
    with np.load(folder / "states" / "chunk_00000.npz") as chunk:
        return dict(chunk)


def test_links_are_where_they_were_recorded(opened: Opened, judged: Path) -> None:
    links, states = opened.contents["links"], recorded(judged)
    np.testing.assert_allclose(opened.array(links["times"]), states["time"], atol=1e-6)
    tracks = {piece["body"]: piece.get("track") for piece in opened.contents["pieces"]}
    assert tracks["box[1]"] is None, "what lies still has one pose"
    pos = opened.points(links["pos"], FRAMES, links["count"])
    np.testing.assert_allclose(pos[:, tracks["box[0]"]], states["links_pos"][:, 1], atol=1e-5)
    quat = opened.array(links["quat"]).reshape(FRAMES, links["count"], 4)[:, tracks["box[0]"]] / 32767
    same = np.abs((quat * states["links_quat"][:, 1]).sum(axis=1))
    np.testing.assert_allclose(same, 1, atol=1e-4)
    still = next(piece for piece in opened.contents["pieces"] if piece["body"] == "box[1]")
    np.testing.assert_allclose(still["base"]["pos"], (0.5, 0, 0.1), atol=1e-6)


def test_deformable_bodies_are_at_their_recorded_positions(opened: Opened, judged: Path) -> None:
    sheet, sand = opened.contents["figures"]
    states = recorded(judged)
    points = opened.points(sheet["points"], FRAMES, sheet["count"])
    np.testing.assert_allclose(points, states["soft_points"][:, :16], atol=2e-5)
    points = opened.points(sand["points"], FRAMES, 7)
    np.testing.assert_allclose(points, states["soft_points"][:, 16:], atol=2e-5)
    assert sand["radius"] == pytest.approx(0.01)
    assert opened.contents["pictures"][sheet["picture"]].startswith("data:image/png;base64,")


def test_contacts_belong_to_the_frames_in_which_they_were(opened: Opened) -> None:
    contacts = opened.contents["contacts"]
    assert opened.array(contacts["starts"]).tolist() == [0, 0, 0, 2, 2, 3, 3]
    assert opened.array(contacts["force"]).tolist() == [9, 20, 1]
    pairs = [[contacts["names"][k] for k in pair] for pair in opened.array(contacts["pairs"]).reshape(-1, 2)]
    assert pairs == [["floor", "box[0]"], ["floor", "box[1]"], ["box[0]", "box[1]"]]


def test_findings_are_those_of_the_evidence(opened: Opened) -> None:
    found = opened.contents
    height = found["measures"][0]
    assert (height["name"], height["unit"]) == ("height", "m")
    assert np.isnan(opened.array(height["values"])[3]), "a gap stays one"
    assert [(b["name"], b["high"], b["ok"]) for b in height["bounds"]] == [("falls", 0.99, False)]
    assert [row["time"] for row in found["events"]] == [0.04, 0.08], "only declared ones, in order"
    assert [(row["name"], row["ok"]) for row in found["expect"]] == [("lands", True), ("falls", False)]
    assert [row["name"] for row in found["cameras"]] == ["main", "round"]
    assert opened.array(found["cameras"][1]["up"]).reshape(-1, 3).tolist() == [[0, 0, 1]] * 2
    assert found["notes"] == []


def test_page_asks_nothing_of_anybody(opened: Opened) -> None:
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', opened.text)
    assert policy is not None
    scripts = re.findall(r"<script>(.*?)</script>", opened.text, re.S)
    allowed = [base64.b64encode(sha256(script.encode()).digest()).decode() for script in scripts]
    assert len(allowed) == 2
    assert policy[1].startswith("default-src 'none'; img-src data:;")
    assert f"script-src 'sha256-{allowed[0]}' 'sha256-{allowed[1]}';" in policy[1]
    assert not re.search(r"(?:src|href)=\"(?!data:|report\.html)", opened.text)


def test_names_of_a_case_stay_text(opened: Opened) -> None:
    assert "<img" not in opened.text
    assert opened.text.count("</script>") == 4
    assert any("<img src=x" in row["body"] for row in opened.contents["figures"]), "and are kept as they are"


def test_numbers_that_are_none_do_not_break_the_page(judged: Path, case: Case) -> None:
    chunk = judged / "states" / "chunk_00000.npz"
    states = recorded(judged)
    states["contact_pos"][0] = np.nan
    states["soft_points"][-1, 0] = np.inf
    states["soft_surface"][-1, 0] = np.inf
    states["links_pos"][4:, 1] = np.nan
    np.savez(chunk, **states)
    opened = Opened(write_replay(judged, case))
    assert opened.contents["links"]["times"]["count"] == 4, "up to where it diverged"


def test_without_a_judgement_it_still_shows_the_run(tmp_path: Path, case: Case) -> None:
    opened = Opened(write_replay(write_run(tmp_path / "run"), case))
    assert (opened.contents["measures"], opened.contents["events"], opened.contents["expect"]) == ([], [], [])
    assert "incomplete" in opened.text


def test_long_runs_are_thinned_with_a_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenery = Scenery(write_run(tmp_path / "run", frames=200), detailed=False)
    monkeypatch.setattr(motion, "MAX_RIGID_SIZE", 14 * 2 * 50)
    monkeypatch.setattr(motion, "MAX_SOFT_SIZE", 6 * 23 * 60)
    blob, notes = Blob(), list[str]()
    _, _, taken = pack_links(scenery, blob, notes)
    assert len(taken) <= 50
    assert (taken[0], taken[-1]) == (0, 199)
    figures = pack_figures(scenery, blob, Pictures(notes), notes)
    assert all(figure["frames"] <= 60 for figure in figures)
    assert notes == ["rigid bodies are shown in 41 of 200 recorded frames",
                     "deformable bodies are shown in 51 of 200 recorded frames"]  # fmt: skip
    contacts = pack_contacts(tmp_path / "run", scenery, taken, blob, notes)
    assert contacts is not None
    assert contacts["force"]["count"] == 3, "none is lost between two frames"


def test_too_many_particles_are_sampled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenery = Scenery(write_run(tmp_path / "run", cloth=False), detailed=False)
    monkeypatch.setattr(motion, "MAX_SOFT_SIZE", 6 * FRAMES * 4)
    notes = list[str]()
    (sand,) = pack_figures(scenery, Blob(), Pictures(notes), notes)
    assert sand["count"] == 4
    assert sand["radius"] == pytest.approx(0.01 * 2 ** (1 / 3)), "as much volume as before"
    assert notes == ["one of 2 particles is shown, enlarged"]


def test_a_surface_that_finds_no_room_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenery = Scenery(write_run(tmp_path / "run", grains=False), detailed=False)
    monkeypatch.setattr(motion, "MAX_SOFT_SIZE", 100)
    notes = list[str]()
    assert pack_figures(scenery, Blob(), Pictures(notes), notes) == []
    assert notes == ["sheet is left out: its surface has 16 points"]


@pytest.mark.parametrize(("count", "most"), [(1, 10), (2, 2), (100, 10), (100, 100), (601, 300)])
def test_frames_that_are_taken(count: int, most: int) -> None:
    taken = evenly_spaced(count, most)
    assert len(taken) <= max(most, 3)
    assert (taken[0], taken[-1]) == (0, count - 1)


def test_command(judged: Path, tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from replay.conftest import CASE

    done = CliRunner().invoke(app, ["replay", str(judged)])
    assert isinstance(done.exception, RunError), "it needs the case"
    (judged / "expanded.yaml").write_text(CASE)
    done = CliRunner().invoke(app, ["replay", str(judged), "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["bytes"] == (judged / page.NAME).stat().st_size


def test_the_command_finds_the_run_of_a_case(judged: Path, tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from replay.conftest import CASE

    (case := tmp_path / "a_case").mkdir()
    (case / "case.yaml").write_text(CASE)
    command = ["replay", str(case), "--runs", str(runs := tmp_path / "runs")]
    done = CliRunner().invoke(app, command)
    assert "has no current run" in str(done.exception)
    loaded = load_case(case)
    folder = runs / f"{loaded.case.name}-{plan_case(loaded).sim_digest[:10]}"
    shutil.copytree(judged, folder)
    (folder / "expanded.yaml").write_text(CASE)
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    assert (folder / page.NAME).is_file()


@pytest.mark.parametrize(
    "text", ["[1]", "{", "3", '{"verdict": {"a": 1}, "expect": [1]}', '{"measures": [], "expect": {"lands": 3}}']
)
def test_evidence_of_a_stranger_is_none(judged: Path, case: Case, text: str):
    (judged / "evidence.json").write_text(text)
    assert write_replay(judged, case).is_file()
    assert write_report(judged, case).is_file()
