"""Meshes from text, by a local server that speaks Meshy's protocol."""

from collections.abc import Iterator
from pathlib import Path

import pytest
import trimesh

from tests.assets.meshy_server import KEY, PATH, MeshyServer, meshy_server
from text2sim.asset_intake.register import generate
from text2sim.assets.manifest import read_manifest, verify_manifest
from text2sim.assets.meshy import Meshy, Order3D
from text2sim.assets.meshy_ledger import FILE, OrderLedger
from text2sim.spec_schema.errors import AssetError, MachineError, RunError, Text2SimError

WISH = Order3D("a ceramic teapot")


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[MeshyServer]:
    monkeypatch.setenv("MESHY_API_KEY", KEY)
    content = trimesh.creation.icosphere(2).export(file_type="glb")
    with meshy_server(content) as state:
        yield state


class Time:
    """A clock that goes on when somebody waits."""

    def __init__(self) -> None:
        self.now = 0.0
        self.waits: list[float] = []

    def pause(self, seconds: float) -> None:
        self.now += seconds
        self.waits.append(seconds)


def client(case: Path, server: MeshyServer, time: Time | None = None, **options) -> Meshy:
    time = time or Time()
    return Meshy(case, base=server.base, pause=time.pause, clock=lambda: time.now, **options)


def test_a_preview_and_its_picture_are_made_and_fetched(tmp_path: Path, server: MeshyServer):
    said: list[str] = []
    content = client(tmp_path, server, say=said.append).make(WISH)
    assert content == server.glb
    assert server.posted() == ["preview", "refine"]
    preview, refine = server.tasks.values()
    assert preview["body"]["prompt"] == "a ceramic teapot"
    assert preview["body"]["target_polycount"] == 30_000
    assert refine["body"]["preview_task_id"] == preview["id"]
    assert any("40 %" in text for text in said)
    assert OrderLedger(tmp_path).spent() == 30
    assert server.downloads_with_key == 0, "results lie on other machines, which must not see the key"


def test_the_same_wish_again_costs_nothing(tmp_path: Path, server: MeshyServer):
    client(tmp_path, server).make(WISH)
    assert client(tmp_path, server).make(WISH) == server.glb
    assert server.posted() == ["preview", "refine"]


def test_without_a_picture_only_the_shape_is_paid(tmp_path: Path, server: MeshyServer):
    client(tmp_path, server).make(Order3D("a cup", refine=False))
    assert server.posted() == ["preview"]
    # … and with one later, the shape is not paid again
    client(tmp_path, server).make(Order3D("a cup"))
    assert server.posted() == ["preview", "refine"]


def test_a_killed_call_goes_on_with_its_task(tmp_path: Path, server: MeshyServer):
    class Killed(BaseException):
        pass

    def kill(seconds: float) -> None:
        raise Killed

    with pytest.raises(Killed):
        Meshy(tmp_path, base=server.base, pause=kill).make(WISH)
    assert server.posted() == ["preview"]
    client(tmp_path, server).make(WISH)
    assert server.posted() == ["preview", "refine"]


@pytest.mark.parametrize("fault", ["drop", "garbage", 500])
def test_a_lost_answer_is_looked_for_before_anything_is_paid_again(
    tmp_path: Path, server: MeshyServer, fault: int | str
):
    server.faults = [fault]
    if fault == "garbage":
        with pytest.raises(RunError, match="no valid task id"):
            client(tmp_path, server).make(WISH)
    client(tmp_path, server).make(WISH)
    assert server.posted() == ["preview", "refine"]


def test_a_kill_before_the_answer_is_healed_by_the_next_call(tmp_path: Path, server: MeshyServer):
    server.faults = ["drop", *[503] * 20]
    with pytest.raises(MachineError, match="nothing is lost"):
        client(tmp_path, server).make(WISH)
    server.faults = []
    client(tmp_path, server).make(WISH)
    assert server.posted() == ["preview", "refine"]


def test_it_waits_as_long_as_the_server_asks(tmp_path: Path, server: MeshyServer):
    time = Time()
    server.faults = [429, 429]
    client(tmp_path, server, time).make(WISH)
    assert time.waits[:2] == [7.0, 7.0]
    assert server.posted() == ["preview", "refine"]


def test_looks_at_a_task_become_rarer(tmp_path: Path, server: MeshyServer):
    time = Time()
    server.polls = 8
    client(tmp_path, server, time).make(Order3D("a cup", refine=False))
    assert time.waits == sorted(time.waits) and time.waits[-1] == 20.0


@pytest.mark.parametrize(
    ("fault", "kind", "words"),
    [
        (401, RunError, "does not accept the key"),
        (402, RunError, "not have enough credits"),
        (400, RunError, "refuses .400.: fault 400"),
    ],
)
def test_permanent_errors_are_reported_without_a_second_try(
    tmp_path: Path, server: MeshyServer, fault: int, kind: type[Text2SimError], words: str
):
    server.faults = [fault]
    with pytest.raises(kind, match=words):
        client(tmp_path, server).make(WISH)
    assert server.log == [f"POST {PATH}"]
    assert OrderLedger(tmp_path).spent() == 0


