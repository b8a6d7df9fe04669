"""Questions, answers, and what is done with answers that cannot be used."""

import os
from pathlib import Path
from time import perf_counter
from typing import Any

import pytest

from tests.agents.scripted import Scripted, chat, fenced
from text2sim.agents import kind_words, language
from text2sim.agents.cinematography import Marks
from text2sim.agents.conversation import BudgetSpent, RoleFailed, Wrong, apply_merge_patch, typed_parser
from text2sim.agents.journal import Journal
from text2sim.agents.judgement import Critique
from text2sim.agents.models.calls import Account, Budget
from text2sim.agents.models.exchange import Message, ModelRequest, Reply
from text2sim.agents.models.mailbox import Mailbox
from text2sim.agents.models.tokens import PromptPrefixes, common_prefix_length
from text2sim.agents.page_requests import PageRequests
from text2sim.agents.replies import CasePlan


def number(data: Any) -> int:
    if not isinstance(data, dict) or not isinstance(data.get("n"), int):
        raise Wrong(["/n: has to be a whole number"])
    return data["n"]


def test_what_is_wrong_goes_back_and_the_next_answer_counts(tmp_path: Path) -> None:
    model = Scripted({"critic": [fenced("n: [1,"), fenced("n: three"), fenced("n: 3")]})
    assert chat(tmp_path, model).ask("critic", "You count.", "How many?", number) == 3
    third = model.asked[-1].messages
    assert [message.role for message in third] == ["system", "user", "assistant", "user", "assistant", "user"]
    assert "/n: has to be a whole number" in third[-1].text


def test_a_long_answer_is_mended_by_what_changes(tmp_path: Path) -> None:
    long = f"n: three\nkept: {'x' * 2_500}\ninner: {{old: 1, stays: 2}}"
    model = Scripted({"critic": [fenced(long), fenced("changes: {n: 3, inner: {old: null, new: [4]}}")]})
    seen: list[Any] = []
    assert chat(tmp_path, model).ask("critic", "s", "q", lambda data: seen.append(data) or number(data)) == 3
    assert "`changes`" in model.asked[-1].messages[-1].text
    assert seen[-1] == {"n": 3, "kept": "x" * 2_500, "inner": {"stays": 2, "new": [4]}}


def test_changes_may_leave_out_the_one_key_of_an_answer(tmp_path: Path) -> None:
    long = f"render: {{n: three, kept: {'x' * 2_500}}}"
    model = Scripted({"critic": [fenced(long), fenced("changes: {n: 3}")]})
    assert chat(tmp_path, model).ask("critic", "s", "q", lambda data: number(data["render"])) == 3


def test_a_rewritten_expectation_keeps_nothing_of_the_old_one() -> None:
    old = {"checks": {"expect": {"lifts": {"measure": "rise", "on": "struck", "at": 1, "above": 0.1}, "rests": 1}}}
    whole = {"checks": {"expect": {"lifts": {"measure": "rise", "during": [2, 3], "above": 0.1}}}}
    bound = {"checks": {"expect": {"lifts": {"above": 0.2}}}}
    made = apply_merge_patch(old, whole)["checks"]["expect"]
    assert made == {"lifts": {"measure": "rise", "during": [2, 3], "above": 0.1}, "rests": 1}
    assert apply_merge_patch(old, bound)["checks"]["expect"]["lifts"]["on"] == "struck"


def test_changes_of_an_answer_that_cannot_be_read_are_no_answer(tmp_path: Path) -> None:
    model = Scripted({"critic": [fenced("n: [1," + "x" * 2_500), fenced("changes: {n: 3}"), fenced("n: 5")]})
    assert chat(tmp_path, model).ask("critic", "s", "q", number) == 5


def test_a_role_that_never_answers_well_has_failed(tmp_path: Path) -> None:
    model = Scripted({"critic": ["No.", fenced("n: x"), fenced("- 1")]})
    with pytest.raises(RoleFailed, match="critic gave no usable answer"):
        chat(tmp_path, model).ask("critic", "You count.", "How many?", number)


