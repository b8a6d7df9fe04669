"""What `text2sim prefabs` says."""

from pathlib import Path

from handmade import Cli, write_case

CASE = """\
text2sim: 2
name: own
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
prefabs:
  brick:
    doc: A brick. Origin in its middle.
    params: {length: {kind: length, doc: From end to end.}}
    body: {kind: rigid, shape: {kind: box, size: ["${length}", 0.1, 0.1]}}
bodies:
  wall: {use: brick, with: {length: 0.2}, place: {on: floor}}
"""


def test_all_are_listed_with_their_first_sentence(cli: Cli):
    answer = cli("prefabs")
    assert answer.code == 0
    assert "wine_glass   A wine glass on a stem\n" in answer.out
    assert len(answer.out.splitlines()) == 20


def test_one_is_described_with_its_parameters_and_an_example(cli: Cli):
    answer = cli("prefabs", "ring_chain")
    assert answer.code == 0
    assert "Bodies: NAME_anchor, NAME_ring" in answer.out
    assert "a whole number from 1 to 60; 8 if left out" in answer.out
    assert "chain: {use: ring_chain, with: {at: [0, 0, 1], rings: 6}}" in answer.out


def test_a_wrong_name_gets_the_nearest(cli: Cli):
    answer = cli("prefabs", "wine_glas")
    assert (answer.code, answer.out) == (2, "")
    assert "did you mean `wine_glass`?" in answer.err


def test_those_of_a_case_are_found_first(cli: Cli, tmp_path: Path):
    folder = write_case(tmp_path / "own", CASE)
    answer = cli("prefabs", "--case", folder)
    assert "brick        A brick\n" in answer.out
    answer = cli("prefabs", "brick", "--case", folder)
    assert "a length [m] greater than 0, required" in answer.out
    assert "my_brick: {use: brick, with: {length: …}, place: {on: floor}}" in answer.out


def test_a_broken_one_does_not_hide_the_others(cli: Cli, tmp_path: Path):
    folder = write_case(tmp_path / "own", CASE)
    (folder / "prefabs").mkdir()
    (folder / "prefabs" / "bad.yaml").write_text("text2sim: 2\nprefab: bad\nbody: 3\n")
    answer = cli("prefabs", "--case", folder)
    assert answer.code == 2
    assert "bad.yaml" in answer.err and "Traceback" not in answer.err
    assert "table" in answer.out


def test_a_case_that_is_not_there_is_wrong_input(cli: Cli, tmp_path: Path):
    answer = cli("prefabs", "--case", tmp_path / "nowhere")
    assert answer.code == 2
    assert "Traceback" not in answer.err


def test_machines_get_all_of_it(cli: Cli):
    answer = cli("prefabs", "--json")
    rows = {row["name"]: row for row in answer.json["prefabs"]}
    assert rows["wheel"]["params"]["radius"]["default"] == 0.25
    assert rows["curtain_rod"]["parts"] == ["rod", "hook"]
