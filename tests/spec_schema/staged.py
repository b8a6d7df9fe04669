"""A case of some size to change one thing in, and the places in it where the examples of the language stand."""

import copy
from pathlib import Path
from typing import Any

from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.published.language_reference import load_examples
from text2sim.spec_schema.text.canonical import dump_case
from text2sim.spec_schema.text.document import parse_document, parse_pointer
from text2sim.spec_schema.text.source import Source, read_source

STAGE = parse_document(read_source(Path(__file__).with_name("stage.yaml"))).data
PARENTS = {
    "statics": "/scene/statics",
    "shapes": "/bodies/ball",
    "sculpt_parts": "/bodies/ball/shape",
    "cloth_shapes": "/bodies/curtain",
    "mounts": "/bodies/ball",
    "places": "/bodies/ball",
    "surfaces": "/bodies/ball",
    "repeats": "/bodies/ball",
    "regions": "/actions/measures/it",
    "body_regions": "/actions/controls/it",
    "bodies": "/bodies",
    "motions": "/bodies/paddle",
    "schedules": "/actions/controls/it",
    "controls": "/actions/controls",
    "measures": "/actions/measures",
    "events": "/actions/events",
    "expectations": "/actions/expect",
    "cameras": "/render/cameras",
    "lights": "/render/lights",
}
FRAMES = {
    "regions": {"kind": "count_in", "of": "brick"},
    "body_regions": {"kind": "force", "body": "ball", "force": [0, 0, 1]},
    "schedules": {"kind": "force", "body": "ball", "force": [0, 0, 1]},
}


def staged(edits: dict[str, Any] | None = None) -> LoadedCase:
    """Load the stage with values set at JSON Pointers; None takes a value away."""
    return load_text(dump_case(edited(edits or {})))


def edited(edits: dict[str, Any], data: Any = STAGE) -> Any:
    """Return a copy of data with values set at JSON Pointers; None takes a value away."""
    data = copy.deepcopy(data)
    for where, value in edits.items():
        *way, last = parse_pointer(where)
        target = data
        for step in way:
            target = target.setdefault(step, {}) if isinstance(target, dict) else target[step]
        if value is None:
            del target[last]
        else:
            target[last] = value
    return data


def edits_of(section: str, kind: str) -> dict[str, Any]:
    """Return what puts an example into the stage."""
    fragment = parse_document(Source(load_examples()[section][kind])).data
    parent = "/scene/statics/floor" if kind == "plane" else PARENTS[section]
    edits: dict[str, Any] = {}
    if section == "sculpt_parts":
        edits[parent] = {"kind": "sculpt", "parts": fragment}
    elif section in FRAMES:
        edits[parent] = {**FRAMES[section], **fragment}
    else:
        edits = {f"{parent}/{key}": value for key, value in fragment.items()}
    if kind == "stream":
        edits = {"/bodies/water": {"kind": "liquid", "pose": {"pos": [0, 0, 3]}, **fragment}}
    if "place" in fragment:
        edits["/bodies/ball/pose"] = None
    if section == "expectations":
        edits["/actions/measures/ball_speed"] = {"kind": "speed", "of": "ball"}
    if kind == "threaded":
        edits["/bodies/ring"] = {
            "kind": "rigid",
            "shape": {"kind": "torus", "radius": 0.1, "bar_radius": 0.02},
            "repeat": {"kind": "line", "count": 3, "step": [0, 0, 0.1], "start": [4, 0, 0.1]},
        }
        edits["/bodies/pole"] = {
            "kind": "rigid",
            "shape": {"kind": "cylinder", "radius": 0.03, "height": 0.5},
            "mount": {"kind": "fixed"},
            "pose": {"pos": [4, 1, 0.25]},
        }
    if kind in ("leaked", "surface_level", "submerged"):
        edits["/bodies/water"] = {"kind": "liquid", "shape": {"kind": "box", "size": [0.2, 0.2, 0.2]}}
    if section in ("mounts", "repeats"):  # a ball that hangs or is many is not launched
        edits |= {"/actions": {}}
    return edits
