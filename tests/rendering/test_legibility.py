"""How well things are seen: shares and hidden parts as geometry has them, and what is said of them."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from filmed import MakeRun

from text2sim.compiler.build import resolve_case
from text2sim.drawing.view import perspective
from text2sim.evidence.events import EventLog
from text2sim.evidence.visibility import summarise_legibility
from text2sim.legibility.film import Watcher, _middles
from text2sim.legibility.layout import at_start
from text2sim.legibility.recorded import coarsened
from text2sim.legibility.sight import SPECK_PIXELS, Sight, Things, contrast, look
from text2sim.legibility.summary import Moment, largest_shares, least_inside, summarise
from text2sim.recording.film_record import read_recording
from text2sim.spec_schema.load import load_text

FRONT = perspective((0, -4, 0), (0, 0, 0), (0, 0, 1), 40.0, (160, 90))
STILL = {"velocity": (0, 0, 0)}


def sheet(x: tuple[float, float], y: float, z: tuple[float, float] = (-0.5, 0.5)) -> Any:
    """Two triangles that face the camera."""
    a, b, c, d = ((x[i], y, z[j]) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return np.array([(a, b, c), (a, c, d)], float)


def seen(*sheets: Any, clear: tuple[int, ...] = ()) -> Sight:
    owner = np.repeat(np.arange(len(sheets)), [len(one) for one in sheets])
    solid = ~np.isin(owner, clear)
    return look(Things(np.concatenate(sheets), owner, solid, len(sheets)), FRONT)


def test_one_sees_into_what_has_a_front_of_glass() -> None:
    """Back and front are of one thing, a drum; what is in it stands between them."""
    back, inside, front = sheet((-0.6, 0.6), 1.0), sheet((-0.2, 0.2), 0.0), sheet((-0.5, 0.5), -1.0)
    triangles, owner = np.concatenate([back, inside, front]), np.array([0, 0, 1, 1, 0, 0])
    through = look(Things(triangles, owner, np.array([1, 1, 1, 1, 0, 0], bool), 2), FRONT)
    before = look(Things(triangles, owner, np.ones(6, bool), 2), FRONT)
    assert through.hidden[1] == 0
    assert before.hidden[1] == 1
    assert through.seen[0] == before.seen[0], "glass is seen too"


def test_what_hides_is_told_from_what_is_beside_the_picture() -> None:
    sight = seen(sheet((-0.4, 0.4), 0.0), sheet((-0.2, 0.9), -1.0), sheet((8, 9), 0.0), sheet((-0.4, 0.4), -9.0))
    # From 4 m, the near sheet begins at -0.2 * 4 / 3 m of the far one.
    assert sight.hidden[0] == pytest.approx((0.4 + 0.2 * 4 / 3) / 0.8, abs=0.03)
    assert sight.hidden[1] == 0
    assert [(who, round(part, 1)) for who, part in sight.hiders(0)] == [(1, 0.8)]
    assert sight.inside.tolist() == [1, 1, 0, 0]
    assert (sight.seen[2:] == 0).all()
    focal = 45 / np.tan(np.radians(20))
    assert sight.measures()[1].share == pytest.approx(1.1 * (focal / 3) ** 2 / (160 * 90), rel=0.03)


def test_glass_is_seen_and_hides_nothing() -> None:
    sight = seen(sheet((-0.4, 0.4), 0.0), sheet((-0.4, 0.4), -1.0), clear=(1,))
    assert sight.hidden.tolist() == [0, 0]
    assert sight.seen[1] > sight.seen[0] > 100


def test_a_speck_counts_a_quarter_of_a_pixel_unless_it_is_hidden() -> None:
    speck = sheet((0.021, 0.022), 0.0, (0.011, 0.012))
    assert seen(speck).seen.tolist() == [SPECK_PIXELS]
    assert seen(speck, sheet((-0.5, 0.5), -1.0)).seen[0] == 0
    assert seen(speck).measures()[0].hidden is None, "too small to tell"


def test_edge_and_contrast() -> None:
    sight = seen(sheet((-0.2, 0.2), 0.0, (-0.2, 0.2)))
    focal = 45 / np.tan(np.radians(20))
    picture = np.where(sight.mask(0)[..., None], (1.0, 0.5, 0.0), (0.0, 0.5, 0.0))
    (measures,) = sight.measures(picture)
    assert measures.edge == pytest.approx((45 - 0.2 * focal / 4) / 90, abs=0.02)
    assert measures.contrast == pytest.approx(1 / np.sqrt(3))
    assert contrast(picture, np.ones((90, 160), bool)) is None, "nothing is around it"


def test_a_fine_mesh_made_coarse_covers_the_same(make_run: MakeRun) -> None:
    turn, tilt = np.meshgrid(np.linspace(0, 2 * np.pi, 80), np.linspace(0, np.pi, 60))
    points = np.stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)], axis=-1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    corners = np.concatenate([np.stack(rows, axis=2).reshape(-1, 3, 3) for rows in ((a, b, c), (a, c, d))])
    vertices = corners.reshape(-1, 3)
    few = vertices[coarsened(vertices, np.arange(len(vertices)).reshape(-1, 3), 400)]
    assert 100 < len(few) <= 600
    assert seen(few).seen[0] == pytest.approx(seen(corners).seen[0], rel=0.06)


def test_case_run_and_film_measure_the_same(make_run: MakeRun) -> None:
    case = """\
