"""The shared store, in a folder or any file system of fsspec."""

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import fsspec
import pytest

from text2sim.cluster.store import SKIPPED, Store, digest_of
from text2sim.spec_schema.errors import RunError

S3 = Path(os.environ.get("TEXT2SIM_TEST_S3", Path(__file__).parents[2] / ".cache/s3"))
"""A virtual environment with `moto[server]` and `s3fs`, see docs/contributing.md: boto wants an older python-dateutil
than ours, so that they cannot be installed beside text2sim."""


@pytest.fixture(scope="module")
def bucket() -> Iterator[str]:
    """A bucket of a server that speaks S3, in a process of its own."""
    if not (S3 / "bin/moto_server").exists():
        pytest.skip(f"there is no moto_server in {S3}: docs/contributing.md says how to get it")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    server = subprocess.Popen(
        [S3 / "bin/moto_server", "-H", "127.0.0.1", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.STDOUT,
    )
    with pytest.MonkeyPatch.context() as patch:
        # Behind our own packages: only what we lack comes from there.
        patch.setattr(sys, "path", [*sys.path, *map(str, S3.glob("lib/python3*/site-packages"))])
        patch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{port}")
        for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_DEFAULT_REGION"):
            patch.setenv(name, "us-east-1")
        for name in ("HTTP_PROXY", "http_proxy", "AWS_PROFILE"):
            patch.delenv(name, raising=False)
        until = time.monotonic() + 120
        while server.poll() is None and time.monotonic() < until:
            try:
                socket.create_connection(("127.0.0.1", port), 1).close()
                break
            except OSError:
                time.sleep(0.1)
        fsspec.filesystem("s3", skip_instance_cache=True).mkdir("bucket")
        yield "s3://bucket"
    server.terminate()
    server.wait()


@pytest.fixture(params=["folder", "memory", "s3"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Store:
    urls = {"folder": lambda: str(tmp_path / "store"), "memory": lambda: f"memory://{tmp_path.name}"}
    urls["s3"] = lambda: f"{request.getfixturevalue('bucket')}/{tmp_path.name}"
    return Store(urls[request.param]())


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


def test_missing_damaged_and_escaping_files_are_reported(store, tmp_path):
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
        with pytest.raises(RunError, match="invalid path or digest"):
            store.get_tree({name: tree["one"]}, tmp_path / "there")
    assert not list((tmp_path / "there").iterdir())


def test_a_missing_bucket_is_not_created(bucket: str) -> None:
    with pytest.raises(RunError, match="there is no bucket buckte"):
        Store("s3://buckte/runs")
    assert not fsspec.filesystem("s3").exists("buckte")


def test_an_unreachable_store_is_reported_and_not_empty(bucket: str, tmp_path: Path, monkeypatch) -> None:
    store = Store(f"{bucket}/gone")
    tree = store.put_tree(case(tmp_path / "case"), skip=SKIPPED)
    with socket.socket() as probe:  # nobody listens there
        probe.bind(("127.0.0.1", 0))
        monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{probe.getsockname()[1]}")
        config = {"config_kwargs": {"retries": {"max_attempts": 0}}, "skip_instance_cache": True}
        store._fs, store._known = fsspec.filesystem("s3", **config), set()
        for use in (
            lambda: store.put_tree(tmp_path / "case/assets"),
            lambda: store.get_tree(tree, tmp_path / "there"),
            lambda: store.keep("k", {}, tree),
            lambda: store.kept("k"),
        ):
            with pytest.raises(RunError, match="the store s3://bucket/gone cannot be used: Could not connect"):
                use()


def test_an_impossible_store_is_reported(tmp_path):
    with pytest.raises(RunError, match="the store nowhere://x cannot be used"):
        Store("nowhere://x")
    (tmp_path / "file").write_text(json.dumps({}))
    with pytest.raises(RunError, match="cannot be used"):
        Store(str(tmp_path / "file"))
