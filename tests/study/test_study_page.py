"""The page of a study: its states, its access, and the anonymity of methods."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient
from study.conftest import COLOURS

from text2sim.study.build import QUESTIONS, Study
from text2sim.study.server import StudyPage

HOST = "127.0.0.1:8765"
ALL = dict.fromkeys(QUESTIONS, "1")


class Visitor:
    """A browser of its own."""

    def __init__(self, page: StudyPage) -> None:
        self.client = TestClient(page.app, f"http://{HOST}", follow_redirects=False)
        self.home = f"/{page.answers.token}/"

    def get(self, path: str = "", **headers: str):
        return self.client.get(self.home + path, headers=headers)

    def send(self, **form: str):
        return self.client.post(self.home, data=form)

    def begin(self) -> "Visitor":
        assert self.send(agree="yes").status_code == 303
        return self


@pytest.fixture
def page(study: tuple[Path, Study]) -> Iterator[StudyPage]:
    made = StudyPage(study[0], frozenset({HOST}))
    yield made
    made.answers.close()


def test_from_consent_to_the_end(page: StudyPage, study: tuple[Path, Study]) -> None:
    visitor = Visitor(page)
    assert "I agree" in visitor.get().text
    assert visitor.send(number="0", **ALL).status_code == 303, "nobody answers who has not agreed"
    assert page.answers.all() == []
    cookie = visitor.begin().client.cookies.jar
    assert [(one.name, one.has_nonstandard_attr("HttpOnly")) for one in cookie] == [("person", True)]
    trials = study[1].assignments[0]
    for number, trial in enumerate(trials):
        text = visitor.get().text
        assert f"Pair {number + 1} of {len(trials)}" in text
        assert f"Ball {trial.task[-1]} &lt;b&gt;falls&lt;/b&gt; &amp; bounces." in text
        assert visitor.send(number=str(number), **{**ALL, "physics": "none"}).status_code == 303
    visitor.send(number=str(len(trials)), **ALL)
    assert "Thank you" in visitor.get().text
    rows = page.answers.all()
    assert len(rows) == len(trials) * len(QUESTIONS)
    assert {row.level for row in rows if row.question == "physics"} == {None}
    assert {row.level for row in rows if row.question != "physics"} == {1}


def test_it_goes_on_where_it_was_also_after_a_restart(page: StudyPage, study: tuple[Path, Study]) -> None:
    visitor = Visitor(page).begin()
    visitor.send(number="0", **ALL)
    visitor.send(number="0", **dict.fromkeys(QUESTIONS, "-2"))  # sent twice
    again = StudyPage(study[0], frozenset({HOST}))
    assert again.answers.token == page.answers.token
    later = Visitor(again)
    later.client.cookies = visitor.client.cookies
    assert "Pair 2 of" in later.get().text
    assert {row.level for row in again.answers.all()} == {1}
    again.answers.close()


def test_every_question_wants_an_answer_that_exists(page: StudyPage) -> None:
    visitor = Visitor(page).begin()
    for form in ({}, {**ALL, "physics": "3"}, {**ALL, "physics": ""}):
        answer = visitor.send(number="0", **form)
        assert (answer.status_code, "Please answer every question" in answer.text) == (422, True)
    assert page.answers.all() == []
    huge = visitor.client.post(visitor.home, data={"number": "0", "physics": "1" * 20_000})
    assert huge.status_code == 413


def test_nothing_reveals_the_method_of_a_film(page: StudyPage, study: tuple[Path, Study]) -> None:
    seen = ""
    for _ in study[1].assignments:
        visitor = Visitor(page)
        seen += str(visitor.get().headers) + visitor.get().text
        visitor.begin()
        for number in range(10):
            text = visitor.get().text
            seen += text
            for film in re.findall(r'<video src="([^"]+)"', text):
                assert film in (f"film/{number}/a", f"film/{number}/b")
                answer = visitor.get(film)
                seen += film + str(answer.headers) + answer.content.decode("latin-1")
                assert visitor.get(film, Range="bytes=0-9").status_code == 206
                assert answer.headers["Last-Modified"] == "Thu, 01 Jan 1970 00:00:00 GMT"
            visitor.send(number=str(number), **ALL)
    assert len(page.answers.all()) == 24 * len(QUESTIONS)
    assert not [word for word in (*COLOURS, "text2sim", "anchor", "task_", str(study[0])) if word in seen]
    assert "All comparisons of this study have been made" in Visitor(page).send(agree="yes").text


def test_films_of_others_and_other_files_cannot_be_had(page: StudyPage) -> None:
    assert Visitor(page).get("film/0/a").status_code == 404
    visitor = Visitor(page).begin()
    assert visitor.get("film/0/a").status_code == 200
    for path in ("film/99/a", "film/-1/a", "film/0/c", "study.json", "films/0.mp4", "film/0/..%2f..%2fstudy.json"):
        assert visitor.get(path).status_code == 404


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1"},
        {"Origin": "http://evil.example"},
        {"Sec-Fetch-Site": "same-site"},
    ],
    ids=str,
)
def test_nothing_for_other_sites(page: StudyPage, headers: dict[str, str]) -> None:
    assert Visitor(page).get(**headers).status_code == 404
    assert Visitor(page).client.get("/wrong/").status_code == 404
    assert Visitor(page).client.get("/").status_code == 404


def test_no_script_but_ours_can_run(page: StudyPage) -> None:
    visitor = Visitor(page).begin()
    answer = visitor.get()
    nonce = re.search(r"script-src 'nonce-([^']+)'", answer.headers["Content-Security-Policy"])
    assert nonce
    assert answer.text.count(f'nonce="{nonce[1]}"') == 2
    assert nonce[1] not in visitor.get().text
    assert not re.search(r"(?i)https?://|@import|url\(| on\w+=|innerHTML", answer.text)
