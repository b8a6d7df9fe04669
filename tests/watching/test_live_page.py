"""The page of a watched case in a real browser, without the engine."""

from pathlib import Path

import chromium
import pytest

from text2sim.watching.server import PageServer

SOFTWARE = "--use-angle=swiftshader --enable-unsafe-swiftshader"


@pytest.mark.usefixtures("browser")
@pytest.mark.skipif(chromium.find() is None, reason="there is no Chromium")
def test_the_page_follows_saves(watch, tmp_path: Path) -> None:
    watched = watch()
    server = PageServer(watched.state)
    page = chromium.Chromium(tmp_path / "profile", SOFTWARE)
    try:
        watched.wait("done", timeout=60)
        page.go(server.url)
        page.wait("window.replay && replay.drawn > 0", timeout=60)
        assert page.ask("document.getElementById('trouble').textContent") == ""
        assert page.ask("document.getElementById('status').className") == "verdict good"
        assert page.ask("replay.stage.bodies") == ["ball"]
        assert page.ask("document.getElementById('camera').value") == "0", "as the film shows it"
        page.ask("replay.pause(), replay.seek(0.3)")
        said = len(watched.said)
        watched.save(("below: 1.2", "below: -1"))
        watched.wait("done", said, timeout=60)
        page.wait("document.querySelectorAll('#expect li.bad').length == 1")
        assert page.ask("replay.time") == pytest.approx(0.3), "the same moment"
        assert page.ask("replay.playing") is not True
        watched.save(("kind: sphere", "kind: shpere"))
        page.wait("document.querySelectorAll('#problems li.error').length == 1", timeout=60)
        assert "did you mean `sphere`?" in page.ask("document.getElementById('problems').textContent")
    finally:
        page.close()
        server.close()
