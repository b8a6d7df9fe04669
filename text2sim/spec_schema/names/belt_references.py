"""Checks of what holds on to statics whose surfaces move: nothing can be fastened to them."""

from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.controls import Attach, Bond
from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.names.selectors import WORLD, body_of
from text2sim.spec_schema.text.document import Path

RULE = "moving-surface"


def check_belts(table: NameTable) -> None:
    """Check every control that fastens bodies, in a scene with statics whose surfaces move."""
    belts = [name for name, static in table.statics.items() if static.carries]
    if not belts:
        return
    for name, control in table.loaded.case.actions.controls.items():
        key = "to" if isinstance(control, Attach) else "of"
        where: Path = ("actions", "controls", name, key)
        for selector in listed(getattr(control, key)) if isinstance(control, Attach | Bond) else ():
            if body_of(selector) in belts:
                message = f"the surface of `{selector}` moves, so nothing can be fastened to it; name another static"
                table.report(where, message, RULE)
            elif selector == WORLD and WORLD not in table.bodies and len(belts) == len(table.statics):
                message = "a weld to the world needs a static whose surface does not move, and the scene has none"
                table.report(where, message, RULE)