@pytest.mark.parametrize(
    "hostile",
    [
        "x" * 1_100_000,
        fenced("n: !!python/object/apply:os.system ['touch pwned']"),
        fenced("a0: &a0 [1]\n" + "".join(f"a{k + 1}: &a{k + 1} [{f'*a{k}, ' * 9}]\n" for k in range(9)) + "n: 3"),
        "```python\nimport os; os.system('touch pwned')\n```",
        fenced("{" * 80 + "}" * 80),
    ],
    ids=["long", "tag", "alias", "code", "deep"],
)
def test_hostile_answers_are_data_and_refused(tmp_path: Path, hostile: str) -> None:
    model = Scripted({"critic": [hostile, fenced("n: 1")]})
    assert chat(tmp_path, model).ask("critic", "s", "q", number) == 1
    assert not list(tmp_path.rglob("pwned"))


def test_finished_calls_are_not_made_again(tmp_path: Path) -> None:
    first = Scripted({"critic": [fenced("n: 7")]})
    assert chat(tmp_path, first).ask("critic", "s", "q", number) == 7
    second = Scripted({})
    again = chat(tmp_path, second)
    assert again.ask("critic", "s", "q", number) == 7
    assert second.asked == []
    assert again.account.total().tokens > 0, "what was spent before still counts"


def test_nothing_is_asked_when_the_budget_is_spent(tmp_path: Path) -> None:
    model = Scripted({"critic": [fenced("n: 7"), fenced("n: 8")]})
    bounded = chat(tmp_path, model, Budget(tokens=1))
    bounded.ask("critic", "s", "q", number)
    with pytest.raises(BudgetSpent, match="tokens are spent"):
        bounded.ask("critic", "s", "another", number)
    assert len(model.asked) == 1


def test_a_last_question_may_be_asked_in_overtime(tmp_path: Path) -> None:
    late = chat(tmp_path, Scripted({"critic": [fenced("n: 7")]}), Budget(minutes=10, minutes_before=12))
    with late.overtime(5):
        assert late.ask("critic", "s", "q", number) == 7
    with pytest.raises(BudgetSpent, match="10 minutes are over"):
        late.ask("critic", "s", "another", number)


def test_a_wait_for_a_reply_ends_with_the_time(tmp_path: Path) -> None:
    box = Mailbox(tmp_path / "box")
    late = chat(tmp_path, box, Budget(minutes=10, minutes_before=10 - 0.5 / 60))
    start = perf_counter()
    with pytest.raises(BudgetSpent, match="10 minutes are over, and no reply to critic-01 came within 0.* s"):
        late.ask("critic", "s", "q", number)
    assert 0.4 < perf_counter() - start < 5.0
    late.close("Not accepted.")
    assert {path.name for path in (tmp_path / "box").iterdir()} == {"critic-01.request.md", "finished.md"}
    with late.overtime(0.5 / 60), pytest.raises(BudgetSpent):
        late.ask("critic", "s", "q", number)
    assert not (tmp_path / "box" / "finished.md").exists(), "somebody has to answer again"


def test_types_say_what_is_wrong_with_an_answer() -> None:
    with pytest.raises(Wrong) as caught:
        typed_parser(Critique)({"seen": "x", "score": 140, "verdict": "fine"})
    said = " ".join(caught.value.reasons)
    assert "/score" in said
    assert "/verdict" in said


def test_pages_come_as_a_message_of_their_own_after_what_was_said(tmp_path: Path) -> None:
    model = Scripted(
        {"planner": [fenced("read: [plate, hinge, plate]"), fenced("read: [hinge, nothing]"), fenced("n: 3")]}
    )
    asked = chat(tmp_path, model)
    assert asked.ask("planner", "s", "q", number, read_pages=PageRequests()) == 3
    first, second, third = (request.messages for request in model.asked)
    assert second[: len(first)] == first
    assert third[: len(second)] == second
    assert "range_deg" in second[-1].text, "a kind comes with its fields"
    assert "diameter" in second[-1].text, "a prefab with its parameters"
    assert second[-1].text.count("range_deg") < 3
    assert "range_deg" not in third[-1].text, "once"
    assert "nothing called `nothing`" in third[-1].text
    assert asked.account.total().again == 0, "a short beginning is in no cache"


