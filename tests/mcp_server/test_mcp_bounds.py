"""Limits of the server: its folder, sizes, untrusted runs."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from agent_side import TINY, Agent

from text2sim.mcp_server.answers import MAX_PAGE, ToolAnswer, clipped, paged, text_page
from text2sim.mcp_server.workspace import Workspace, read_file
from text2sim.spec_schema.errors import RunError

OUTSIDE = ["../x", "cases/../../x", "/etc", "~", ".git", "cases/.hidden", "a\\b", "a\nb", "", "x" * 400, "C:/x", "a//b"]


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """A case and a run outside the folder that is served."""
    (tmp_path / "case.yaml").write_text(TINY.replace("500", "4321"), "utf-8")
    (tmp_path / "secret.json").write_text('{"verdict": "4321"}', "utf-8")
    return tmp_path


@pytest.mark.parametrize("name", OUTSIDE)
def test_paths_that_lead_out_are_refused(agent: Agent, name: str) -> None:
    for tool, arguments in (("check", {}), ("show", {}), ("new", {}), ("write", {"text": TINY}), ("run", {})):
        assert agent(tool, case=name, **arguments).failed, tool
    assert agent("patch", case=name, operations=[]).failed
    assert agent("evidence", run=name).failed
    assert agent("frames", run=name).failed
    if name:
        assert agent("new", case="from_outside", template=name).failed
    assert not (agent.root.parent / "x").exists()


def test_links_are_not_followed(agent: Agent, elsewhere: Path) -> None:
    (agent.root / "linked").symlink_to(elsewhere)
    inside = agent.root / "cases" / "holds_a_link"
    inside.mkdir(parents=True)
    (inside / "case.yaml").symlink_to(elsewhere / "case.yaml")
    for name in ("linked", "cases/holds_a_link"):
        for tool, arguments in (("check", {}), ("show", {"part": "text"}), ("write", {"text": TINY}), ("run", {})):
            reply = agent(tool, case=name, **arguments)
            assert reply.failed, (name, tool)
            assert "symbolic link" in reply.document["error"]
            assert "4321" not in reply.text
        assert agent("patch", case=name, operations=[]).failed
    assert (elsewhere / "case.yaml").read_text("utf-8") == TINY.replace("500", "4321")


def test_links_in_runs_are_not_followed(agent: Agent, elsewhere: Path) -> None:
    run = agent.root / "runs" / "forged-1"
    run.mkdir(parents=True)
    (run / "evidence.json").symlink_to(elsewhere / "secret.json")
    reply = agent("evidence", run="forged-1")
    assert reply.failed
    assert "4321" not in json.dumps(reply.document)
    (agent.root / "runs" / "forged-2").symlink_to(elsewhere)
    assert agent("evidence", run="forged-2").failed


def test_meshes_of_a_case_stay_inside(agent: Agent, elsewhere: Path) -> None:
    agent.write("thief", TINY.replace("{kind: box, size: [0.2, 0.2, 0.2]}", f"{{kind: mesh, file: {elsewhere}/a.obj}}"))
    assert agent("check", case="thief").document["ok"] is False


def test_large_inputs_and_outputs_are_refused(agent: Agent) -> None:
    reply = agent("write", case="huge", text=TINY + "#" * 3_000_000)
    assert reply.failed
    assert "2000000 at most" in reply.document["error"]
    assert not (agent.root / "cases/huge").exists()
    agent.write("grown", TINY + "#" * 2_100_000)
    assert agent("check", case="grown").document["problems"][0]["rule"] == "too-large"
    agent.write("tiny", TINY)
    many = [{"op": "test", "path": "/name", "value": "tiny"}] * 1001
    assert "more than 1000 operations" in agent("patch", case="tiny", operations=many).document["error"]
    long = [{"op": "add", "path": "/prompt", "value": "x" * 500_000}]
    assert "are allowed" in agent("patch", case="tiny", operations=long).document["error"]


def test_strange_arguments_do_not_end_the_server(agent: Agent) -> None:
    agent.write("tiny", TINY)
    deep: list[object] = []
    for _ in range(80):
        deep = [deep]
    assert agent("patch", case="tiny", operations=[{"op": "add", "path": "/params", "value": deep}]).failed
    assert agent("patch", case="tiny", operations="remove everything").failed
    assert agent("patch", case="tiny", operations=[{"op": "add"}]).failed
    assert agent("write", case="odd", text="a: \x07\u202e b").failed
    assert agent("write", case="odd", text="[" * 5000).failed
    assert agent("check", case="tiny", sets=["a=b", "x" * 1000]).document["ok"] is False
    assert agent("check", case="tiny", offset=-1).failed
    assert agent("run", case="tiny", wait=1e9).failed
    assert agent("frames", run="tiny", count=1000).failed
    assert agent("run_status", id="job-77").failed
    assert agent("check", case="tiny").document["ok"] is True


def test_forged_runs_are_reported_as_damaged(agent: Agent) -> None:
    run = agent.root / "runs" / "forged-3"
    (run / "program").mkdir(parents=True)
    (run / "run.json").write_text('{"case": "x", "state": "finished", "key": {}, "time": 1.0}', "utf-8")
    (run / "evidence.json").write_text('{"expect": {"a": 1}, "measures": [1], "events": {"e": {}}}', "utf-8")
    (run / "measures.csv").write_text("time,a\n0,\n1,junk\n2,3\n", "utf-8")
    (run / "program/render.py").write_text("FPS = 1e12\nCAMERAS = {'a': {}}\nSHOTS = []\nSTART = 0\n", "utf-8")
    assert agent("evidence", run="forged-3").document["events"] == {"e": "never"}
    assert agent("evidence", run="forged-3", part="series:a").text.splitlines()[-1] == "2, 3"
    (run / "measures.csv").write_text("time,a\n0," + "1" * 200_000, "utf-8")
    assert "damaged" in agent("evidence", run="forged-3", part="series:a").document["error"]
    huge = '{"measures": {"m": {"unit": "m", "first": 1, "last": 1' + "0" * 400 + "}}}"
    (run / "evidence.json").write_text(huge, "utf-8")
    assert agent("evidence", run="forged-3").document["measures"]["m"].startswith("first 1, last none, min none")
    (run / "evidence.json").write_text('{"time": "now", "expect": {"a": {"ok": []}}}', "utf-8")
    forged = agent("evidence", run="forged-3").document
    assert (forged["reached"], forged["expect"]) == ("None of None s", {"a": "open: : "})
    assert "describes no film" in agent("frames", run="forged-3").document["error"]
    endless = "FPS = 1e9\nCAMERAS = {'a': {}}\nSHOTS = []\nSTART = 0\nEND = 100\nSPEED = 1.0\nMOTION_BLUR = 0\n"
    (run / "program/render.py").write_text(endless, "utf-8")
    assert "too long" in agent("frames", run="forged-3").document["error"]
    (run / "evidence.json").write_text("[" * 100_000, "utf-8")
    assert "damaged" in agent("evidence", run="forged-3").document["error"]


def test_pages_cover_everything_once() -> None:
    rows = [{"n": i, "words": "w" * 100} for i in range(500)]
    seen, offset = [], 0
    while True:
        page = paged(rows, offset)
        assert len(json.dumps(page)) < MAX_PAGE + 500
        seen += page["rows"]
        if "next_offset" not in page:
            break
        offset = page["next_offset"]
    assert seen == rows
    text = "\n".join(f"line {i}" for i in range(5_000))
    whole, offset = "", 0
    while True:
        piece, said = text_page(text, offset)
        assert len(piece) <= MAX_PAGE
        whole += piece
        if "next_offset" not in said:
            break
        offset = said["next_offset"]
    assert whole == text


def test_no_document_is_long() -> None:
    assert clipped("x" * 5_000).endswith("(5000 characters)")
    assert clipped(list(range(100)))[-1] == "… 70 more"
    document = {f"key_{i}": ["words " * 50] * 50 for i in range(200)}
    assert len(ToolAnswer(document).words()) <= 2 * MAX_PAGE + 100
    assert "\ud800" not in ToolAnswer({"half": "\ud800"}).words()


def test_files_of_runs_have_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Workspace(tmp_path)
    (tmp_path / "large").write_bytes(b"x" * 2_000_001)
    with pytest.raises(RunError, match="larger than 2 MB"):
        read_file(Path("large"), 2_000_000)
    assert read_file(Path("nothing"), 10) is None
    assert read_file(Path("."), 10) is None


def test_a_run_is_named_by_the_folder_of_its_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # a workspace changes the folder; this returns to the one before
    for file in ("cases/tiny/case.yaml", "runs/tiny-0123456789/run.json"):
        (tmp_path / file).parent.mkdir(parents=True)
        (tmp_path / file).write_text("{}")
    workspace = Workspace(tmp_path)
    for name in ("tiny", "cases/tiny", "cases/tiny/case.yaml", "runs/tiny-0123456789"):
        assert workspace.run_folder(name) == Path("runs/tiny-0123456789")
    with pytest.raises(RunError, match="neither a run, such as .* nor a case"):
        workspace.run_folder("cases/tyni")


def test_run_folders_are_only_read(agent: Agent) -> None:
    run = agent.root / "runs" / "tiny-0123456789"
    run.mkdir(parents=True)
    (run / "case.yaml").write_text(TINY, "utf-8")
    change = [{"op": "replace", "path": "/scene/duration", "value": 0.1}]
    replaces = agent("show", case=f"runs/{run.name}", part="text").document["digest"]
    for reply in (
        agent("patch", case=f"runs/{run.name}", operations=change),
        agent("write", case=f"runs/{run.name}", text=TINY.replace("500", "600"), replaces=replaces),
        agent("write", case=f"runs/{run.name}/inside", text=TINY),
        agent("new", case="runs/another"),
    ):
        assert reply.failed
        assert "only read there" in reply.document["error"]
    assert (run / "case.yaml").read_text("utf-8") == TINY
    assert not (agent.root / "runs" / "another").exists()


def test_arguments_that_a_tool_does_not_have_are_refused(agent: Agent) -> None:
    agent.write("tiny", TINY)
    reply = agent("check", case="tiny", variant="soft")
    assert reply.failed
    assert "variant" in reply.document["error"]


def test_half_a_character_is_answered(agent: Agent) -> None:
    assert agent("language", topic="\ufffe \x9b").document


def test_half_a_surrogate_pair_is_answered_and_the_server_goes_on(tmp_path: Path) -> None:
    """The SDK drops a request that holds one; no client of it can send one, but others can."""
    hello = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "x", "version": "1"}}
    calls = [{"case": "q\ud800"}, {"case": "q \udc00 \u00e9"}, {"case": "q"}]
    rows = [{"id": 0, "method": "initialize", "params": hello}, {"method": "notifications/initialized"}]
    rows += [
        {"id": k, "method": "tools/call", "params": {"name": "check", "arguments": a}} for k, a in enumerate(calls, 1)
    ]
    server = subprocess.Popen(
        [sys.executable, "-m", "text2sim", "mcp", "--root", str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert server.stdin is not None
    assert server.stdout is not None
    with server:
        for row in rows:
            server.stdin.write(json.dumps({"jsonrpc": "2.0", **row}).encode() + b"\n")
            server.stdin.flush()
        answers = [json.loads(server.stdout.readline()) for _ in range(4)]
        server.stdin.close()
    assert {answer["id"] for answer in answers} == {0, 1, 2, 3}
    assert all(answer["result"]["isError"] for answer in answers if answer["id"])
