"""Restyling: patches that change the appearance of a case and cannot change its physics."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from text2sim.compiler.build import plan_case
from text2sim.revision.revise import Revision, revise
from text2sim.spec_schema.changes.operation import Operation, split_pointer
from text2sim.spec_schema.errors import RunError, Text2SimError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.source import Source

LOOK = "look"


class TouchesPhysics(RunError):
    """Error: a patch changes more than the appearance of a case."""


def restyle(text: str, operations: Sequence[Operation], path: Path) -> str:
    """Apply a patch that changes the appearance of a case.

    Args:
        text: Text of the case.
        operations: The patch.
        path: Path of the case file.

    Raises:
        TouchesPhysics: If it changes anything but `render` and looks, or if it would change the simulation.
        PatchError: If the patch cannot be applied.
        SpecError: If the result is not a valid case.
    """
    for number, operation in enumerate(operations):
        for member in ("path", "from") if operation.get("op") in ("move", "copy") else ("path",):
            place = str(operation.get(member))
            if operation.get("op") != "test" and not is_style(place):
                raise TouchesPhysics(
                    f"operation {number + 1}: `{place}` is neither below /render nor a look of a body or static"
                )
    revision: Revision = revise(Source(text, str(path)), path, operations)
    if (digest := physics_digest(text, path)) != physics_digest(revision.text, path):
        culprit = _culprit(text, operations, path, digest)
        raise TouchesPhysics(f"{culprit} would change the simulation; only its appearance may change")
    return revision.text


def _culprit(text: str, operations: Sequence[Operation], path: Path, digest: tuple[str, Any]) -> str:
    """Name the first operation that changes the digest of the physics."""
    for number in range(1, len(operations)):
        try:
            part = revise(Source(text, str(path)), path, operations[:number]).text
            if physics_digest(part, path) != digest:
                return f"operation {number} (`{operations[number - 1].get('path')}`)"
        except Text2SimError:
            continue  # valid only together with later operations
    return f"operation {len(operations)} (`{operations[-1].get('path')}`)" if operations else "this patch"


def is_style(pointer: str) -> bool:
    """Whether a JSON Pointer leads into `render` or a look.

    The pointer alone does not suffice, as a part may be called `look`. Therefore the digests are compared as well.
    """
    try:
        steps = split_pointer(pointer)
    except ValueError:
        return False
    if steps[:1] == ("render",):
        return True
    below = steps[2:] if steps[:1] == ("bodies",) else steps[3:] if steps[:2] == ("scene", "statics") else ()
    return LOOK in below


def physics_digest(text: str, path: Path) -> tuple[str, Any]:
    """Return the digest of the simulation and the actions of a case, which are equal for equal physics."""
    loaded = load_text(text, path)
    return plan_case(loaded).sim_digest, loaded.case.actions.model_dump(mode="json")
