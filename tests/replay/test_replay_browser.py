"""The replay in a real browser, from a file, with WebGL in software."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from watching import chromium

from replay.conftest import HARM
from text2sim.replay.page import write_replay
from text2sim.spec_schema.models.case import Case

pytestmark = pytest.mark.skipif(chromium.find() is None, reason="there is no Chromium")
SOFTWARE = "--use-angle=swiftshader --enable-unsafe-swiftshader"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[chromium.Chromium]:
    made = chromium.Chromium(tmp_path_factory.mktemp("profile"), SOFTWARE)
    yield made
    made.close()


@pytest.fixture
def page(browser: chromium.Chromium, judged: Path, case: Case) -> chromium.Chromium:
    browser.go(write_replay(judged, case).as_uri())
    browser.wait("window.replay && replay.drawn > 0", timeout=60)
    assert browser.ask("document.getElementById('trouble').textContent") == ""
    return browser


def press(page: chromium.Chromium, key: str, **more: Any) -> None:
    options = "".join(f", {name}: {str(value).lower()}" for name, value in more.items())
    page.ask(f"window.dispatchEvent(Object.assign(new KeyboardEvent('keydown', {{key: '{key}'{options}}})))")


def shot(page: chromium.Chromium, path: Path) -> np.ndarray:
    drawn = page.ask("replay.redraw(), replay.drawn")
    page.wait(f"replay.drawn > {drawn}")
    page.shoot(path)
    return np.asarray(Image.open(path).convert("RGB"), int)


def test_things_are_drawn_and_move(page: chromium.Chromium, tmp_path: Path) -> None:
    before = shot(page, tmp_path / "before.png")
    view = before[60:600, :900]
    assert len(np.unique(view.reshape(-1, 3), axis=0)) > 500, "more than a plain ground"
    page.ask("replay.seek(0.1)")
    after = shot(page, tmp_path / "after.png")
    assert (np.abs(after - before)[60:600, :900].max(axis=2) > 30).sum() > 300


def test_a_click_names_the_body_under_it(page: chromium.Chromium) -> None:
    # A point of the falling box, where the camera of the film sees it.
    page.ask("replay.choose(-1), replay.seek(0)")
    spot = page.ask("""(() => {
        replay.control.look(0);
        replay.stage.camera.updateMatrixWorld();
        const at = new THREE.Vector3(-0.5, 0, 1).project(replay.stage.camera);
        const { clientWidth: w, clientHeight: h } = replay.canvas;
        return [(at.x + 1) / 2 * w, (1 - at.y) / 2 * h];
    })()""")
    assert page.ask(f"replay.pick({spot[0]}, {spot[1]})") == "box[0]"
    page.wait("document.getElementById('chosen').textContent.startsWith('box[0]')")
    assert page.ask("replay.pick(4, 4)") == ""


def test_a_selected_body_shows_its_contacts(page: chromium.Chromium) -> None:
    page.ask("replay.seek(0.04), replay.choose(replay.stage.bodies.indexOf('box[0]'))")
    page.wait("document.getElementById('chosen').textContent.includes('touches floor 9 N')")


def test_names_are_only_text(page: chromium.Chromium) -> None:
    page.ask(f"replay.choose(replay.stage.bodies.indexOf({HARM!r}))")
    page.wait(f"document.getElementById('chosen').textContent.includes({HARM!r})")
    assert page.ask("document.title") == "judged: replay"
    assert page.ask("document.images.length") == 0
    assert page.ask(f"document.getElementById('events').textContent.includes({HARM!r})")


def test_keys(page: chromium.Chromium) -> None:
    page.ask("replay.seek(0)")
    press(page, "ArrowRight")
    assert page.ask("replay.time") == pytest.approx(0.02)
    press(page, "ArrowRight", shiftKey=True)
    assert page.ask("replay.time") == pytest.approx(0.1)
    press(page, "ArrowLeft")
    assert page.ask("replay.time") == pytest.approx(0.08)
    press(page, "Home")
    press(page, "c")
    assert page.ask("document.getElementById('contacts').getAttribute('aria-pressed')") == "false"
    press(page, " ")
    assert page.ask("replay.playing")
    page.wait("!replay.playing && replay.time > 0.0999", timeout=30)


def test_events_and_expectations_are_jumped_to(page: chromium.Chromium) -> None:
    page.ask("document.querySelectorAll('#ticks .tick')[1].click()")
    assert page.ask("replay.time") == pytest.approx(0.08)
    page.ask("document.querySelectorAll('#events li')[0].click()")
    assert page.ask("replay.time") == pytest.approx(0.04)
    assert page.ask("document.querySelector('#expect li').textContent").startswith("✗ falls"), (
        "what was missed is first"
    )
    page.ask("document.querySelector('#expect li').click()")
    assert page.ask("replay.time") == pytest.approx(0.06)


def test_a_plot_shows_the_value_at_the_time(page: chromium.Chromium) -> None:
    page.ask("replay.seek(0.02)")
    page.wait("document.querySelector('.value').textContent === '0.998 m'")


def test_cameras_of_the_film(page: chromium.Chromium) -> None:
    page.ask("document.getElementById('camera').value = '1'")
    page.ask("document.getElementById('camera').dispatchEvent(new Event('change'))")
    page.ask("replay.seek(0)")
    assert page.ask("replay.control.look(0), replay.stage.camera.position.toArray()") == pytest.approx([3, 0, 1.5])
    later = page.ask("replay.control.look(0.08), replay.stage.camera.position.toArray()")
    assert np.hypot(later[0], later[1]) == pytest.approx(3, rel=0.01)
    assert later[1] > 2
    page.ask("replay.control.orbit.dispatchEvent({type: 'start'})")
    assert page.ask("document.getElementById('camera').value") == "free", "a drag goes on from there"


def test_dark_pages_are_dark(page: chromium.Chromium, tmp_path: Path) -> None:
    light = shot(page, tmp_path / "light.png").mean()
    page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    try:
        assert shot(page, tmp_path / "dark.png").mean() < 0.6 * light
    finally:
        page.call("Emulation.setEmulatedMedia", features=[])
