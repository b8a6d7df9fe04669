"""Generator of the gallery of built-in prefabs, `docs/prefabs.md`, with parameters, examples and pictures.

Run `python -m text2sim.drawing.gallery docs`.
"""

import sys
from hashlib import sha256
from io import BytesIO
from pathlib import Path

from text2sim.compiler.shapes.pictures import picture_bytes
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.reuse.catalogue import built_in, example_case, examples, param_rows, parts_of
from text2sim.spec_schema.reuse.library import BUILT_IN

COMMAND = "python -m text2sim.drawing.gallery docs"
SIZE = (480, 360)
"""Width and height of a picture [pixels]."""
TRIED_COLOR_COUNTS = (160, 96, 64, 48, 32)
"""Numbers of colours that are tried until a picture is small enough."""
MAX_PICTURE_SIZE = 40_000
"""Largest size of a picture [bytes]."""
IN_A_ROW = 4
KEY = "prefab"
"""Key of the PNG text with the digest of what a picture shows."""

_INTRODUCTION = f"""\
<!-- Made by `{COMMAND}`: change the prefabs or their examples, not this page. -->
# Prefabs

Prefabs are ready-made bodies with real dimensions, masses and friction. `use` makes a body or a static from a prefab;
`with` gives its parameters. All other keys override those of the prefab's body: place, copies, look, material, mount
(`null` removes a key).

```yaml
bodies:
  glass: {{use: wine_glass, with: {{height: 0.24}}, place: {{on: table}}, look: {{color: lightblue}}}}
```

Some prefabs have several bodies. They are named `NAME_PART`, a parameter places them, and overrides are given by the
name of the part: `rail: {{use: curtain_rod, hook: {{look: {{color: gold}}}}}}`.

A case can have its own prefabs, in its section `prefabs` or in a file `prefabs/NAME.yaml` beside it; those take
precedence. `text2sim prefabs` lists all prefabs, `text2sim prefabs NAME` describes one as here, and
`text2sim show CASE` prints a case with its prefabs expanded.

Each picture shows the start of the example; a floor at `z = 0` is implied.
"""


def page() -> str:
    """Return the text of the page."""
    return "\n".join([_INTRODUCTION, _overview(), *map(_section, built_in())])


def picture(name: str) -> bytes:
    """Return the picture of a prefab, a small PNG with the digest of what it shows."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    from text2sim.compiler.build import resolve_case
    from text2sim.drawing.portrait import portrait

    drawn = portrait(resolve_case(load_text(example_case(examples()[name]))), SIZE)
    info = PngInfo()
    info.add_text(KEY, digest(name))
    content = b""
    for colors in TRIED_COLOR_COUNTS:
        few = Image.open(BytesIO(drawn)).convert("RGB").quantize(colors, dither=Image.Dither.NONE)
        content = picture_bytes(few, "PNG", optimize=True, pnginfo=info)
        if len(content) <= MAX_PICTURE_SIZE:
            break
    return content


def digest(name: str) -> str:
    """Return the digest of a prefab and its example."""
    prefab = (BUILT_IN / f"{name}.yaml").read_bytes()
    return sha256(prefab + examples()[name].encode()).hexdigest()[:16]


def digest_of(png: bytes) -> str:
    """Return the digest in a picture; empty if it has none."""
    from PIL import Image

    return Image.open(BytesIO(png)).info.get(KEY, "")


def write(docs: Path) -> list[Path]:
    """Write the page, and pictures that are not up to date, into the folder of the documentation.

    Returns:
        The files that changed.
    """
    changed = []
    folder = docs / "prefabs"
    folder.mkdir(parents=True, exist_ok=True)
    for name in built_in():
        path = folder / f"{name}.png"
        if not path.is_file() or digest_of(path.read_bytes()) != digest(name):
            path.write_bytes(picture(name))
            changed.append(path)
    for path in folder.glob("*.png"):
        if path.stem not in built_in():
            path.unlink()
    target, text = docs / "prefabs.md", page()
    if not target.is_file() or target.read_text("utf-8") != text:
        target.write_text(text, "utf-8")
        changed.append(target)
    return changed


def _overview() -> str:
    names = list(built_in())
    rows = ["| " * IN_A_ROW + "|", "|---" * IN_A_ROW + "|"]
    for first in range(0, len(names), IN_A_ROW):
        cells = [
            f'<img src="prefabs/{name}.png" width="200"><br>[{name}](#{name})' for name in names[first:][:IN_A_ROW]
        ]
        rows.append("| " + " | ".join([*cells, *[""] * (IN_A_ROW - len(cells))]) + " |")
    return "\n".join(rows) + "\n"


def _section(name: str) -> str:
    definition = built_in()[name]
    lines = [f"## {name}", "", f"![{name}](prefabs/{name}.png)", "", " ".join(definition.model.doc.split()), ""]
    if parts := parts_of(definition):
        lines += [f"Several bodies: {', '.join(f'`NAME_{part}`' for part in parts)}.", ""]
    lines += ["| parameter | takes | if left out | meaning |", "|---|---|---|---|"]
    for row in param_rows(definition):
        default = f"`{row.default}`" if row.default else "required"
        lines.append(f"| `{row.name}` | {row.takes} | {default} | {row.doc} |")
    return "\n".join([*lines, "", "```yaml", examples()[name].rstrip("\n"), "```", ""])


if __name__ == "__main__":
    for written in write(Path(sys.argv[1] if len(sys.argv) > 1 else "docs")):
        print(written)
