"""Damaged run folders: `run` mends them and says so, the other commands refuse them in a line."""

import json
from pathlib import Path

import numpy as np
import pytest
from handmade import Cli

SPOILED = {
    "empty": b"",
    "truncated": None,
    "list": b"[]",
    "object": b"{}",
    "foreign": b'{"verdict": "passed", "expect": {"falls": 3}, "measures": [], "time": "now"}',
    "binary": b"\x00\xff\xfe" * 100,
    "deep": b"[" * 100_000,
}


def spoil(path: Path, how: str) -> None:
    data = SPOILED[how]
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2] if data is None else data)


@pytest.mark.parametrize("how", SPOILED)
def test_spoiled_evidence_is_made_again(cli: Cli, case: Path, folder: Path, how: str):
    before = (folder / "evidence.json").read_bytes()
    spoil(folder / "evidence.json", how)
    assert cli("compare", folder, folder, "--json").code == 2
    answer = cli("run", case)
    assert answer.code == 0, answer.err
    assert "judged again" in answer.err
    assert (folder / "evidence.json").read_bytes() == before


@pytest.mark.parametrize("name", ["run.json", "resolved.json", "measures.csv", "events.jsonl", "expanded.yaml"])
@pytest.mark.parametrize("how", ["empty", "truncated", "object", "binary"])
def test_no_spoiled_file_is_a_bug_of_ours(cli: Cli, folder: Path, name: str, how: str):
    spoil(folder / name, how)
    assert cli("compare", folder, folder, "--json").code in (0, 2)
    assert cli("replay", folder).code in (0, 2)


@pytest.mark.parametrize("name", ["states/chunk_00000.npz", "states/layout.json"])
@pytest.mark.parametrize("how", [*SPOILED, "gone", "another"])
def test_spoiled_states_are_refused(cli: Cli, folder: Path, name: str, how: str):
    path = folder / name
    if how == "gone":
        path.unlink()
    elif how == "another" and path.suffix == ".npz":
        with np.load(path) as chunk:
            arrays = dict(chunk)
        np.savez(path, **(arrays | {"links_pos": arrays["links_pos"] + 1.0}))  # type: ignore[arg-type]
    elif how == "another":
        path.write_text(json.dumps(json.loads(path.read_text()) | {"dt": 0.02}))
    else:
        spoil(path, how)
    for command in (("replay", folder), ("render", folder, "--suggest"), ("export", folder, "--gltf", "a.glb")):
        answer = cli(*command)
        assert (answer.code, len(answer.err.splitlines())) == (2, 1), answer.err
        assert path.name in answer.err


@pytest.mark.parametrize("how", SPOILED)
def test_without_a_record_that_can_be_trusted_nothing_is_shown_of_a_run(cli: Cli, folder: Path, how: str):
    spoil(folder / "run.json", how)
    for command in (("compare", folder, folder), ("replay", folder), ("export", folder, "--gltf", "a.glb")):
        answer = cli(*command)
        assert answer.code == 2, command
        assert "run.json is damaged; run the case again" in answer.err
