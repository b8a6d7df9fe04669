"""The page for reviewing doubtful items, and the file of the reviewer's decisions."""

import base64
import io
import json
from collections.abc import Collection
from html import escape
from pathlib import Path
from tarfile import TarError
from typing import Any, Literal

import numpy as np

from text2sim.compiler.shapes.pictures import picture_bytes
from text2sim.dataset.check import want_tables
from text2sim.dataset.shards import read_shard
from text2sim.dataset.tables import read_rows
from text2sim.spec_schema.errors import RunError, SpecError, nearest
from text2sim.spec_schema.models.base import Model
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import read_source
from text2sim.spec_schema.vocabulary.typed_document import model_of
from text2sim.spec_schema.whole_files import write_atomically

FILE = "review.yaml"
PICTURES = 4


class ReviewDecision(Model):
    """A reviewer's decision about an item."""

    decision: Literal["keep", "drop"]
    note: str = ""


class Decisions(Model):
    """Decisions by key of the item."""

    review: dict[str, ReviewDecision] = {}


def read_decisions(path: Path | None, keys: Collection[str] | None = None) -> dict[str, ReviewDecision]:
    """Read decisions.

    Args:
        path: The file; if left out, `review.yaml`, which need not exist.
        keys: Items that decisions may be about; any if left out.

    Raises:
        SpecError: with all problems and their places.
    """
    if path is None and not Path(FILE).is_file():
        return {}
    document = parse_document(read_source(path or Path(FILE)))
    found = model_of(document, Decisions).review
    if keys is not None and (unknown := [key for key in found if key not in keys]):
        message = "the dataset has no item `{}`; leave out the line, or name another file with `--decisions`"
        raise SpecError(
            document.problem(
                ("review", key), message.format(key), key=True, rule="unknown-name", hint=nearest(key, keys)
            )
            for key in unknown
        )
    return found


def write_review(folder: Path, path: Path, decisions: dict[str, ReviewDecision], *, everything: bool = False) -> int:
    """Write the page; return how many items it shows.

    Args:
        folder: The dataset.
        path: The page.
        decisions: Earlier decisions.
        everything: Show all items, not only the doubtful ones.

    Raises:
        RunError: if the folder has no dataset, or it is damaged.
    """
    from av.error import FFmpegError

    want_tables(folder)
    rows = {row["key"]: row for _, row in read_rows(folder, "items") if everything or row["doubtful"]}
    blocks = []
    for shard in sorted((folder / "shards").glob("*.tar")):
        try:
            for key, files in read_shard(shard):
                if key in rows:
                    blocks.append(_block(rows[key], files["film.mp4"], decisions.get(key)))
        except (TarError, FFmpegError, LookupError, OSError) as error:
            raise RunError(f"{shard}: cannot be read ({error}); `text2sim dataset check` lists what is wrong") from None
    earlier = {key: decision.model_dump() for key, decision in decisions.items()}
    page = _PAGE.replace("@NAME@", escape(folder.name)).replace("@BLOCKS@", "\n".join(blocks))
    write_atomically(path, page.replace("@MADE@", json.dumps(earlier).replace("<", "\\u003c")))
    return len(blocks)


def _block(row: dict[str, Any], film: bytes, earlier: ReviewDecision | None) -> str:
    doubts = [*row["suspicions"], *row["remarks"]]
    doubts += [
        f"`{expectation['name']}` {expectation['why']}"
        for expectation in row["expectations"]
        if expectation["ok"] is not True
    ]
    numbers = {"energy without a source": row["energy_gain"], "deepest penetration [m]": row["penetration"]}
    doubts += [f"{name}: {value:.3g}" for name, value in numbers.items() if value]
    pictures = "".join(f'<img src="data:image/jpeg;base64,{data}" alt="">' for data in _pictures(film))
    reasons = "".join(f"<li>{escape(text)}</li>" for text in doubts)
    key, note = escape(row["key"]), escape(earlier.note if earlier else "")
    radios = ""
    for word in ("keep", "drop"):
        checked = " checked" if earlier and earlier.decision == word else ""
        radios += f'<label><input type="radio" name="{key}" value="{word}"{checked}>{word}</label>'
    return (
        f'<section data-key="{key}"><h2>{key}</h2><p>{escape(row["prompt"])}</p>{pictures}<ul>{reasons}</ul>'
        f'{radios}<input class="note" placeholder="note" value="{note}"></section>'
    )


def _pictures(film: bytes) -> list[str]:
    import av

    with av.open(io.BytesIO(film), "r") as container:
        pictures = [picture.to_image() for picture in container.decode(video=0)]
    shown = np.linspace(0, len(pictures) - 1, PICTURES).round().astype(int)
    return [base64.b64encode(picture_bytes(pictures[k], "jpeg", quality=85)).decode() for k in shown]


_PAGE = """<!doctype html><meta charset="utf-8"><title>Review of @NAME@</title>
<style>body{font:15px system-ui;max-width:1100px;margin:2em auto;color:#222}
section{border-top:1px solid #ccc;padding:1em 0}
img{width:24%;margin-right:1%}h2{font-size:1em}label{margin-right:1.5em}.note{width:30em}
button{position:fixed;top:1em;right:1em;padding:.6em 1em}</style>
<h1>Review of @NAME@</h1><p>Decide, and save <code>review.yaml</code> beside the recipe: <code>dataset build --decisions
review.yaml</code> leaves out dropped items.</p><button>save review.yaml</button>
@BLOCKS@
<script>
const made = @MADE@;
document.querySelector("button").onclick = () => {
  for (const s of document.querySelectorAll("section")) {
    const one = s.querySelector("input:checked");
    if (one) made[s.dataset.key] = {decision: one.value, note: s.querySelector(".note").value};
  }
  const rows = Object.keys(made).sort().map(k =>
    `  ${k}: {decision: ${made[k].decision}, note: ${JSON.stringify(made[k].note)}}\\n`);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([rows.length ? "review:\\n" : "review: {}\\n", ...rows]));
  link.download = "review.yaml";
  link.click();
};
</script>
"""
