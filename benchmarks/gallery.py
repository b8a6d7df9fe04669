"""Pictures of all cases, and the page that shows them: `docs/gallery.md` and `docs/gallery/*.jpg`.

    python benchmarks/gallery.py [CASE …] [--runs runs] [--docs docs] [--size 960x540] [--samples 36] [--page-only]
    text2sim run benchmarks/finishes && python benchmarks/gallery.py finishes
    text2sim run benchmarks/patterns && python benchmarks/gallery.py patterns

Takes the newest judged run of each case, renders the moment that tells what it is about with the case's camera and
light as they are now, and writes the page from what lies there. Cases without a run keep the picture that they have.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from text2sim.compiler.build import plan_case
from text2sim.compiler.plan import Plan
from text2sim.recording.film_record import read_recording
from text2sim.rendering.film import Filming
from text2sim.spec_schema.load import load_case

CASES = Path(__file__).parents[1] / "cases"
FINISHES = Path(__file__).parent / "finishes"
"""A case with a ball of every finish."""
LARGEST = 90_000
"""Of a picture [bytes]: it goes into git."""
MOMENTS = {
    "brick_wall": 0.4,
    "catch_net": 1.1,
    "cloth_dryer": 3.0,
    "conveyor_sorter": 4.5,
    "crank_slider": 2.2,
    "curtains": 4.5,
    "dolphin_squeeze": 1.4,
    "domino_spiral": 2.4,
    "falling_letters": 0.6,
    "kitchen_scale": 3.5,
    "laid_table": 0.6,
    "newton_cradle": 1.0,
    "sand_hourglass": 0.9,
    "scarf_ring": 1.42,
    "shattering_vase": 1.32,
    "snow_plough": 1.4,
    "soft_press": 1.5,
    "spring_train": 1.42,
    "squeeze_through": 0.55,
    "trampoline": 0.46,
    "tumbler": 3.5,
    "wound_cord": 4.2,
    "wrecking_ball": 1.35,
}
"""Simulated time [s] of each picture."""
ELSEWHERE = {"tablecloth_pull": "It needs CUDA, and does not succeed yet: the clamp loses the cloth."}


def main() -> None:
    """Render what was asked for and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--runs", type=Path, default=Path("runs"))
    parser.add_argument("--docs", type=Path, default=Path("docs"))
    parser.add_argument("--size", default="960x540")
    parser.add_argument("--samples", type=int, default=36)
    parser.add_argument("--page-only", action="store_true")
    options = parser.parse_args()
    width, height = (int(n) for n in options.size.split("x"))
    pictures = options.docs / "gallery"
    pictures.mkdir(exist_ok=True)
    for name in () if options.page_only else options.cases or sorted(MOMENTS):
        run = newest_run(options.runs, name)
        if run is None:
            print(f"{name}: no judged run in {options.runs}")
            continue
        image = picture(run, plan_of(name), MOMENTS.get(name, 0.0), (width, height), options.samples)
        save(image, pictures / f"{name}.jpg")
        print(f"{name}: {pictures / name}.jpg")
    kept = options.docs / "gallery.md"
    kept.write_text(page(options.runs, pictures, kept.read_text("utf-8") if kept.is_file() else ""), "utf-8")


def plan_of(name: str) -> Plan:
    """Return the plan of a case as it is now."""
    own = FINISHES.parent / name
    return plan_case(load_case((own if (own / "case.yaml").is_file() else CASES / name) / "case.yaml"))


def newest_run(runs: Path, name: str) -> Path | None:
    """Return the newest run of a case that was judged."""
    judged = [folder for folder in runs.glob(f"{name}-*") if (folder / "evidence.json").is_file()]
    return max(judged, key=lambda folder: folder.stat().st_mtime, default=None)


def picture(run: Path, plan: Plan, t: float, size: tuple[int, int], samples: int) -> Image.Image:
    """Return the picture of the main film that is nearest to a time [s]."""
    filming = Filming(read_recording(run, plan), "still", size=size, samples=samples)
    frame = min(filming.reels()[0].frames, key=lambda frame: abs(frame.t - t))
    return Image.fromarray(np.asarray(filming.develop(filming.trace(frame))))


def save(image: Image.Image, path: Path) -> None:
    """Save a picture in the best quality that is small enough."""
    for quality in range(92, 40, -4):
        image.save(path, quality=quality, optimize=True, progressive=True)
        if path.stat().st_size <= LARGEST:
            return


def page(runs: Path, pictures: Path, before: str) -> str:
    """Return the text of the page; of cases without a run here, it says what it said before."""
    parts = [
        "# Gallery",
        "What the cases of this repository show, path traced from what was recorded. Films and pictures are made with\n"
        "`text2sim run cases/NAME` and `text2sim render runs/NAME-…`, this page with `python benchmarks/gallery.py`.",
    ]
    for folder in sorted(CASES.iterdir()):
        if (folder / "case.yaml").is_file():
            parts.append(entry(folder.name, runs, pictures, before))
    finishes = pictures / "finishes.jpg"
    if finishes.is_file():
        names = list(load_case(FINISHES / "case.yaml").case.scene.statics)[1:]
        said = f"From the front left to the back right: {', '.join(names).replace('_', ' ')}, sand."
        parts.append(f"## finishes\n\n![A ball of every finish]({pictures.name}/{finishes.name})\n\n{said}")
    return "\n\n".join(parts) + "\n"


def entry(name: str, runs: Path, pictures: Path, before: str) -> str:
    """Return what the page says of a case."""
    said = " ".join((load_case(CASES / name / "case.yaml").case.prompt or "").split())
    lines = [f"## {name}"]
    if (pictures / f"{name}.jpg").is_file():
        lines.append(f"![{name}]({pictures.name}/{name}.jpg)")
    lines.append(said)
    if name in ELSEWHERE:
        lines.append(ELSEWHERE[name])
    elif len(lines) == 2:
        lines.append("No picture yet: its run takes long.")
    command = f"`text2sim run cases/{name} && text2sim render runs/{name}-…`"
    run = newest_run(runs, name)
    if run is None:
        known = next((line for line in before.splitlines() if line.startswith(command)), command)
        return "\n\n".join([*lines, known])
    lines.append(f"{command}: {verdict(json.loads((run / 'evidence.json').read_text('utf-8')))}")
    return "\n\n".join(lines)


def verdict(evidence: dict[str, Any]) -> str:
    """Return the verdict of a run in words."""
    if evidence["state"] != "finished":
        return f"{evidence['state']} at {evidence['time']['reached']:.2f} s, not judged."
    rows = evidence["expect"]
    true = sum(bool(row["ok"]) for row in rows.values())
    text = f"{true} of {len(rows)} expectations came true"
    failed = [name for name, row in rows.items() if not row["ok"]]
    return text + (f" (not {', '.join(failed)})" if failed else "") + "."


if __name__ == "__main__":
    main()
