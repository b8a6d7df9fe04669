"""Tools that read and write cases, called over the wire."""

from io import BytesIO

import pytest
from agent_side import TINY, Agent
from PIL import Image

TOOLS = {
    "check", "show", "new", "write", "patch", "run", "run_status", "evidence", "frames", "cards", "language",
}  # fmt: skip


@pytest.fixture
def tiny(agent: Agent) -> str:
    """A case that is fine, as it was at first."""
    agent.write("tiny", TINY)
    return "cases/tiny"


def test_tools_are_few_and_described(agent: Agent) -> None:
    tools = agent.portal.call(agent.client.list_tools).tools
    assert {tool.name for tool in tools} == TOOLS
    assert all(tool.description and len(tool.description) < 700 for tool in tools)
    assert sum(len(tool.model_dump_json(exclude_none=True)) for tool in tools) < 14_000
    changing = {tool.name for tool in tools if tool.annotations and not tool.annotations.read_only_hint}
    assert changing == {"new", "write", "patch", "run", "run_status"}
    assert "never weaken" in (agent.client.instructions or "")


def test_check_locates_problems(agent: Agent) -> None:
    agent.write("bad", TINY.replace("density:", "densty:").replace("of: box", "of: bxo"))
    reply = agent("check", case="bad")
    assert reply.document["ok"] is False
    assert reply.document["errors"] == 2
    first, second = reply.document["problems"]
    assert first["at"] == "cases/bad/case.yaml:15:16"
    assert first["did_you_mean"] == "density"
    assert first["line"] == "material: {densty: 500}"
    assert second["path"] == "/actions/measures/height/of"


def test_check_takes_values_and_derived_settings(agent: Agent, tiny: str) -> None:
    fine = agent("check", case=tiny, settings=True).document
    assert fine["ok"] is True
    assert any(note.startswith("substeps") for note in fine["settings"])
    assert not agent("check", case=tiny, sets=["bodies.box.material.density=-1"]).document["ok"]
    assert not agent("check", case=tiny, variants=["soft"]).document["ok"]


def test_many_problems_come_in_pages(agent: Agent) -> None:
    agent.write("worse", TINY + "".join(f"  wrong_{i}: {'x' * 300}\n" for i in range(90)))
    page = agent("check", case="worse").document
    assert page["errors"] == 90
    assert 0 < len(page["problems"]) < 90
    rest = agent("check", case="worse", offset=page["next_offset"]).document
    assert rest["problems"][0] not in page["problems"]


def test_show_draws_the_start(agent: Agent, tiny: str) -> None:
    reply = agent("show", case=tiny)
    assert reply.document["bodies"] == {"box": "rigid box"}
    assert reply.document["events"] == {"touch": "contact"}
    assert reply.media == "image/png"
    with Image.open(BytesIO(reply.picture)) as picture:
        assert picture.size == (1600, 1200)
        assert len(set(picture.convert("L").resize((40, 30)).tobytes())) > 20


def test_show_gives_text_and_parts(agent: Agent, tiny: str) -> None:
    written = agent("show", case=tiny, part="text")
    assert written.text == TINY
    assert not written.picture
    body = agent("show", case=tiny, part="box", picture=False)
    assert "place: {above: floor" in body.text
    assert "floor:" not in body.text
    assert "substeps:" in agent("show", case=tiny, part="resolved", picture=False).text
    wrong = agent("show", case=tiny, part="boxx", picture=False)
    assert wrong.failed
    assert "did you mean `box`" in wrong.document["error"]


def test_new_writes_a_start_and_copies(agent: Agent, tiny: str) -> None:
    reply = agent("new", case="fresh")
    assert reply.document["file"] == "cases/fresh/case.yaml"
    assert agent("check", case="fresh").document["ok"] is True
    assert agent("new", case="fresh").failed
    assert agent("new", case="copy_of_tiny", template=tiny).document["ok"]
    assert "name: copy_of_tiny" in (agent.root / "cases/copy_of_tiny/case.yaml").read_text("utf-8")


def test_write_refuses_invalid_cases(agent: Agent) -> None:
    reply = agent("write", case="unwritten", text=TINY.replace("kind: rigid", "kind: rigd"))
    assert reply.failed
    assert reply.document["written"] is False
    assert reply.document["problems"][0]["at"].startswith("cases/unwritten/case.yaml:13:")
    assert not (agent.root / "cases/unwritten").exists()


