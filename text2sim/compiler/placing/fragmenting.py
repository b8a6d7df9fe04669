"""`repeat: {kind: fragments}`: one copy for each fragment into which the shape of a rigid body is cut."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from text2sim.compiler.placing.place_error import PatternError
from text2sim.compiler.shapes.fragment import Fragment
from text2sim.compiler.shapes.geometry import volume
from text2sim.compiler.shapes.rotation import frame_apply
from text2sim.compiler.shapes.sizes import CopySpot
from text2sim.spec_schema.models.base import content_of
from text2sim.spec_schema.models.bodies import Rigid
from text2sim.spec_schema.models.placed import Deformable
from text2sim.spec_schema.models.repeat import Fragments
from text2sim.spec_schema.models.shapes import Compound

MAX_FRAGMENTS = 250
"""Most fragments of a body: each has a surface of its own, which the engine reads and prepares."""


def fragments_of(model: Any, folder: Path) -> list[Fragment]:
    """Return the fragments of a body.

    Raises:
        PatternError: if it cannot be cut.
        AssetError: if its surface is not closed, or a file of its shape cannot be used.
    """
    if not isinstance(model, Rigid):
        what = "a deformable body tears by `tear_stretch` (mpm) instead" if isinstance(model, Deformable) else ""
        raise PatternError(
            "only a body of `kind: rigid` is cut into fragments" + (f"; {what}" if what else ""), "repeat"
        )
    if model.mount.kind not in ("free", "fixed"):
        raise PatternError("fragments are free or fixed: each would get a joint of its own", "mount")
    _check_parts(model.shape)
    from text2sim.compiler.shapes.cutting import cuttings  # needs arrays, which most cases do without

    cut = model.repeat
    assert isinstance(cut, Fragments)
    found = cuttings(model.shape, cut, folder)
    if len(found) > MAX_FRAGMENTS:
        text = f"{cut.count} cells give {len(found)} fragments; at most {MAX_FRAGMENTS} are possible"
        raise PatternError(text, "repeat")
    return found


def _check_parts(shape: Any) -> None:
    if not isinstance(shape, Compound):
        return
    for name, part in shape.parts.items():
        if part.decor or part.density is not None:
            key = "decor" if part.decor else "density"
            raise PatternError(
                f"a compound is cut as one body: part `{name}` cannot have a `{key}` of its own",
                "shape", "parts", name, key,
            )  # fmt: skip


def fragmented(spots: Sequence[CopySpot], folder: Path) -> list[CopySpot]:
    """Return the copies, each with its fragment, where it is in the whole body.

    Raises:
        PatternError: if copies differ in their shape or in how it is cut.
        AssetError: if a file of the shape cannot be used.
    """
    first = spots[0].model
    found = fragments_of(first, folder)
    whole = volume(first.shape, folder)
    placed = []
    for index, (spot, fragment) in enumerate(zip(spots, found, strict=True)):
        for key in ("shape", "repeat"):
            own, meant = getattr(spot.model, key), getattr(first, key)
            if own is not meant and content_of(own) != content_of(meant):
                raise PatternError(f"fragments are of one body: its `{key}` differs in copy {index}", key)
        material = spot.model.material
        if material.mass is not None:
            density = material.mass / whole
            material = material.model_copy(update={"mass": None, "density": density})
        model = spot.model.model_copy(update={"shape": fragment, "material": material})
        pos = frame_apply(spot.pos, spot.quat, fragment.place)
        placed.append(spot._replace(pos=pos, shape=fragment, model=model))
    return placed
