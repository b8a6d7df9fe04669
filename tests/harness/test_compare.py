"""Runs side by side: what differed, what it did, and a page that trusts nobody."""

import json
from pathlib import Path

import numpy as np
import pytest

from text2sim.comparison.compare import compare
from text2sim.comparison.page import write_comparison
from text2sim.comparison.runs import read_runs
from text2sim.evidence.evidence import judge
from text2sim.recording.record import RunRecord
from text2sim.spec_schema.errors import RunError

ACTIONS = {
    "measures": {"height": {"kind": "position", "of": "ball", "axis": "z"}},
    "events": {"landing": {"kind": "contact", "between": ["ball", "floor"]}},
    "expect": {"low": {"measure": "height", "at": "end", "below": 0.5}},
}
HOSTILE = "<script>alert(1)</script>"


@pytest.fixture
def run_of(new_run, make_case, tmp_path):
    def make(name: str, end: float, **resolved) -> Path:
        run = new_run()
        floor = run.add_link("floor", fixed=True)
        z = np.linspace(1.0, end, len(run.time))
        ball = run.add_link("ball", mass=2.0, pos=np.outer(z, [0, 0, 1]), vel=np.zeros((len(z), 3)))
        run.touch(floor, ball, range(26, 28), (0, 0, 500.0), depth=0.003)
        written = run.write()
        judge(written, make_case(**ACTIONS))
        folder = tmp_path / "runs" / name
        folder.parent.mkdir(exist_ok=True)
        written.rename(folder)
        RunRecord(case="drop", state="finished", key={"device": "cpu"}, time=1.0).write(folder)
        (folder / "resolved.json").write_text(json.dumps({"text2sim": 1, "params": resolved, "scene": {"dt": 0.01}}))
        return folder

    return make


def test_what_differs_stands_side_by_side(run_of):
    found = compare(read_runs([run_of("drop-1", 0.2, mass=1.0), run_of("drop-2", 0.8, mass=2.5)])).as_dict()
    assert [row["label"] for row in found["runs"]] == ["mass 1", "mass 2.5"]
    assert [row["verdict"] for row in found["runs"]] == ["passed", "failed"]
    assert found["spec"] == [{"path": "params.mass", "values": [1.0, 2.5]}]
    (height,) = found["measures"]
    assert height["unit"] == "m"
    assert [cell["last"] for cell in height["cells"]] == pytest.approx([0.2, 0.8])
    assert [cell["ok"] for cell in found["expectations"][0]["cells"]] == [True, False]
    assert [cell["count"] for cell in found["events"][0]["cells"]] == [1, 1]


def test_what_only_one_run_has_leaves_a_gap(run_of):
    first, second = run_of("drop-1", 0.2, mass=1.0), run_of("drop-2", 0.2, speed=3.0)
    evidence = json.loads((second / "evidence.json").read_text())
    evidence["measures"]["extra"] = dict(evidence["measures"]["height"])
    (second / "evidence.json").write_text(json.dumps(evidence))
    found = compare(read_runs([first, second]))
    assert [row["path"] for row in found.spec] == ["params.mass", "params.speed"]
    assert [row["values"] for row in found.spec] == [[1.0, None], [None, 3.0]]
    assert next(row for row in found.measures if row["name"] == "extra")["cells"][0] is None


def test_the_page_runs_no_script_but_its_own(run_of, tmp_path):
    runs = read_runs([run_of("drop-1", 0.2, note=HOSTILE), run_of("drop-2", 0.8, note="plain")])
    page = write_comparison(compare(runs), tmp_path / "page.html").read_text()
    assert HOSTILE not in page
    assert page.count("<script") == 0  # no film, no player
    assert "script-src 'sha256-" in page
    assert "data:image/png" in page
    assert page == write_comparison(compare(runs), tmp_path / "page.html").read_text()


def test_a_run_of_one_frame_beside_a_whole_one(run_of, tmp_path):
    folders = [run_of("drop-1", 0.2), run_of("drop-2", 0.8)]
    (folders[0] / "measures.csv").write_text("time,height\n0,1\n")
    page = write_comparison(compare(read_runs(folders)), tmp_path / "page.html").read_text()
    assert "data:image/png" in page


def test_films_are_played_together(run_of, tmp_path):
    folders = [run_of("drop-1", 0.2, mass=1.0), run_of("drop-2", 0.8, mass=2.0)]
    for folder in folders:
        (folder / "video.mp4").write_bytes(b"film")
    page = write_comparison(compare(read_runs(folders)), tmp_path / "page.html").read_text()
    assert page.count("<video") == 2
    assert page.count("<script") == 1


def test_a_sweep_stands_for_its_runs(run_of):
    first, second = run_of("drop-1", 0.2, mass=1.0), run_of("drop-2", 0.8, mass=2.0)
    sweep = first.parent / "drop-sweep"
    sweep.mkdir()
    rows = [{"label": "light", "folder": first.name}, {"label": "heavy", "folder": second.name}]
    rows.append({"label": "out", "folder": "../../etc"})
    (sweep / "sweep.json").write_text(json.dumps({"runs": rows}))
    assert [run.label for run in read_runs([sweep])] == ["light", "heavy"]
    (sweep / "sweep.json").write_text('{"runs": 3}')
    with pytest.raises(RunError, match="two runs or more"):
        read_runs([sweep, sweep])


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda folder: (folder / "run.json").unlink(), "not the folder of a run"),
        (lambda folder: (folder / "evidence.json").write_text("{"), "before there was anything to compare"),
        (lambda folder: (folder / "evidence.json").unlink(), "before there was anything to compare"),
    ],
)
def test_what_is_no_run_is_said(run_of, spoil, message):
    first, second = run_of("drop-1", 0.2), run_of("drop-2", 0.8)
    spoil(second)
    with pytest.raises(RunError, match=message):
        read_runs([first, second])


def test_one_run_is_not_enough(run_of):
    with pytest.raises(RunError, match="two runs"):
        read_runs([run_of("drop-1", 0.2)])
