"""Writer of items with driven joints in the layout of LeRobot 3.0, one folder per case, split and rate.

An item is an episode. Its state has the positions and velocities of the joints that motors drive, its action the
forces of the motors, both at the times of the pictures. `timestamp` counts seconds of film, as LeRobot requires;
`simulated_time` differs from it where a film is slow or cut.
Format: https://huggingface.co/docs/lerobot/lerobot-dataset-v3
"""

import json
import shutil
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from text2sim.dataset.item import Item
from text2sim.spec_schema.whole_files import write_atomically

VIDEO = "observation.images.film"
DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
FILM = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
KEY = "text2sim/key"
"""Column of the episodes with the key of the item."""
CHUNK = 1000
"""Files per folder."""
NUMBERS = ("timestamp", "simulated_time", "frame_index", "episode_index", "index", "task_index")


def _driven(item: Item) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Rows of the layout for hinges and sliders that motors acted on, and the recorded arrays of joints."""
    layout = json.loads((item.folder / "layout.json").read_text("utf-8"))
    with np.load(item.folder / "states.npz") as arrays:
        states = {name: arrays[name] for name in ("time", "qpos", "dofs_velocity", "dofs_force")}
    joints = [joint for joint in layout["joints"] if joint["kind"] in ("hinge", "slider")]
    return [joint for joint in joints if np.any(states["dofs_force"][:, joint["dofs"][0]])], states


class RobotForm(NamedTuple):
    """Properties that all episodes of a LeRobot dataset share."""

    joints: tuple[str, ...]
    """Driven joints."""
    fps: float
    """Frame rate of the film [1/s]."""
    width: int
    height: int
    """Size of the film [pixels]."""


def robot_form(item: Item) -> RobotForm | None:
    """Return the form of an item; None if no motor drives a hinge or a slider."""
    joints, row = _driven(item)[0], item.row
    names = tuple(f"{joint['body']}.{joint['joint']}" for joint in joints)
    return RobotForm(names, round(row["fps"], 6), row["width"], row["height"]) if names else None


class RobotWriter:
    """Writes the episodes of one LeRobot dataset."""

    def __init__(self, folder: Path, form: RobotForm):
        self._folder = folder
        self._form = form
        self._episodes: list[dict[str, Any]] = []
        self._tasks: dict[str, int] = {}
        self._sums: dict[str, list[Any]] = {}
        self._count = 0

    def add(self, item: Item) -> None:
        """Add an item of this form."""
        joints, arrays = _driven(item)
        time, moments = arrays["time"], [frame["time"] for frame in item.frames]
        frames = np.searchsorted(time, np.array(moments) - 1e-9).clip(0, len(time) - 1)
        q, d = [joint["q"][0] for joint in joints], [joint["dofs"][0] for joint in joints]
        state = np.concatenate([arrays["qpos"][np.ix_(frames, q)], arrays["dofs_velocity"][np.ix_(frames, d)]], axis=1)
        action = arrays["dofs_force"][np.ix_(frames, d)]
        self._write(item.row, item.folder / "film.mp4", state.astype(np.float32), action.astype(np.float32), moments)

    def _write(self, row: dict[str, Any], film: Path, state: Any, action: Any, moments: list[float]) -> None:
        number, length = len(self._episodes), len(state)
        task = self._tasks.setdefault(row["prompt"] or row["case"], len(self._tasks))
        steps = np.arange(length)
        place = {"chunk_index": number // CHUNK, "file_index": number % CHUNK}
        path = self._folder / DATA.format(**place)
        path.parent.mkdir(parents=True, exist_ok=True)
        table = {
            "observation.state": _column(state),
            "action": _column(action),
            "timestamp": pa.array((steps / row["fps"]).astype(np.float32)),
            "simulated_time": pa.array(moments, pa.float32()),
            "frame_index": pa.array(steps),
            "episode_index": pa.array(np.full(length, number)),
            "index": pa.array(steps + self._count),
            "task_index": pa.array(np.full(length, task)),
        }
        pq.write_table(pa.table(table), path)
        video = self._folder / FILM.format(video_key=VIDEO, **place)
        video.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(film, video)
        self._episodes.append(
            {
                "episode_index": number,
                "tasks": [row["prompt"] or row["case"]],
                "length": length,
                "dataset_from_index": self._count,
                "dataset_to_index": self._count + length,
                **{f"data/{key}": value for key, value in place.items()},
                **{f"videos/{VIDEO}/{key}": value for key, value in place.items()},
                f"videos/{VIDEO}/from_timestamp": 0.0,
                f"videos/{VIDEO}/to_timestamp": length / row["fps"],
                "meta/episodes/chunk_index": 0,
                "meta/episodes/file_index": 0,
                KEY: row["key"],
            }
        )
        for name, rows in (("observation.state", state), ("action", action)):
            some = rows.astype(float)
            now = [length, some.sum(axis=0), (some**2).sum(axis=0), some.min(axis=0), some.max(axis=0)]
            if name in self._sums:
                n, total, squares, low, high = self._sums[name]
                now = [n + length, total + now[1], squares + now[2], np.minimum(low, now[3]), np.maximum(high, now[4])]
            self._sums[name] = now
        self._count += length

    def close(self) -> None:
        """Write the metadata."""
        import pandas  # `datasets` brings it

        names, fps, width, height = self._form
        meta = self._folder / "meta"
        (meta / "episodes" / "chunk-000").mkdir(parents=True)
        pq.write_table(pa.Table.from_pylist(self._episodes), meta / "episodes" / "chunk-000" / "file-000.parquet")
        tasks = pandas.DataFrame({"task_index": list(self._tasks.values())}, index=list(self._tasks))
        tasks.to_parquet(meta / "tasks.parquet")
        states = [*(f"{name}.position" for name in names), *(f"{name}.velocity" for name in names)]
        video = {"video.height": height, "video.width": width, "video.codec": "h264", "video.pix_fmt": "yuv420p",
                 "video.is_depth_map": False, "video.fps": fps, "video.channels": 3, "has_audio": False}  # fmt: skip
        numbers = {
            name: {"dtype": "float32" if name in NUMBERS[:2] else "int64", "shape": [1], "names": None}
            for name in NUMBERS
        }
        features = {
            "observation.state": {"dtype": "float32", "shape": [len(states)], "names": states},
            "action": {"dtype": "float32", "shape": [len(names)], "names": [f"{name}.force" for name in names]},
            VIDEO: {
                "dtype": "video",
                "shape": [height, width, 3],
                "names": ["height", "width", "channels"],
                "info": video,
            },
        }
        info = {
            "codebase_version": "v3.0", "robot_type": "text2sim", "total_episodes": len(self._episodes),
            "total_frames": self._count, "total_tasks": len(self._tasks), "chunks_size": CHUNK,
            "data_files_size_in_mb": 100, "video_files_size_in_mb": 500, "fps": fps,
            "splits": {"train": f"0:{len(self._episodes)}"}, "data_path": DATA, "video_path": FILM,
            "features": features | numbers,
        }  # fmt: skip
        write_atomically(meta / "info.json", json.dumps(info, indent=1) + "\n")
        stats = {
            name: {"min": low.tolist(), "max": high.tolist(), "mean": (total / n).tolist(),
                   "std": np.sqrt(np.maximum(squares / n - (total / n) ** 2, 0)).tolist(), "count": [n]}
            for name, (n, total, squares, low, high) in self._sums.items()
        }  # fmt: skip
        write_atomically(meta / "stats.json", json.dumps(stats, indent=1) + "\n")


def _column(rows: Any) -> Any:
    """Rows of numbers as an Arrow column; LeRobot stores a single number without a list."""
    wide = rows.shape[1]
    return pa.array(rows.ravel()) if wide == 1 else pa.FixedSizeListArray.from_arrays(pa.array(rows.ravel()), wide)


def episodes_of(folder: Path) -> list[tuple[str, Path]]:
    """Return the item and the film of each episode in a folder that `RobotWriter` wrote."""
    found = []
    for path in sorted((folder / "meta" / "episodes").glob("*/*.parquet")):
        for row in pq.read_table(path).to_pylist():
            place = {key: row[f"videos/{VIDEO}/{key}"] for key in ("chunk_index", "file_index")}
            found.append((row[KEY], folder / FILM.format(video_key=VIDEO, **place)))
    return found
