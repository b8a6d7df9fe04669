"""Checks whether this machine can run a case, before the engine starts."""

from typing import TYPE_CHECKING

from text2sim.runtime.machine import ipc_obstacle
from text2sim.spec_schema.errors import MachineError, Text2SimError
from text2sim.spec_schema.reuse.overlay import CaseOverlay

if TYPE_CHECKING:
    from text2sim.spec_schema.loaded import LoadedCase


def needs_cuda(loaded: "LoadedCase") -> bool:
    """Return whether a case only runs on a CUDA device."""
    from text2sim.compiler.soft.solvers import contact_model

    return contact_model(loaded.case.bodies.values(), loaded.case.scene) == "ipc"


def check_ability(loaded: "LoadedCase") -> None:
    """Raise an error before the engine starts if the contact model of a case does not run here.

    Raises:
        MachineError: with the reason, and the variants of the case that do run here.
    """
    if not needs_cuda(loaded) or not (obstacle := ipc_obstacle()):
        return
    able = [name for name in _variants(loaded) if _runs(loaded, name)]
    if able:
        names = " or ".join(f"`--variant {name}`" for name in able)
        remedy = f"; run it with {names}, which {'does' if len(able) == 1 else 'do'} without"
    else:
        remedy = "; it has no variant that does without (`scene.contact.model: particle` or `sap` would)"
    raise MachineError(f"contact model ipc does not run on this machine: {obstacle}{remedy}")


def _variants(loaded: "LoadedCase") -> list[str]:
    named = loaded.written.data.get("variants")
    return [str(name) for name in named] if isinstance(named, dict) else []


def _runs(loaded: "LoadedCase", variant: str) -> bool:
    """Return whether the case, with one variant laid over it, needs no ipc."""
    from text2sim.spec_schema.load import load_text

    if variant in loaded.overlay.variants:
        return False
    try:
        overlay = CaseOverlay(variants=(variant,), sets=loaded.overlay.sets)
        return not needs_cuda(load_text(loaded.source.text, loaded.path, overlay))
    except Text2SimError:
        return False