def test_a_failed_task_is_reported_and_started_again_next_time(tmp_path: Path, server: MeshyServer):
    server.ends = "FAILED"
    with pytest.raises(RunError, match="preview ended as FAILED: the.*shape collapsed") as caught:
        client(tmp_path, server).make(WISH)
    assert "\x1b" not in str(caught.value)
    server.ends = "SUCCEEDED"
    client(tmp_path, server).make(WISH)
    assert server.posted() == ["preview", "preview", "refine"]
    assert OrderLedger(tmp_path).spent() == 30, "the server says that the failed one cost nothing"


def test_a_task_that_is_gone_is_expired(tmp_path: Path, server: MeshyServer):
    client(tmp_path, server).make(Order3D("a cup", refine=False))
    server.tasks.clear()
    with pytest.raises(RunError, match="EXPIRED"):
        client(tmp_path, server).make(Order3D("a cup", refine=False))


def test_the_budget_is_of_the_whole_case(tmp_path: Path, server: MeshyServer):
    client(tmp_path, server, budget=35).make(WISH)
    with pytest.raises(RunError, match="30 of the budget of 35 are spent"):
        client(tmp_path, server, budget=35).make(Order3D("a cup"))
    assert server.posted() == ["preview", "refine"]


def test_time_runs_out_with_nothing_lost(tmp_path: Path, server: MeshyServer):
    server.polls = 10**6
    with pytest.raises(MachineError, match="ask again to continue"):
        client(tmp_path, server, timeout=60.0).make(WISH)
    server.polls = 0
    client(tmp_path, server).make(WISH)
    assert server.posted() == ["preview", "refine"]


def test_the_key_is_written_nowhere(tmp_path: Path, server: MeshyServer):
    client(tmp_path, server).make(WISH)
    for path in tmp_path.rglob("*"):
        assert path.is_dir() or KEY not in path.read_text("utf-8", "replace")


def test_a_missing_key_is_reported_with_advice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv("MESHY_API_KEY", raising=False)
    with pytest.raises(MachineError, match="the language's own shapes"):
        Meshy(tmp_path)


URLS = ["http://example.org/a.glb", "file:///etc/passwd", "https:///x", "https://a\x01b/c.glb", None, 7]


@pytest.mark.parametrize("url", URLS)
def test_results_are_fetched_from_safe_addresses_alone(tmp_path: Path, server: MeshyServer, url: object, monkeypatch):
    look = server.look
    monkeypatch.setattr(server, "look", lambda name: look(name) | {"model_urls": {"glb": url}})
    with pytest.raises(RunError, match=r"no \.glb file"):
        client(tmp_path, server).make(WISH)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"model_urls": ["a.glb"]}, r"no \.glb file"),
        ({"status": "FAILED", "task_error": "no credits left"}, "preview ended as FAILED; ask again"),
    ],
)
def test_malformed_tasks_are_reported(tmp_path: Path, server: MeshyServer, change, words: str, monkeypatch):
    look = server.look
    monkeypatch.setattr(server, "look", lambda name: look(name) | change)
    with pytest.raises(RunError, match=words):
        client(tmp_path, server).make(WISH)


def test_the_key_is_sent_over_encrypted_lines_alone(tmp_path: Path, server: MeshyServer):
    with pytest.raises(AssetError, match="https"):
        Meshy(tmp_path, base="http://example.org")


@pytest.mark.parametrize("prompt", ["", "x" * 601, "two\nlines"])
def test_prompts_are_limited(prompt: str):
    with pytest.raises(AssetError, match="prompt"):
        Order3D(prompt)


TASK = '{"orders": {"k": {"prompt": "", "options": {}, "tasks": {}, "former": [{"asked": 0, "price": "20"}]}}}'


@pytest.mark.parametrize("text", ["{", TASK])
def test_a_damaged_ledger_is_not_paid_over(tmp_path: Path, server: MeshyServer, text: str):
    (tmp_path / "assets").mkdir()
    (tmp_path / FILE).write_text(text)
    with pytest.raises(AssetError, match="damaged"):
        client(tmp_path, server).make(WISH)
    assert server.posted() == []


def test_a_generated_mesh_is_repaired_and_registered(tmp_path: Path, server: MeshyServer):
    from text2sim.assets.mesh_repair import RepairGoal

    added = generate(tmp_path, "teapot", WISH, client(tmp_path, server), goal=RepairGoal(size=0.3))
    assert added.asset.source == "meshy"
    assert added.asset.prompt == "a ceramic teapot"
    assert max(added.asset.size or ()) == pytest.approx(0.3)
    assert added.asset.closed
    assert read_manifest(tmp_path).assets["teapot"] == added.asset
    assert verify_manifest(tmp_path) == {"teapot": []}
