"""The report: one page that shows everything, needs nothing, and trusts nobody."""

import json
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from text2sim.evidence import page as module
from text2sim.evidence.evidence import judge
from text2sim.evidence.plots import PlotLine, plot_series
from text2sim.evidence.report import write_report
from text2sim.recording.record import RunRecord

VOID = {"meta", "img", "br", "link", "input", "source"}


class Page(HTMLParser):
    """A page taken apart: its tags, its addresses, its words; complains about tags that do not match."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.words = ""
        self._open: list[str] = []
        self.feed(text)
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        if "style" not in self._open:
            self.words += data


@pytest.fixture
def fall(new_run):
    run = new_run()
    t = run.time
    floor = run.add_link("floor", fixed=True)
    z = np.abs(np.cos(6 * t))
    ball = run.add_link("ball", mass=2.0, pos=np.outer(z, [0, 0, 1]), vel=np.outer(np.gradient(z, t), [0, 0, 1]))
    run.touch(floor, ball, range(26, 28), (0, 0, 500.0), depth=0.003)
    return run


ACTIONS = {
    "measures": {"height": {"kind": "position", "of": "ball", "axis": "z"}},
    "events": {"landing": {"kind": "contact", "between": ["ball", "floor"]}},
    "expect": {
        "lands": {"event": "landing", "within": [0.2, 0.3]},
        "low": {"measure": "height", "during": [0.4, 1.0], "below": 0.5},
        "high": {"measure": "height", "at": 0.0, "equals": 1.0, "tolerance": 0.1},
    },
}


def add_film(folder, video: bytes = b"\0\0\0 ftypisom") -> None:
    (folder / "frames").mkdir()
    for k in range(5):
        Image.new("RGB", (640, 360), (40 * k, 80, 120)).save(folder / "frames" / f"main_{k}.png")
    (folder / "frames" / "main_5.png").write_bytes(b"cut off")
    Image.new("RGB", (64, 36)).save(folder / "first.png")
    (folder / "video.mp4").write_bytes(video)
    rows = [{"t": 0.25 * k, "shares": {"ball": 0.1}} for k in range(5)]
    (folder / "visibility.json").write_text(json.dumps({"main": rows}))


def show(folder, case) -> Page:
    judge(folder, case)
    path = write_report(folder, case)
    assert path == folder / "report.html"
    return Page(path.read_text("utf-8"))


def test_the_page_tells_the_whole_story_and_needs_no_other_file(fall, make_case):
    folder = fall.write()
    add_film(folder)
    (folder / "case.yaml").write_text("text2sim: 1\n# the case\n")
    notes = ["solver = newton: few enough bodies"]
    lint = [{"rule": "overlap", "path": "/bodies/ball", "message": "`ball` is in it", "reason": "a press fit"}]
    RunRecord(
        "case", "finished", {"sim_digest": "abc123"}, versions={"python": "3.11"}, notes=notes, lint=lint, wall=3.0
    ).write(folder)
    page = show(folder, make_case(**ACTIONS))
    for words in (
        "failed", "A ball falls.", "height below 0.5 m from 0.4 s to 1 s", "at worst",
        "first happened at 0.26 s", "solver = newton: few enough bodies", "# the case", "abc123", "3.11",
        "0.003 m", "landing", "10 %", "overlap", "a press fit",
    ):  # fmt: skip
        assert words in page.words, words
    addresses = [value for name, value in page.attributes if name in ("src", "href", "srcset", "action", "poster")]
    assert addresses
    assert all(address.startswith("data:") for address in addresses)
    assert "script" not in page.tags
    assert not [name for name, _ in page.attributes if name.startswith("on")]
    assert (folder / "contact_sheet.png").is_file()
    assert {path.name for path in (folder / "plots").iterdir()} == {"height.png", "all.energy.png"}


def test_plots_are_pictures_of_legible_size(fall, make_case):
    folder = fall.write()
    show(folder, make_case(**ACTIONS))
    with Image.open(folder / "plots" / "height.png") as picture:
        assert picture.width >= 800
        assert len(picture.convert("RGB").getcolors(1 << 20) or ()) > 20


def test_a_large_film_is_linked(fall, make_case, monkeypatch):
    monkeypatch.setattr(module, "MAX_EMBEDDED_SIZE", 100)
    folder = fall.write()
    add_film(folder, b"x" * 200)
    page = show(folder, make_case(**ACTIONS))
    assert ("href", "video.mp4") in page.attributes
    assert "video" not in page.tags


HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'`<i>`{{ 7*7 }}</pre></style>$x$"


def test_hostile_strings_stay_strings(fall, make_case):
    folder = fall.write(state="failed", message=HOSTILE)
    add_film(folder)
    (folder / "visibility.json").write_text(json.dumps({HOSTILE: [{"t": 0, "shares": {"ball": 0.1, HOSTILE: 0.2}}]}))
    (folder / "case.yaml").write_text(HOSTILE)
    (folder / "log.txt").write_text(HOSTILE + "\x1b[31m")
    (folder / 'video_" onerror="alert(3).mp4').write_bytes(b"x")
    RunRecord(
        "case", "failed", {HOSTILE: HOSTILE}, versions={HOSTILE: HOSTILE}, notes=[HOSTILE], message=HOSTILE,
        where={"line": 3, "code": HOSTILE},
    ).write(folder)  # fmt: skip
    case = make_case(**ACTIONS).model_copy(update={"prompt": HOSTILE})
    page = show(folder, case)
    assert page.words.count("<script>alert(1)</script>") >= 8
    assert "script" not in page.tags
    assert not [name for name, _ in page.attributes if name.startswith("on")]
    assert "{{ 7*7 }}" in page.words
    assert "i" not in page.tags


def test_the_policy_of_the_page_forbids_scripts(fall, make_case):
    page = show(fall.write(), make_case())
    policies = [value for name, value in page.attributes if name == "content" and "default-src" in value]
    assert policies
    assert "default-src 'none'" in policies[0]
    assert "script-src" not in policies[0]


def test_without_a_film_or_measures_there_is_a_page(fall, make_case):
    page = show(fall.write(), make_case())
    assert "There is none" in page.words
    assert "passed" in page.words


def test_without_frames_there_is_a_page(new_run, make_case):
    run = new_run()
    run.add_link("ball")
    folder = run.write(upto=0, state="failed", message="the engine refused")
    page = show(folder, make_case(**ACTIONS))
    assert "the engine refused" in page.words


def test_without_any_evidence_there_is_a_page(tmp_path, make_case):
    RunRecord("case", "failed", {}, message="no such morph").write(tmp_path)
    (tmp_path / "log.txt").write_text("Traceback: no such morph")
    page = Page(write_report(tmp_path, make_case(**ACTIONS)).read_text("utf-8"))
    assert "No such morph." in page.words
    assert "Traceback: no such morph" in page.words
    assert "case: failed" in page.words


def test_a_diverged_run_is_shown(fall, make_case):
    fall.columns[1]["links_pos"][50:] = np.nan
    fall.columns[1]["links_vel"][50:] = np.inf
    page = show(fall.write(state="diverged", message="diverged at t = 0.5 s"), make_case(**ACTIONS))
    assert "diverged at t = 0.5 s" in page.words
    assert "from 0.500 s on: ball" in " ".join(page.words.split())


def test_writing_it_again_gives_the_same_bytes(fall, make_case):
    folder, case = fall.write(), make_case(**ACTIONS)
    add_film(folder)
    show(folder, case)
    before = (folder / "report.html").read_bytes()
    show(folder, case)
    assert (folder / "report.html").read_bytes() == before


@pytest.mark.filterwarnings("error", "ignore::pytest.PytestUnraisableExceptionWarning")  # of earlier tests
def test_names_in_plots_are_neither_formulas_nor_printed(tmp_path: Path) -> None:
    """Those of run folders that are compared may be anybody's."""
    lines = [PlotLine(name, np.arange(3.0)) for name in ("$\\frac{$", "x\x1b[2K\rok", "\U0001f4a5")]
    plot_series(tmp_path / "z.png", np.arange(3.0), lines, title="$\\frac{ \x1b", unit="m")
    assert (tmp_path / "z.png").is_file()