def test_write_loses_nobodys_change(agent: Agent) -> None:
    first = agent("write", case="mine", text=TINY).document
    assert first["written"] is True
    file = agent.root / "cases/mine/case.yaml"
    assert agent("write", case="mine", text=TINY + "# 2\n").failed
    file.write_text(TINY + "# somebody else\n", "utf-8")
    stale = agent("write", case="mine", text=TINY + "# 2\n", replaces=first["digest"])
    assert stale.failed
    assert file.read_text("utf-8") == TINY + "# somebody else\n"
    agent("write", case="mine", text=TINY + "# 2\n", replaces=stale.document["digest"])
    assert file.read_text("utf-8") == TINY + "# 2\n"


def test_patch_changes_and_keeps_comments(agent: Agent, tiny: str) -> None:
    operation = {"op": "replace", "path": "/bodies/box/material/density", "value": 800}
    dry = agent("patch", case=tiny, operations=[operation], dry_run=True).document
    assert dry["written"] is False
    reply = agent("patch", case=tiny, operations=[operation], owner="bodies").document
    text = (agent.root / tiny / "case.yaml").read_text("utf-8")
    assert text == TINY.replace("density: 500", "density: 800")
    assert reply["undo"] == [operation | {"value": 500}]
    assert agent("patch", case=tiny, operations=reply["undo"], replaces=reply["digest"]).document["ok"]
    assert (agent.root / tiny / "case.yaml").read_text("utf-8") == TINY


@pytest.mark.parametrize(
    ("operations", "owner", "said"),
    [
        ([{"op": "replace", "path": "/scene/dt", "value": 0.001}], "bodies", "is outside /bodies, the only section"),
        ([{"op": "replace", "path": "/bodies/bxo/kind", "value": "soft"}], "", "there is no `bxo`"),
        ([{"op": "test", "path": "/name", "value": "other"}], "", "operation 1"),
        ([{"op": "add", "path": "/scene/dt", "value": "x"}], "", "is not changed"),
        ([{"op": "evil", "path": "/scene/dt"}], "", "op"),
    ],
)
def test_patch_that_is_refused_changes_nothing(
    agent: Agent, tiny: str, operations: list[dict[str, object]], owner: str, said: str
) -> None:
    fine = {"op": "replace", "path": "/bodies/box/material/density", "value": 800}
    both = [fine, *operations] if not owner else operations
    reply = agent("patch", case=tiny, operations=both, owner=owner)
    assert reply.failed
    assert said.replace("operation 1", f"operation {len(both)}") in reply.document["error"]
    assert (agent.root / tiny / "case.yaml").read_text("utf-8") == TINY


def test_patch_names_the_operation_to_blame(agent: Agent, tiny: str) -> None:
    operations = [
        {"op": "replace", "path": "/bodies/box/material/density", "value": 800},
        {"op": "replace", "path": "/scene/dt", "value": -1},
    ]
    problem = agent("patch", case=tiny, operations=operations).document["problems"][0]
    assert problem["operation"] == 1
    assert problem["path"] == "/scene/dt"


def test_language_has_pages_rules_and_prefabs(agent: Agent) -> None:
    index = agent("language").text
    assert "running_bond" in index
    assert "tunnelling" in index
    assert len(index) < 5_000
    box = agent("language", topic="shapes/box")
    assert box.text.startswith("### `box`")
    assert "Full lengths [m]" in box.text
    several = {"shapes/box", "shapes of cloth/box", "regions of space/box"}
    assert set(agent("language", topic="box").document["several"]) == several
    assert "Remedy: Use more `scene.substeps`" in agent("language", topic="tunnelling").text
    assert "use: table" in agent("language", topic="table").text
    wrong = agent("language", topic="artikulated")
    assert wrong.failed
    assert "did you mean `articulated`" in wrong.document["error"]


def test_no_page_of_the_language_is_long(agent: Agent) -> None:
    topics = ["bodies", "shapes", "actions", "controls", "measures", "poses and places", "render", "reuse: prefabs"]
    assert all(len(agent("language", topic=topic).text) <= 9_000 for topic in topics)
    assert "pages_below" in agent("language", topic="actions").document


def test_cards_by_id_and_by_words(agent: Agent) -> None:
    assert any(line.startswith("seen-in-a-test: A thin floor") for line in agent("cards").document["cards"])
    card = agent("cards", query="seen-in-a-test")
    assert "Give the scene more substeps." in card.text
    found = agent("cards", query="fast ball falls through a thin floor")
    assert "seen-in-a-test" in found.document["cards"]
    assert len(found.document["cards"]) <= 5