text2sim: 2
name: same
scene: {duration: 1, statics: {wall: {shape: {kind: box, size: [0.6, 0.1, 1]}, pose: {pos: [-0.3, -1, 0.5]}}}}
bodies: {crate: {kind: rigid, shape: {kind: box, size: [0.8, 0.8, 0.8]}, pose: {pos: [0, 0, 0.4]}}}
render: {resolution: [64, 64], cameras: {main: {kind: still, from: [0, -4, 0.8], look_at: [0, 0, 0.4], fov_deg: 40}}}
"""
    layout = at_start(resolve_case(load_text(case)), "main", (192, 192))
    camera = {"main": {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -4, 0.8), "look_at": (0, 0, 0.4)}}
    # The boxes of recorded runs are cubes: the wall of the same outline as its front.
    boxes = {
        "crate": STILL | {"half": 0.4, "pos": (0, 0, 0.4)},
        "wall": {"half": (0.3, 0.05, 0.5), "pos": (-0.3, -1, 0.5)},
    }
    recording = read_recording(make_run(boxes, cameras=camera, resolution=(64, 64)))
    watcher = Watcher(recording)
    sight = watcher.recorded.sight(0.0, watcher.cameras.view("main", 0.0), (192, 192))
    crate, before = watcher.recorded.names.index("crate"), layout.names.index("crate")
    assert sight.hidden[crate] == pytest.approx(layout.sight.hidden[before], abs=0.01)
    assert 0.2 < sight.hidden[crate] < 0.8
    assert sight.seen[crate] == pytest.approx(layout.sight.seen[before], rel=0.02)
    assert layout.hider({"crate"}) == "wall"


BOXES = {
    "crate": STILL | {"half": 0.4, "pos": (0, 0, 0.4), "color": (0.8, 0.2, 0.1)},
    "key": STILL | {"half": 0.12, "pos": (0, 1.0, 0.12), "color": (0.1, 0.6, 0.1)},
    "pin": STILL | {"half": 0.02, "pos": (0.8, 0, 0.02), "color": (0.1, 0.1, 0.1)},
    "ghost": STILL | {"half": 0.15, "pos": (-0.9, 0, 0.15), "color": (0.8, 0.8, 0.8)},
    "runner": {"half": 0.1, "pos": (0.3, -1.0, 0.1), "velocity": (9.0, 0, 0), "color": (0.1, 0.1, 0.9)},
    "gone": STILL | {"half": 0.1, "pos": (0, -40.0, 0.1)},
}


def test_remarks_say_what_is_not_seen(make_run: MakeRun) -> None:
    watcher = Watcher(read_recording(make_run(BOXES, fps=50.0)))
    moments = [
        Moment("impact", 0.1, ("key", "crate")),
        Moment("late", 3.0, ("crate",)),
        Moment("flight", 0.39, ("runner",)),
    ]
    found = summarise(watcher, moments)
    remarks = "\n".join(found["remarks"])
    assert "`gone` is in no picture" in remarks
    assert "`pin` fills at most 0." in remarks
    assert "`ghost` hardly stands out" in remarks
    assert "`key` is hidden 100 % behind `crate` at the moment of event `impact` (0.10 s)" in remarks
    assert "event `late` at 3.00 s is not in the film" in remarks
    assert "`runner` is not in the picture at the moment of event `flight`" in remarks
    assert "`crate`" not in remarks.replace("behind `crate`", "")
    (gone,) = [row for row in found["remarks"] if "leaves" in row]
    # Half the picture is 4.2 m * tan(20 deg) * 16 / 9 wide about where it runs.
    assert gone.startswith("`runner` leaves the picture at 0.2")
    film = found["films"]["video"]
    assert film["pictures"] == 15
    assert film["statics"] == {}
    assert film["bodies"]["crate"]["seen"] == 15
    assert film["bodies"]["runner"]["seen"] < 12
    assert film["bodies"]["crate"]["share"]["min"] == pytest.approx(film["bodies"]["crate"]["share"]["max"], abs=1e-3)
    assert film["bodies"]["gone"] == {
        "share": {"min": 0, "median": 0, "max": 0}, "hidden": None, "edge": None, "contrast": None, "motion": None, "seen": 0,
    }  # fmt: skip


def test_links_of_a_body_are_things_of_their_own_where_asked_for(make_run: MakeRun) -> None:
    run = make_run(BOXES)
    layout = json.loads((run / "states" / "layout.json").read_text())
    for row in layout["links"]:
        row["body"] = "heap"
    (run / "states" / "layout.json").write_text(json.dumps(layout))
    (run / "program" / "looks.json").write_text("{}")
    shares = largest_shares(Watcher(read_recording(run), links=True))
    assert set(shares) == {f"heap.{name}" for name in BOXES}
    assert shares["heap.crate"] > 0.01
    assert shares["heap.gone"] == 0
    whole = largest_shares(Watcher(read_recording(run)))
    assert list(whole) == ["heap"]
    assert whole["heap"] > shares["heap.crate"]


def test_an_empty_picture_and_an_end_before_the_end_are_said(make_run: MakeRun) -> None:
    box = {"box": {"half": 0.1, "pos": (0, 0, 0.4), "velocity": (1, 0, 0)}}

    def remarks(**film: Any) -> str:
        return "\n".join(summarise(Watcher(read_recording(make_run(box, **film))))["remarks"])

    def shot(start: float, end: float) -> dict[str, Any]:
        return {"name": "a", "camera": "main", "from": start, "to": end, "speed": 0.1, "hold": 0.0}

    assert "all bodies together span" in remarks()
    assert "goes" not in remarks(), "there is but one body"
    near = {"half": 0.1, "pos": (0.3, 0, 0.4), "velocity": (0.1, 0, 0)}
    far = "\n".join(summarise(Watcher(read_recording(make_run(box | {"near": near}))))["remarks"])
    assert "(`box` goes 0.3 m, others 0.03 m at most)" in far
    bin = {"half": 0.3, "pos": (1.0, 0, 0.4)}
    held = {"bodies": ["box", "bin"], "margin": 0.1, "within": None, "direction": (0, -1, 0)}
    main = {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -4, 0), "look_at": (0, 0, 0), "frame": held}
    with_bin = read_recording(make_run(box | {"bin": bin}, cameras={"main": main}))
    assert "span" not in "\n".join(summarise(Watcher(with_bin))["remarks"]), "the bin is meant to be there"
    assert "ends" not in remarks()
    assert "the film ends at 0.19 s of 0.40 s" in remarks(shots=[shot(0.0, 0.2)])
    assert "the film ends with a replay, at 0.19 s" in remarks(shots=[shot(0.0, 0.4), shot(0.1, 0.2)])
    box["box"] |= {"half": 0.8, "velocity": (0, 0, 0)}
    assert "span" not in remarks()
    assert "ends" not in remarks(shots=[shot(0.0, 0.2)]), "nothing happens after that"


def test_what_the_edge_of_the_picture_cuts_is_said(make_run: MakeRun) -> None:
    """A camera 4 m in front of a crate sees 4 * tan(20 deg) = 1.46 m below and above its middle, 3.6 m before it 1.31 m."""
    camera = {"main": {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -4, 0), "look_at": (0, 0, 0)}}
    whole, cut = (STILL | {"half": 0.4, "pos": (x, 0, z)} for x, z in ((-1.0, 0.0), (1.0, 1.15)))
    watcher = Watcher(read_recording(make_run({"whole": whole, "cut": cut}, cameras=camera)))
    found = summarise(watcher)
    inside = least_inside(watcher)
    assert inside["whole"] == 1 and 0.6 < inside["cut"] < 0.81
    (row,) = [row for row in found["remarks"] if "edge" in row]
    # Its near face reaches from 0.75 to 1.55 m, of which 0.24 m are above the edge.
    assert re.fullmatch(r"the picture's edge cuts off up to (2\d|3\d) % of `cut` in 4 of 4 pictures", row), row


@pytest.mark.parametrize(("start", "whole"), [(0.1, True), (0.39, False)])
def test_a_replay_from_nearby_cuts_nothing_off(make_run: MakeRun, start: float, whole: bool) -> None:
    """A close shot of what the film has shown already, or of its last pictures, which it shows for the first time."""
    far = {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -4, 0), "look_at": (0, 0, 0)}
    cameras = {"main": far, "near": far | {"pos": (0, -1.2, 0)}}
    rows = [("main", 0.0, 0.38), ("near", start, 0.4)]
    shots = [
        {"name": f"s{k}", "camera": one, "from": a, "to": b, "speed": 0.1, "hold": 0.0}
        for k, (one, a, b) in enumerate(rows)
    ]
    crate = {"crate": STILL | {"half": 0.4, "pos": (0, 0, 0)}}
    shots = shots if not whole else [shots[0] | {"to": 0.4}, shots[1] | {"to": 0.3}]
    inside = least_inside(Watcher(read_recording(make_run(crate, cameras=cameras, shots=shots))))
    assert (inside["crate"] == 1) is whole


def test_statics_that_the_edge_of_the_picture_cuts_are_said_unless_they_are_background(make_run: MakeRun) -> None:
    """The camera of the test above. The wall reaches far beyond the picture, the pit by some 15 % of its width."""
    camera = {"main": {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -4, 0), "look_at": (0, 0, 0)}}
    statics = {"wall": {"half": (9.0, 0.1, 3.0), "pos": (0, 3.0, 0)}, "pit": {"half": 0.5, "pos": (2.5, 1, 0)}}
    ball = {"ball": STILL | {"half": 0.3, "pos": (0, 0, 0)}}
    found = summarise(Watcher(read_recording(make_run(ball | statics, cameras=camera))))["remarks"]
    cut = [row for row in found if "edge" in row]
    assert len(cut) == 1 and "`pit`" in cut[0] and "show all of it" in cut[0], found


def test_motion_is_the_way_across_the_picture(make_run: MakeRun) -> None:
    camera = {"main": {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -5, 0), "look_at": (0, 0, 0)}}
    run = make_run({"runner": {"half": 0.01, "pos": (-0.1, 0, 0), "velocity": (1.0, 0, 0)}}, cameras=camera)
    row = Watcher(read_recording(run)).rows(read_frames(run))[0]
    assert row["bodies"]["runner"]["motion"] == pytest.approx(0.1 / (2 * 5 * np.tan(np.radians(20))), rel=0.02)


def test_what_spins_in_place_crosses_nothing() -> None:
    """A bar of 2 m that turns by 60 degrees about its middle: its ends move by a metre."""
    bar = np.concatenate([sheet((-1, 1), y, (-0.1, 0.1)) for y in (-0.1, 0.1)])
    cosine, sine = np.cos(np.pi / 3), np.sin(np.pi / 3)
    turned = bar @ np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]])
    one, other = (
        _middles(Things(part, np.zeros(len(part), int), np.ones(len(part), bool), 2)) for part in (bar, turned)
    )
    assert np.abs(turned - bar).max() > 0.8
    assert one[0] == pytest.approx(other[0], abs=1e-12)
    assert np.isnan(one[1]).all(), "nothing is drawn of it"


def read_frames(run: Path) -> Any:
    from text2sim.templates.cadence import MAIN, frames, reels

    recording = read_recording(run)
    return frames(recording.film, reels(recording.film)[MAIN], recording.last)


def test_evidence_names_the_bodies_of_events(make_run: MakeRun) -> None:
    case = load_text("""\
text2sim: 2
name: evidence
scene: {duration: 1}
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [0.8, 0.8, 0.8]}}
  key: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 1, 0]}}
actions:
  events:
    touch: {kind: contact, between: [crate, key]}
    calm: {kind: rest, of: key}
""").case
    log = EventLog({"touch": [{"time": 0.2, "between": ["crate", "key.key"]}], "calm": [{"time": 0.3}], "never": []})
    folder = make_run(BOXES)
    found = summarise_legibility(folder, case, log)
    assert found is not None
    named = [row for row in found["remarks"] if "event" in row]
    assert [row.split("event ")[1][:6] for row in named] == ["`touch", "`calm`"]
    assert found == summarise_legibility(folder, case, log), "a pure function of what lies there"
    (folder / "geometry" / "index.json").unlink()
    assert summarise_legibility(folder, case, log) is None
