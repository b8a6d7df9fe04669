"""A study in a real browser, through the command: mouse and keys, resumption, a narrow screen."""

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from watching import chromium

from text2sim.study.answers import Answers
from text2sim.study.build import QUESTIONS, Study

pytestmark = [
    pytest.mark.usefixtures("browser"),
    pytest.mark.skipif(chromium.find() is None, reason="there is no Chromium"),
]
BOTH = "[...document.querySelectorAll('.films video')]"


@pytest.fixture
def address(study: tuple[Path, Study]) -> Iterator[str]:
    command = [sys.executable, "-m", "text2sim", "study", "serve", str(study[0]), "--port", "0"]
    served = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert served.stdout is not None
    yield served.stdout.readline().split()[-1]
    served.terminate()
    served.wait(20)


def key(page: chromium.Chromium, name: str) -> None:
    text = "\r" if name == "Enter" else name
    page.call("Input.dispatchKeyEvent", type="keyDown", key=name, text=text, windowsVirtualKeyCode=ord(text.upper()))
    page.call("Input.dispatchKeyEvent", type="keyUp", key=name)


def test_a_study_from_consent_to_the_end(study: tuple[Path, Study], address: str, tmp_path: Path) -> None:
    folder, made = study
    count = len(made.assignments[0])
    page = chromium.Chromium(tmp_path / "profile")
    try:
        page.go(address)
        page.wait("document.querySelector('.consent') != null")
        page.shoot(tmp_path / "consent.png")
        page.ask("document.querySelector('button').click()")
        page.wait("document.documentElement?.dataset.ready")
        assert page.ask(f"{BOTH}.every((film) => film.videoWidth == 64 && !film.error)")
        page.wait(f"{BOTH}.every((film) => film.ended)")
        page.wait("document.querySelectorAll('video[hidden]').length == 2")
        page.wait("[...document.querySelectorAll('video[hidden]')].every((film) => film.readyState == 4)")
        assert page.ask("[...document.querySelectorAll('video[hidden]')].every((film) => !film.offsetParent)")
        page.shoot(tmp_path / "trial.png")
        page.ask(f"window.plays = 0; {BOTH}.forEach((film) => film.addEventListener('play', () => plays++))")
        key(page, "p")
        page.wait("plays >= 2")
        page.ask("document.querySelector('form').requestSubmit()")
        assert "Pair 1 of" in page.ask("document.body.innerText"), "not without answers"
        for name in "1503":
            key(page, name)
        assert page.ask("[...document.querySelectorAll(':checked')].map((one) => one.value)") == [
            "-2",
            "2",
            "none",
            "0",
        ]
        key(page, "Enter")
        page.wait("document.querySelector('h1')?.textContent.startsWith('Pair 2 of')")
        kept = "performance.getEntriesByType('resource').filter((one) => /film.1/.test(one.name) && !one.transferSize)"
        page.wait(f"{kept}.length == 2")  # both were there before they were asked for
        page.leave()
    finally:
        page.close()
    page = chromium.Chromium(tmp_path / "profile")
    try:
        page.call("Emulation.setDeviceMetricsOverride", width=360, height=740, deviceScaleFactor=2, mobile=True)
        page.go(address)
        page.wait("document.querySelector('h1')?.textContent.startsWith('Pair 2 of')")
        assert page.ask("document.documentElement.scrollWidth") == 360, "nothing is wider than a phone"
        tops = page.ask(f"{BOTH}.map((film) => film.getBoundingClientRect().top)")
        assert tops[1] > tops[0] + 100, "one film below the other"
        page.wait("document.documentElement?.dataset.ready")
        page.shoot(tmp_path / "phone.png")
        for number in range(1, count):
            page.wait(f"document.querySelector('h1')?.textContent.startsWith('Pair {number + 1} of')")
            page.ask("document.querySelectorAll('input[value=\"1\"]').forEach((one) => one.click())")
            page.ask("document.querySelector('form').requestSubmit()")
        page.wait("document.querySelector('h1')?.textContent == 'Thank you'")
        assert not re.search("_system|task_", page.ask("document.documentElement.outerHTML"))
    finally:
        page.close()
    answers = Answers(folder, made)
    first = {row.question: row.level for row in answers.all() if row.trial == 0}
    assert first == dict(zip(QUESTIONS, (-2, 2, None, 0), strict=True))
    assert len(answers.all()) == count * len(QUESTIONS)
    answers.close()
