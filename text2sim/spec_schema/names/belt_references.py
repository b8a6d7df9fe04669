"""Checks of statics whose surfaces move: in which scenes they can, and what cannot be fastened to them."""

from text2sim.spec_schema.models.controls import Attach, Bond
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.names.removal_references import fixed_because
from text2sim.spec_schema.names.selectors import WORLD
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.text.document import Path

RULE = "moving-surface"


def check_belts(table: NameTable) -> None:
    """Check every static whose surface moves, and what holds on to it."""
    scene = table.loaded.case.scene
    belts = [name for name, static in table.statics.items() if static.carries]
    if not belts:
        return
    if why := fixed_because(scene, "what lies on it would not be carried while it sleeps", "has no moving surfaces"):
        for name in belts:
            table.report(("scene", "statics", name, "surface_velocity"), f"no surface can move here: {why}", RULE)
    for name, control in table.loaded.case.actions.controls.items():
        where: Path = ("actions", "controls", name)
        if isinstance(control, Attach):
            if control.to == WORLD and WORLD not in table.bodies and len(belts) == len(table.statics):
                message = "a weld to the world needs a static whose surface does not move, and the scene has none"
                table.report((*where, "to"), message, RULE)
                continue
            _check_holders(table, control.to, (*where, "to"))
        elif isinstance(control, Bond):
            _check_holders(table, control.of, (*where, "of"))


def _check_holders(table: NameTable, selectors: str | list[str], where: Path) -> None:
    for member in table.find_all(selectors, where):
        if isinstance(member.model, Static) and member.model.carries:
            message = f"the surface of `{member.name}` moves, so nothing can be fastened to it; name another static"
            table.report(member.where, message, RULE)
