"""A judged run with names that would be harmful as HTML or scripts."""

import json
from pathlib import Path

import pytest
from exchange.recorded import write_run

from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.models.case import Case

HARM = "</script><img src=x onerror=document.title='harmed'>"
CASE = """
text2sim: 2
name: judged
scene:
  duration: 0.1
  dt: 0.02
  statics:
    floor: {shape: {kind: plane}}
bodies:
  box: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, repeat: {kind: line, count: 2, step: [1, 0, 0]}}
actions:
  measures:
    height: {kind: extent, of: box, axis: z, stat: max}
  events:
    landing: {kind: contact, between: [box, floor]}
  expect:
    lands: {event: landing, within: [0, 1]}
    falls: {measure: height, during: [0.06, 0.1], below: 0.99}
"""


@pytest.fixture(scope="session")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    path = tmp_path_factory.mktemp("case") / "case.yaml"
    path.write_text(CASE)
    return load_case(path).case


@pytest.fixture
def judged(tmp_path: Path) -> Path:
    """The folder of a judged run."""
    folder = write_run(tmp_path / "run")
    layout = folder / "states" / "layout.json"
    layout.write_text(layout.read_text().replace('"sand"', json.dumps(HARM)))
    (folder / "measures.csv").write_text("time,height\n0,1\n0.02,0.998\n0.04,0.992\n0.06,\n0.08,0.969\n0.1,0.951\n")
    rows = [{"name": None, "kind": "contact", "time": 0.02, "between": ["box[0]", "floor"]}]
    rows += [{"name": "landing", "kind": "contact", "time": t, "between": ["box[0]", HARM]} for t in (0.08, 0.04)]
    (folder / "events.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    evidence = {
        "verdict": "failed", "why": f"1 of 2 expectations missed: falls {HARM}",
        "measures": {"height": {"unit": "m"}}, "events": {}, "time": {"reached": 0.1},
        "expect": {
            "lands": {"name": "lands", "ok": True, "wanted": "`landing` happens first", "why": "happened"},
            "falls": {"name": "falls", "ok": False, "wanted": "`height` below 0.99 m", "why": HARM},
        },
    }  # fmt: skip
    (folder / "evidence.json").write_text(json.dumps(evidence))
    return folder
