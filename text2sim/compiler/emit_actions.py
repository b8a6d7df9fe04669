"""Values for the template of `actions.py`, and the modules that it uses."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from text2sim.compiler.literal import Code
from text2sim.compiler.plan import Plan

TEMPLATES = Path(__file__).resolve().parent.parent / "templates"
COPIED_ACTIONS = (
    "points.py",
    "holds.py",
    "mpm_holds.py",
    "two_way_holds.py",
    "loads.py",
    "seams.py",
    "pushes.py",
    "airflow.py",
    "fields.py",
    "removals.py",
    "triggers.py",
    "bonds.py",
    "springs.py",
    "belts.py",
)
"""Modules that a program gets only if it needs them."""


def action_context(plan: Plan) -> dict[str, Any]:
    """Return what the templates of actions need besides the fields of a plan."""
    soft_velocities = [row for row in plan.velocities if row.entity in plan.deformables]
    watched = [row.make for row in plan.watches]
    seams = [row for row in plan.holds if row.seam is not None]
    regions = [row.region for row in (*plan.holds, *plan.pushes)] + watched + [row.seam[1] for row in seams if row.seam]
    breaking_holds = any(row.strength is not None for row in plan.holds)
    breaking = ["actions.bonds"] * bool(plan.bonds) + ["actions.holds"] * breaking_holds
    pushing = ["Push"] * bool(plan.pushes) + ["set_velocity"] * bool(soft_velocities)
    acting = [
        "Actions",
        *["BELTS"] * bool(plan.belts),
        *["add_fields"] * bool(plan.fields),
        *["clear_the_way"] * bool(plan.prescribed or plan.belts),
    ]
    return {
        "velocities": [row for row in plan.velocities if row.entity not in plan.deformables],
        "soft_velocities": soft_velocities,
        "fading": any("fading_sine(" in made for made in _schedules(plan)),
        "splines": any("spline(" in made for made in _schedules(plan)),
        "later_drives": any(row.later for row in plan.drives),
        "pivots": any(row.pivot is not None for row in plan.welds),
        "stiff_welds": [row for row in plan.welds if row.stiff and row.on],
        "released_welds": any(row.event is not None for row in plan.welds),
        "released_holds": any(isinstance(end, str) for row in plan.holds for end in row.until),
        "holding": Code(", ".join([*["Hold"] * (len(seams) < len(plan.holds)), "Holds"])),
        "seams": bool(seams),
        "breaking_holds": breaking_holds,
        "breaking": Code(", ".join(breaking)),
        "scaled_pushes": any(row.scale is not None for row in plan.pushes),
        "scaled_airflows": any(row.scale is not None for row in plan.airflows),
        "scaled_fields": any(row.scale is not None for row in plan.fields),
        "changing_fields": [(number, row) for number, row in enumerate(plan.fields) if row.changes],
        "removed_on_event": any(row.event is not None for row in plan.removals),
        "acting": Code(", ".join(acting)),
        "finders": _called("points.py", regions),
        "own_fields": _called("fields.py", ["Fields", *(row.make for row in plan.fields)]),
        "pushing": Code(", ".join(pushing)),
        "watching": _called("triggers.py", ["Triggers", *watched]),
    }


def _schedules(plan: Plan) -> Iterable[str]:
    """Yield the sources of all functions of time."""
    for drive in plan.drives:
        yield from (segment.target for segment in (*drive.segments, *drive.later))
    scaled = (*plan.wrenches, *plan.pushes, *plan.airflows, *plan.fields)
    yield from (row.scale for row in scaled if row.scale is not None)
    yield from (code for row in plan.prescribed for code in row.velocity)


def copied_actions(plan: Plan) -> list[str]:
    """Return the names of the modules that actions of a plan use."""
    soft_velocities = any(row.entity in plan.deformables for row in plan.velocities)
    inner = any(facts.gas or facts.damping for facts in plan.deformables.values())
    needed = {
        "points.py": bool(inner or plan.holds or plan.pushes or plan.airflows or plan.watches or soft_velocities),
        "holds.py": bool(plan.holds),
        "mpm_holds.py": bool(plan.holds),
        "two_way_holds.py": bool(plan.holds),
        "loads.py": any(row.strength is not None for row in plan.holds),
        "seams.py": any(row.seam is not None for row in plan.holds),
        "pushes.py": bool(plan.pushes or soft_velocities),
        "airflow.py": bool(plan.airflows),
        "fields.py": bool(plan.fields),
        "removals.py": bool(plan.removals),
        "triggers.py": bool(plan.watches),
        "bonds.py": bool(plan.bonds),
        "springs.py": bool(plan.springs),
        "belts.py": bool(plan.belts),
    }
    return [name for name in COPIED_ACTIONS if needed[name]]


def _called(module: str, sources: Iterable[str]) -> Code:
    """Return the functions and classes of a copied module that are called in sources, as an import lists them."""
    defined = re.findall(r"^(?:def|class) (\w+)", (TEMPLATES / module).read_text("utf-8"), re.MULTILINE)
    called = {name for source in sources for name in re.findall(r"(?<![\w.'\"])[A-Za-z_]+(?=\(|\Z|,|\))", source)}
    return Code(", ".join(sorted(called.intersection(defined))))
