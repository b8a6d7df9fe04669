"""Shapes of kind `sculpt` from three sides, on one sheet: `docs/sculptures.jpg`, and what each took.

    python -m benchmarks.sculptures [NAME …] [--out docs/sculptures.jpg]

Each is a file in `benchmarks/sculptures`: a look, and a shape as it stands in a case.
"""

import argparse
import time
from io import BytesIO
from pathlib import Path

from PIL import Image, ImageDraw

from text2sim.compiler.build import resolve_case
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.sculpting import sculpted
from text2sim.drawing.portrait import portrait
from text2sim.spec_schema.load import load_text

SHAPES = Path(__file__).parent / "sculptures"
SIDES = (0, 115, 235)
"""Turn [deg] about the vertical of each picture."""
SIZE = (400, 270)
CASE = """\
text2sim: 2
name: sculpture
prompt: A figure stands on the ground.
scene: {{duration: 1, statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies:
  figure:
    kind: rigid
    pose: {{euler_deg: [0, 0, {turn}]}}
"""


def main() -> None:
    """Draw the sheet and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--out", type=Path, default=Path("docs/sculptures.jpg"))
    options = parser.parse_args()
    names = options.names or sorted(path.stem for path in SHAPES.glob("*.yaml"))
    sheet = Image.new("RGB", (len(SIDES) * SIZE[0], len(names) * SIZE[1]))
    print("| shape | parts | triangles | pieces for contact | made in |\n|---|---|---|---|---|")
    for row, name in enumerate(names):
        text = (SHAPES / f"{name}.yaml").read_text()
        body = "".join(f"    {line}\n" for line in text.splitlines())
        for column, turn in enumerate(SIDES):
            began = time.monotonic()
            case = CASE.format(turn=turn) + body
            resolution = resolve_case(load_text(case, SHAPES / "case.yaml"))
            if column == 0:
                took = time.monotonic() - began
                shape = resolution.placed["figure"][0].shape
                made, pieces = sculpted(shape), geometry.pieces(shape, SHAPES)
                print(f"| {name} | {len(shape.parts)} | {len(made.faces)} | {len(pieces)} | {took:.1f} s |", flush=True)
            picture = Image.open(BytesIO(portrait(resolution, SIZE)))
            sheet.paste(picture, (column * SIZE[0], row * SIZE[1]))
        ImageDraw.Draw(sheet).text((10, row * SIZE[1] + 8), name, fill=(60, 60, 60))
    sheet.save(options.out, quality=82, optimize=True)


if __name__ == "__main__":
    main()
