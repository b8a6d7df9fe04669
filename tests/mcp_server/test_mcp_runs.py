"""Tools that run a case and report the result."""

import shutil
import time
from io import BytesIO
from pathlib import Path
from typing import Any

import anyio
import psutil
import pytest
from agent_side import TINY, Agent, Reply, parameters
from anyio.from_thread import BlockingPortal
from mcp import Client
from PIL import Image

pytestmark = pytest.mark.usefixtures("engine")
LONG = TINY.replace("duration: 0.2  # short", "duration: 500").replace("dt: 0.005", "dt: 0.001")


def finished(agent: Agent, first: Reply, patience: float = 400.0) -> Reply:
    """Ask after a run until it is over."""
    reply, end = first, time.monotonic() + patience
    while reply.document.get("state") in ("running", "stopping"):
        assert time.monotonic() < end, reply.document
        reply = agent("run_status", id=reply.document["id"], wait=20)
    return reply


@pytest.fixture(scope="module")
def ran(agent: Agent) -> dict[str, Any]:
    """What came of the tiny case; it is run once, and asked after."""
    agent.write("tiny", TINY)
    begun = agent("run", case="tiny", wait=0)
    assert begun.document["state"] == "running"
    assert agent("run", case="tiny", wait=0).document["id"] == begun.document["id"]
    agent.write("other", TINY)
    busy = agent("run", case="other", wait=0)
    assert busy.failed
    assert "tiny is running" in busy.document["error"]
    watched = agent("run_status", wait=50)
    assert watched.progress
    values = [row[0] for row in watched.progress]
    assert values == sorted(set(values))
    assert watched.progress[0][1] == 8
    return finished(agent, watched).document


def test_run_reports_its_result(agent: Agent, ran: dict[str, Any]) -> None:
    assert ran["state"] == "finished"
    assert ran["passed"] is True
    assert ran["expect"]["lands"].startswith("ok: ")
    assert (agent.root / "runs" / ran["run"] / "evidence.json").is_file()


def test_finished_work_is_not_repeated(agent: Agent, ran: dict[str, Any]) -> None:
    agent.write("tiny", TINY)
    reply = finished(agent, agent("run", case="tiny", wait=50))
    assert "unchanged" in reply.document["summary"]
    assert reply.document["run"] == ran["run"]


def test_evidence_has_a_summary_and_parts(agent: Agent, ran: dict[str, Any]) -> None:
    summary = agent("evidence", run="tiny").document
    assert summary["run"] == ran["run"]
    assert summary["verdict"] == "passed"
    assert summary["events"]["touch"].startswith("1 times, first at 0.1")
    assert "m]" in summary["measures"]["height"]
    timeline = agent("evidence", run=ran["run"], part="timeline").document
    assert any(row["name"] == "touch" for row in timeline["rows"])
    assert agent("evidence", run=ran["run"], part="diagnostics").document["energy"]["unit"] == "J"
    assert agent("evidence", run=ran["run"], part="settings").document["total"] > 2
    assert "name: tiny" in agent("evidence", run=ran["run"], part="case").text
    series = agent("evidence", run=ran["run"], part="series:height").text.splitlines()
    assert series[0].startswith("0, 0.05")
    assert "did you mean" in agent("evidence", run=ran["run"], part="timelin").document["error"]
    assert "there are height" in agent("evidence", run=ran["run"], part="series:hight").document["error"]


def test_frames_come_on_one_sheet(agent: Agent, ran: dict[str, Any]) -> None:
    if ran["film"].startswith("none"):
        pytest.skip("no film without OpenGL")
    two = agent("frames", run="tiny", times=[0.0, 0.12])
    assert [row["t"] for row in two.document["shown"]] == [0.0, 0.12]
    assert two.media == "image/jpeg"
    with Image.open(BytesIO(two.picture)) as sheet:
        assert sheet.size == (2 * 324 + 4, 271)  # a line of 23 pixels above each picture
        left, right = sheet.crop((4, 27, 324, 267)), sheet.crop((328, 27, 648, 267))
        assert left.tobytes() != right.tobytes()
    every = agent("frames", run="tiny", count=16)
    assert len(every.document["shown"]) == every.document["pictures"]
    assert "there is no camera" in agent("frames", run="tiny", camera="side").document["error"]


def test_a_run_without_a_film_gives_advice(agent: Agent, ran: dict[str, Any]) -> None:
    source, copy = agent.root / "runs" / ran["run"], agent.root / "runs" / "unfilmed-1"
    shutil.copytree(source, copy, dirs_exist_ok=True)
    (copy / "video.mp4").unlink(missing_ok=True)
    assert "film: true" in agent("frames", run="unfilmed-1").document["error"]


def test_a_bad_case_is_not_run(agent: Agent) -> None:
    agent.write("bad", TINY.replace("kind: rigid", "kind: rigd"))
    reply = agent("run", case="bad")
    assert reply.failed
    assert reply.document["state"] == "not run"
    assert reply.document["problems"][0]["did_you_mean"] == "rigid"


def test_a_cancelled_call_stops_its_run(agent: Agent) -> None:
    agent.write("long", LONG)

    async def impatient() -> None:
        with anyio.move_on_after(1.5):
            await agent.client.call_tool("run", {"case": "long", "film": False, "wait": 50})

    agent.portal.call(impatient)
    after = agent("run_status", wait=0)
    assert after.document["state"] in ("stopping", "interrupted")
    assert finished(agent, after, 60).document["state"] == "interrupted"


def test_a_run_is_stopped_on_request(agent: Agent) -> None:
    agent.write("long", LONG)
    begun = agent("run", case="long", film=False, wait=1)
    stopping = agent("run_status", id=begun.document["id"], stop=True, wait=0)
    assert finished(agent, stopping, 60).document["state"] == "interrupted"


def test_a_run_ends_with_its_server(tmp_path: Path, portal: BlockingPortal) -> None:
    with portal.wrap_async_context_manager(Client(parameters(tmp_path))) as client:
        agent = Agent(client, portal, tmp_path)
        agent.write("long", LONG)
        agent("run", case="long", film=False, wait=2)
        assert programs(tmp_path)
    end = time.monotonic() + 10
    while programs(tmp_path) and time.monotonic() < end:
        time.sleep(0.1)
    assert not programs(tmp_path)


def programs(root: Path) -> list[int]:
    """Processes that work in a run folder below `root`."""
    found = []
    for process in psutil.process_iter(["cwd"]):
        if str(process.info["cwd"] or "").startswith(str(root / "runs")):
            found.append(process.pid)
    return found
