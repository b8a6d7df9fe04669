"""The command `text2sim show`."""

import json
from pathlib import Path

from handmade import Cli
from PIL import Image

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.load import load_case, load_text


def test_prints_a_case_and_draws_it(cli: Cli, case: Path, tmp_path: Path) -> None:
    answer = cli("show", case)
    assert answer.code == 0
    name = load_case(case).case.name
    assert answer.err.strip() == f"runs/{name}-layout.png"
    assert Image.open(tmp_path / "runs" / f"{name}-layout.png").size == (1600, 1200)
    assert answer.out.startswith("# cases/fall/case.yaml, with nothing left out.\n\ntext2sim: 2\n")
    assert resolve_case(load_text(answer.out)).plan.sim_digest == resolve_case(load_case(case)).plan.sim_digest


def test_the_density_that_nobody_gave_is_shown(cli: Cli, case: Path) -> None:
    assert "density: 1000.0" in cli("show", case, "--no-png").out
    light = cli("show", case, "--no-png", "--set", "bodies.ball.material.mass=0.2").out
    ball = light[light.index("  ball:") :].split("material: ")[1].splitlines()[0]
    assert "mass: 0.2" in ball
    assert "density" not in ball


def test_overlays_are_shown(cli: Cli, case: Path) -> None:
    answer = cli("show", case, "--no-png", "--set", "scene.duration=0.75")
    assert answer.code == 0
    assert "duration: 0.75" in answer.out
    assert answer.out.startswith("# cases/fall/case.yaml with scene.duration=0.75, with")
    assert answer.err == ""


def test_draws_where_it_is_told_to(cli: Cli, case: Path, tmp_path: Path) -> None:
    answer = cli("show", case, "--png", tmp_path / "deep" / "page.png")
    assert answer.code == 0
    assert (tmp_path / "deep" / "page.png").is_file()
    assert not (tmp_path / "runs").exists()


def test_a_picture_that_cannot_be_written_is_no_crash(cli: Cli, case: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    answer = cli("show", case, "--png", tmp_path / "file" / "page.png")
    assert answer.code == 2
    assert "Traceback" not in answer.err
    assert "file" in answer.err
    answer = cli("show", case, "--png", ".")
    assert (answer.code, answer.err) == (2, "cases/fall/case.yaml: .: Is a directory\n")


def test_json(cli: Cli, case: Path) -> None:
    answer = cli("show", case, "--no-png", "--json")
    document = json.loads(answer.out)
    assert document["ok"]
    assert document["png"] is None
    assert document["resolved"]["name"] == load_case(case).case.name
    assert document["digest"] == resolve_case(load_case(case)).plan.sim_digest
    assert document["comments"]["/scene/substeps"].startswith("derived: ")


def test_one_body(cli: Cli, case: Path) -> None:
    body = next(iter(load_case(case).case.bodies))
    answer = cli("show", case, "--no-png", "--body", body)
    assert answer.code == 0
    assert f"bodies:\n  {body}:" in answer.out
    assert "duration" not in answer.out
    wrong = cli("show", case, "--no-png", "--body", body + "x")
    assert wrong.code == 2
    assert f"did you mean `{body}`?" in wrong.err


def test_a_broken_case_is_reported_like_everywhere(cli: Cli, case: Path, tmp_path: Path) -> None:
    (case / "case.yaml").write_text("text2sim: 2\nname: broken\nscene: {duration: -1}\nbodies: {}\n")
    answer = cli("show", case)
    assert answer.code == 2
    assert "case.yaml:3:19" in answer.err
    assert answer.out == ""
    assert not (tmp_path / "runs").exists()


def test_page_about_it_names_every_option(cli: Cli) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "show.md").read_text(encoding="utf-8")
    shown = cli("show", "--help").out
    options = {word.strip(",│") for word in shown.split() if word.startswith("--")} - {"--help"}
    assert options
    assert all(f"`{option}" in page for option in options), options


def test_what_the_page_shows_is_printed(cli: Cli, cases: Path) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "show.md").read_text(encoding="utf-8")
    printed = cli("show", cases / "conveyor_sorter", "--no-png", "--body", "parcel").out.splitlines()
    for line in page.split("```yaml\n")[1].split("```")[0].splitlines():
        assert line in printed
