"""A real client of the protocol's SDK that talks to a real server process over its standard streams."""

import base64
import json
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from anyio.from_thread import BlockingPortal
from mcp import Client, StdioServerParameters

TINY = """\
text2sim: 2
name: tiny
prompt: A box falls a little.

scene:
  duration: 0.2  # short
  dt: 0.005
  statics:
    floor: {shape: {kind: plane}}

bodies:
  box:  # the one that falls
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    material: {density: 500}
    place: {above: floor, at: [0, 0], clearance: 0.05}

actions:
  measures:
    height: {kind: extent, of: box, axis: z, stat: min}
  events:
    touch: {kind: contact, between: [box, floor]}
  expect:
    lands: {event: touch, within: [0.08, 0.13]}

render:
  resolution: [320, 240]
  speed: 1
"""
CARD = """\
id: seen-in-a-test
title: A thin floor lets a fast ball through
applies: {modes: [rigid], roles: [critic], signatures: [tunnelling]}
symptoms: [The ball is below the floor at the end.]
likely_causes: [It comes farther in a substep than the floor is thick.]
repair: [Give the scene more substeps.]
evidence:
  case: A ball on a sheet of 1 mm
  failing: {outcome: "missed:lies", observed: the ball falls through}
  repaired: {outcome: passed, observed: the ball lies on the sheet}
  measured_on: {genesis: 1.4.5}
"""


@dataclass
class Reply:
    """What a tool answered."""

    document: dict[str, Any]
    text: str
    failed: bool
    picture: bytes = b""
    media: str = ""
    progress: list[tuple[float, float | None, str | None]] = field(default_factory=list)


class Agent:
    """Calls tools as an agent would."""

    def __init__(self, client: Client, portal: BlockingPortal, root: Path) -> None:
        self.client, self.portal, self.root = client, portal, root

    def __call__(self, tool: str, **arguments: Any) -> Reply:
        told: list[tuple[float, float | None, str | None]] = []

        async def listen(progress: float, total: float | None, message: str | None) -> None:
            told.append((progress, total, message))

        async def call() -> Any:
            return await self.client.call_tool(tool, arguments, read_timeout_seconds=120, progress_callback=listen)

        result = self.portal.call(call)
        texts = [block.text for block in result.content if block.type == "text"]
        pictures = [block for block in result.content if block.type == "image"]
        try:
            document = json.loads(texts[0])
        except ValueError:  # arguments that do not fit are refused by the SDK, in words
            document = {"error": texts[0]}
        reply = Reply(document, "".join(texts[1:]), result.is_error is True, progress=told)
        if pictures:
            reply.picture, reply.media = base64.b64decode(pictures[0].data), pictures[0].mime_type
        return reply

    def write(self, name: str, text: str) -> Path:
        """Put a case on disk, past the tools."""
        file = self.root / "cases" / name / "case.yaml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text.replace("name: tiny", f"name: {name}"), "utf-8")
        return file


def parameters(root: Path) -> StdioServerParameters:
    """How to start the server."""
    environment = {"TEXT2SIM_CARDS": str(root / ".cards")}
    return StdioServerParameters(
        command=sys.executable, args=["-m", "text2sim", "mcp", "--root", str(root)], env=environment
    )
