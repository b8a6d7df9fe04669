"""What the Critic sees is what the film will show, where that can be traced in time."""

import numpy as np
import pytest
from filmed import MakeRun

from text2sim.agents import pictures
from text2sim.templates.video import Video

pytestmark = pytest.mark.usefixtures("tracer")


def test_the_sheet_is_path_traced_and_the_preview_stands_in_for_it(
    make_run: MakeRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pictures, "SHEET_WIDTH", 64)
    red = {"half": 0.5, "pos": (0, 0, 0.5), "velocity": (0.5, 0, 0), "color": (0.9, 0.05, 0.05)}
    run = make_run({"crate": red})
    (run / "evidence.json").write_text('{"events": {}, "time": {"reached": 0.4}}')
    video = Video(run / "video.mp4", (64, 36), 10.0)
    for _ in range(4):
        video.write(np.full((36, 64, 3), 255, np.uint8))
    video.close()
    sheet, count, told = pictures.frame_sheet(run)
    first = np.asarray(sheet)[:, 4:68].astype(int)
    assert count == 4
    assert told.startswith("The frames are path-traced")
    assert (first[..., 0] > first[..., 2] + 60).any(), "the crate"
    monkeypatch.setattr(pictures, "MAX_TRACING_TIME", -1.0)
    *kept, last = sorted((run / "render" / "frames").iterdir(), key=lambda file: file.stat().st_mtime_ns)
    last.unlink()
    monkeypatch.setattr(pictures, "FEWEST_TRACED", 3)
    sheet, count, told = pictures.frame_sheet(run)
    assert count == 3
    assert told.startswith("The frames are path-traced")
    for file in kept:
        file.unlink()
    sheet, count, told = pictures.frame_sheet(run)
    assert count == 4
    assert told.startswith("The frames are of the preview")