def test_pages_are_served_twice(tmp_path: Path) -> None:
    reads = [fenced(f"read: [{name}]") for name in ("net", "hinge", "line")]
    model = Scripted({"planner": [*reads, fenced("n: 3")]})
    asked = chat(tmp_path, model)
    assert asked.ask("planner", "s", "q", number, read_pages=PageRequests()) == 3
    assert "No more pages" not in model.asked[1].messages[-1].text
    assert "No more pages" in model.asked[2].messages[-1].text
    assert "/read: pages are served 2 times, and have been" in model.asked[3].messages[-1].text


def test_a_long_list_of_pages_is_served_as_far_as_it_goes() -> None:
    text, served = language.explanations(sorted(kind_words.known_kinds()))
    assert len(text) < 1.3 * language.MAX_PAGES_SIZE
    assert 5 < len(served) < len(kind_words.known_kinds())
    assert "No room for" in text


def test_what_a_prompt_cache_can_serve_is_counted_apart() -> None:
    def put(*texts: str) -> ModelRequest:
        return ModelRequest("critic", tuple(Message("user", text) for text in texts))

    sent = PromptPrefixes()
    long = "Rules of a game. " * 1000
    assert sent.cached_tokens("m", put(long, "q")) == 0
    again = sent.cached_tokens("m", put(long, "another q", "more"))
    assert again > 1_024
    assert again % 128 == 0
    assert sent.cached_tokens("other model", put(long, "q")) == 0
    assert sent.cached_tokens("m", put("other " + long)) == 0, "another beginning"
    account = Account()
    account.add("critic", 1, Reply("", 5_000, 10, None, 0.0, "m"), again)
    assert account.as_dict()["total"]["again"] == again
    assert account.total().tokens == 5_010, "they are counted among the others, too"


def test_beginnings_are_compared_in_blocks() -> None:
    """Letter by letter, Python needs some 0.1 s for two texts of 100,000 characters."""
    for one, other in (("", "a"), ("abc", "abc"), ("abc", "abd"), ("abcd", "ab"), ("xbc", "abc")):
        assert common_prefix_length(one, other) == len(os.path.commonprefix([one, other]))
    one, started = "a" * 3_000_000, perf_counter()
    assert common_prefix_length(one + "b", one + "c") == len(one)
    assert perf_counter() - started < 0.1


def test_a_journal_keeps_each_thing_once(tmp_path: Path) -> None:
    file = tmp_path / "journal.jsonl"
    for _ in range(2):
        journal = Journal(file)
        journal("planned", what="a")
        journal("asked", live=True, role="critic")
        journal("planned", what="a")
        journal("planned", what="a line\u2028separator")
    assert file.read_text("utf-8").count("\n") == 3
    file.write_text(file.read_text("utf-8") + '{"event": "hal', "utf-8")
    Journal(file)("planned", what="b")
    assert [line for line in file.read_text("utf-8").splitlines() if "hal" in line] == []


def test_what_is_meant_is_taken_where_only_the_form_is_off() -> None:
    plan = typed_parser(CasePlan)(
        {
            "name": "a", "event": "b", "assumptions": "one thing", "why": None, "assets": {"crane": {"kind": "mechanism", "what": "x"}},
        }
    )  # fmt: skip
    assert plan.assumptions == ["one thing"]
    marks = {"seen": ["A ball.", "It rolls."], "content": 1, "clarity": 2, "polish": 3, "appeal": 4}
    assert Marks.model_validate(marks).seen == "A ball. It rolls."
    broken = [{4: "the pole is cut off"}, {"in the middle": "it stands at the left"}, "from above"]  # lines with colons
    broken.append({"the left one": None})
    rows = ["4: the pole is cut off", "in the middle: it stands at the left", "from above", "the left one:"]
    assert Marks.model_validate(marks | {"broken": broken}).broken == rows
    assert plan.assets[0].body == "crane"
