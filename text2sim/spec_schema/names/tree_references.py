"""Checks of the links, loops, joints and start positions of articulated bodies."""

from collections.abc import Mapping
from math import degrees, pi
from typing import Any

from text2sim.spec_schema.errors import nearest, there_are
from text2sim.spec_schema.models.bodies import Articulated, HingeMount, Link, Loop, Rigid, SliderMount
from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.names.reference_cycles import find_cycles
from text2sim.spec_schema.names.selectors import WORLD, named_by, spread_over
from text2sim.spec_schema.text.document import Path

START_GAP = 1e-3
"""Largest error of a gear at the start, relative to the position of its first joint: some digits are enough."""


def check_tree(table: NameTable, name: str, body: Articulated) -> None:
    """Check the links, joints, loops and start positions of one body.

    Args:
        table: The table; problems are added to it.
        name: Name of the body.
        body: The body.
    """
    root: Path = ("bodies", name)
    links = body.links
    if links is None:
        if body.loops:
            table.report((*root, "loops"), "loops need links; a file has its own", "tree", key=True)
        if name in table.parts:
            _check_file(table, root, body, table.parts[name].joints)
        return
    if body.joints:
        message = "`joints` changes those of a file; with links, give each link its own"
        table.report((*root, "joints"), message, "tree", key=True)
    _check_roots(table, root, links)
    _check_loops(table, root, body, links)
    _check_initial(table, root, body, {name: link.joint for name, link in links.items()})
    for link, model in links.items():
        if isinstance(model.joint, HingeMount | SliderMount) and not any(named_by(key, [link]) for key in body.initial):
            _check_range(table, (*root, "links", link, "joint", _range_field(model.joint)), model.joint, 0.0)


def check_mount(table: NameTable, name: str, body: Rigid) -> None:
    """Check that a body on a hinge or slider starts within the range of its joint.

    Args:
        table: The table; problems are added to it.
        name: Name of the body.
        body: The body.
    """
    if isinstance(body.mount, HingeMount | SliderMount):
        _check_range(table, ("bodies", name, "mount", _range_field(body.mount)), body.mount, 0.0)


def _check_file(table: NameTable, root: Path, body: Articulated, joints: Mapping[str, Any]) -> None:
    for name, change in body.joints.items():
        where = (*root, "joints", name)
        meant = named_by(name, joints)
        if not meant:
            message = f"`{body.file}` has no joint `{name}`{there_are(joints)}"
            table.report(where, message, "unknown-joint", nearest(name, joints), key=True)
            continue
        odd = [joint for joint in meant if not isinstance(joints[joint], HingeMount | SliderMount)]
        if change.actuator is not None and odd:
            message = f"`{odd[0]}` is a {joints[odd[0]].kind} joint; only a hinge or slider can have a motor"
            table.report((*where, "actuator"), message, "no-joint", key=True)
    _check_initial(table, root, body, joints)


def _check_roots(table: NameTable, root: Path, links: dict[str, Link]) -> None:
    first: str | None = None
    for name, link in links.items():
        where = (*root, "links", name)
        if name == WORLD:
            table.report(where, f"`{WORLD}` is the name of the world; choose another name", "tree", key=True)
        if link.parent is None:
            if first is not None:
                message = f"only the root has no parent, and `{first}` is already the root"
                table.report(where, message, "tree", key=True)
            elif link.joint is not None:
                message = "the root has no joint; `base` says whether it moves freely"
                table.report((*where, "joint"), message, "tree", key=True)
            first = first or name
            continue
        table.check_known((*where, "parent"), "link", link.parent, links)
        if link.joint is None:
            message = "`joint` is missing: every link except the root has one; `joint: {kind: fixed}` welds it"
            table.report(where, message, "tree", key=True)
    for cycle in find_cycles({name: link.parent for name, link in links.items() if link.parent is not None}):
        message = f"links are parents of each other in a cycle: {' -> '.join([*cycle, cycle[0]])}"
        table.report((*root, "links", cycle[0], "parent"), message, "circular-tree")
    if first is None and all(link.parent in links for link in links.values()):
        table.report((*root, "links"), "one link must have no parent: the root", "tree", key=True)


def _check_loops(table: NameTable, root: Path, body: Articulated, links: dict[str, Link]) -> None:
    for name, loop in body.loops.items():
        where = (*root, "loops", name, "between")
        for index, link in enumerate(loop.between):
            if link in links or (index == 1 and link == WORLD):
                continue
            message = f"there is no link `{link}`"
            if link == WORLD:
                message = f"`{WORLD}` must be second: the anchor is in the frame of the first"
            table.report((*where, index), message, "unknown-link", nearest(link, links))
        if loop.between[0] == loop.between[1]:
            table.report(where, "a loop is between two different links", "tree")
        elif loop.kind == "gear":
            _check_gear(table, where, loop, body, links)


def _check_gear(table: NameTable, where: Path, loop: Loop, body: Articulated, links: dict[str, Link]) -> None:
    """Check that a gear couples hinges or sliders, and that they start as it couples them."""
    for index, name in enumerate(loop.between):
        if name == WORLD or (name in links and not isinstance(links[name].joint, HingeMount | SliderMount)):
            message = f"`{name}` has no hinge or slider, and a gear couples two of them"
            table.report((*where, index), message, "tree")
            return
    movable = [name for name, link in links.items() if isinstance(link.joint, HingeMount | SliderMount)]
    start = spread_over(movable, body.initial)
    first, second = (start.get(name, 0.0) for name in loop.between)
    assert loop.ratio is not None
    if abs(first - loop.ratio * second) > START_GAP * abs(first):
        message = (
            f"`{loop.between[0]}` starts at {first:g} and `{loop.between[1]}` at {second:g}, which a ratio of "
            f"{loop.ratio:g} takes to {loop.ratio * second:g}; say the same in `initial`"
        )
        table.report(where, message, "inconsistent")


def _check_initial(table: NameTable, root: Path, body: Articulated, joints: Mapping[str, Any]) -> None:
    for name, value in body.initial.items():
        where = (*root, "initial", name)
        movable = [link for link, joint in joints.items() if isinstance(joint, HingeMount | SliderMount)]
        meant = named_by(name, movable)
        if not meant:
            what = f"`{name}` has no hinge or slider" if name in joints else f"there is no joint `{name}`"
            table.report(where, what, "unknown-joint", nearest(name, movable), key=True)
            continue
        for joint in meant:
            before = len(table.problems)
            _check_range(table, where, joints[joint], value)
            if len(table.problems) > before:  # one problem for a pattern is enough
                break


def _check_range(table: NameTable, where: Path, joint: HingeMount | SliderMount, value: float) -> None:
    """Report a start position [rad or m] outside the range of its joint."""
    if isinstance(joint, HingeMount):
        limits, start, unit = joint.range_deg, round(degrees(value), 9), "deg"
    else:
        limits, start, unit = joint.range, value, "m"
    if limits is not None and not limits[0] <= start <= limits[1]:
        message = f"starts outside its range: {start:.5g} {unit} is not from {limits[0]:g} to {limits[1]:g}"
        if unit == "deg" and abs(value) > 2 * pi and limits[0] <= value <= limits[1]:
            message += f"; it is in radians: {value:g} deg is ${{radians({value:g})}}"
        table.report(where, message, "range")


def _range_field(joint: HingeMount | SliderMount) -> str:
    return "range_deg" if isinstance(joint, HingeMount) else "range"
