"""Cameras of a film over time, for other programs and for the replay."""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from exchange.recorded import FILM, write_run
from text2sim.exchange.viewing import camera_tracks
from text2sim.recording.film_record import read_recording


def test_a_camera_that_only_rolls_does_not_stand_still(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", cloth=False, grains=False)
    # The lower arm turns about y at 2 rad/s where it stands, and the camera looks along y.
    camera = {"kind": "mounted", "body": "arm", "link": "lower", "fov": 50.0, "pos": (0, 0, 0), "look_at": (0, 1, 0),
              "up": (0, 0, 1)}  # fmt: skip
    program = folder / "program" / "render.py"
    program.write_text(program.read_text().replace(repr(FILM["cameras"]), repr({"wrist": camera})))
    track = camera_tracks(read_recording(folder))["wrist"]
    np.testing.assert_allclose(track.times, [0.0, 0.04], atol=1e-9)
    turns = Rotation.from_rotvec(np.outer(2 * track.times, [0, 1, 0]))
    pos, quat = track.poses()
    np.testing.assert_allclose(pos, [[0, 0.5, 0.1]] * 2, atol=1e-6)
    axes = Rotation.from_quat(quat[:, [1, 2, 3, 0]])
    np.testing.assert_allclose(axes.apply([0, 0, -1]), [[0, 1, 0]] * 2, atol=1e-6)
    np.testing.assert_allclose(axes.apply([0, 1, 0]), turns.apply([0, 0, 1]), atol=1e-6)
