"""The shared store: a folder, or whatever fsspec reaches."""

import json
from pathlib import Path

import fsspec
import pytest

from text2sim.cluster.store import SKIPPED, Store, digest_of
from text2sim.spec_schema.errors import RunError


@pytest.fixture(params=["folder", "memory"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Store:
    return Store(str(tmp_path / "store") if request.param == "folder" else f"memory://{tmp_path.name}")


def case(folder: Path) -> Path:
    for name, text in (("case.yaml", "a"), ("assets/cup.obj", "v 0 0 0"), ("runs/x/run.json", "{}"), (".git/HEAD", "")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    (folder / "secret").symlink_to("/etc/passwd")
    return folder


def test_a_folder_comes_out_as_it_went_in_without_links_and_runs(store, tmp_path):
    tree = store.put_tree(case(tmp_path / "case"), skip=SKIPPED)
    assert set(tree) == {"case.yaml", "assets/cup.obj"}
    store.get_tree(tree, tmp_path / "there")
    assert (tmp_path / "there/assets/cup.obj").read_text() == "v 0 0 0"
    assert len(list((tmp_path / "there").rglob("*"))) == 3
    assert digest_of(tree) == digest_of(Store(store.url).put_tree(tmp_path / "there"))


def test_a_result_is_there_as_a_whole_or_not(store):
    assert store.kept("k") is None
    store.keep("k", {"state": "finished"}, {})
    assert store.kept("k") == ({"state": "finished"}, {})


def test_what_is_missing_damaged_or_leads_out_is_said(store, tmp_path):
    (tmp_path / "one").write_text("1")
    tree = store.put_tree(tmp_path / "one")
    fs, root = fsspec.core.url_to_fs(store.url)
    blob = f"{root.rstrip('/')}/blobs/{tree['one'][:2]}/{tree['one']}"
    fs.pipe_file(blob, b"2")
    with pytest.raises(RunError, match="one is damaged in the store"):
        store.get_tree(tree, tmp_path / "there")
    fs.rm(blob)
    with pytest.raises(RunError, match="one is missing in the store"):
        store.get_tree(tree, tmp_path / "there")
    for name in ("../out", "/out"):
        with pytest.raises(RunError, match="no place for one"):
            store.get_tree({name: tree["one"]}, tmp_path / "there")
    assert not list((tmp_path / "there").iterdir())


def test_a_store_that_cannot_be_is_told_so(tmp_path):
    with pytest.raises(RunError, match="the store nowhere://x cannot be used"):
        Store("nowhere://x")
    (tmp_path / "file").write_text(json.dumps({}))
    with pytest.raises(RunError, match="cannot be used"):
        Store(str(tmp_path / "file"))
