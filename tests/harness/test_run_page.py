"""docs/run.md names every recorded array and file, and its example reads a run."""

import re
from pathlib import Path

import pytest

from text2sim.recording.states import CONTACT_FIELDS, FRAME_FIELDS, SOFT_FIELDS

PAGE = (Path(__file__).parents[2] / "docs" / "run.md").read_text("utf-8")


def test_every_recorded_array_is_on_the_page_with_its_shape():
    shapes = {}
    for line in PAGE.splitlines():
        if line.startswith("| `") and ".npz" not in line and len(cells := line.split(" | ")) >= 3 and "(" in cells[1]:
            names, given = re.findall(r"`(\w+)`", cells[0]), re.findall(r"\(([^)]*)\)", cells[1])
            shapes |= dict(zip(names, given if len(given) == len(names) else given * len(names), strict=True))
    frames = {name: ("F", *row) for name, row in (FRAME_FIELDS | SOFT_FIELDS).items()}
    contacts = {name: ("n", *row) for name, row in CONTACT_FIELDS.items()}
    wanted = {name: ", ".join(map(str, row)) for name, row in (frames | contacts).items()}
    wanted = {name: row if ", " in row else f"{row}," for name, row in wanted.items()}
    assert {name: row for name, row in shapes.items() if name != "contact_parts"} == wanted


def test_its_example_reads_a_run(new_run, capsys: pytest.CaptureFixture[str]):
    run = new_run()
    run.add_link("floor", fixed=True, mass=1e9)
    run.add_link("ball", pos=[[0, 0, 2 - t] for t in run.time])
    example = PAGE.split("```python\n")[1].split("```")[0]
    exec(example.replace("runs/bounce", str(run.write())), {})
    assert re.fullmatch(r"lowest 1\.\d+ m at \d\.\d\d s\n", capsys.readouterr().out)
