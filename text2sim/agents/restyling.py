"""Restyling: patches that change how a case is shown and cannot change its physics."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from text2sim.compiler.build import plan_case
from text2sim.revision.revise import Revision, revise
from text2sim.spec_schema.changes.operation import Operation, split_pointer
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.source import Source

LOOK = "look"


class TouchesPhysics(RunError):
    """Error: a patch changes more than how a case is shown."""


def restyled(text: str, operations: Sequence[Operation], path: Path) -> str:
    """Apply a patch that changes how a case is shown.

    Args:
        text: Text of the case.
        operations: The patch.
        path: Path of the case file.

    Raises:
        TouchesPhysics: If it changes anything but `render` and looks, or if the simulation would be another one.
        PatchError: If the patch cannot be applied.
        SpecError: If the result is no case that could be run.
    """
    for number, operation in enumerate(operations):
        for member in ("path", "from") if operation.get("op") in ("move", "copy") else ("path",):
            place = str(operation.get(member))
            if operation.get("op") != "test" and not is_style(place):
                raise TouchesPhysics(
                    f"operation {number + 1}: `{place}` is neither below /render nor a look of a body or static"
                )
    revision: Revision = revise(Source(text, str(path)), path, operations)
    if physics(revision.text, path) != physics(text, path):
        raise TouchesPhysics(
            "with this patch the simulation would be another one; how it is shown is all that may change"
        )
    return revision.text


def is_style(pointer: str) -> bool:
    """Whether what stands at a JSON Pointer says only how things are shown, as far as the pointer tells.

    A part that somebody has named `look`, and looks of parts, which the engine's file of a compound has in it, are told
    by the digest.
    """
    try:
        steps = split_pointer(pointer)
    except ValueError:
        return False
    if steps[:1] == ("render",):
        return True
    below = steps[2:] if steps[:1] == ("bodies",) else steps[3:] if steps[:2] == ("scene", "statics") else ()
    return LOOK in below


def physics(text: str, path: Path) -> tuple[str, Any]:
    """Return what a case simulates, and what it measures and expects: equal for equal physics."""
    loaded = load_text(text, path)
    return plan_case(loaded).sim_digest, loaded.case.actions.model_dump(mode="json")
