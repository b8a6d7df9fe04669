"""Untyped access to OpenUSD, an optional dependency that is slow to import and has no stubs."""

from functools import cache
from types import SimpleNamespace
from typing import Any

from text2sim.spec_schema.errors import MachineError


@cache
def openusd() -> Any:
    """Return the modules of OpenUSD by name.

    Raises:
        MachineError: if it is not installed.
    """
    try:
        from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade, UsdUtils, Vt
    except ImportError as error:
        raise MachineError("OpenUSD is not installed here: pip install 'text2sim[export]'") from error
    return SimpleNamespace(
        Gf=Gf, Sdf=Sdf, Tf=Tf, Usd=Usd, UsdGeom=UsdGeom, UsdLux=UsdLux, UsdPhysics=UsdPhysics, UsdShade=UsdShade,
        UsdUtils=UsdUtils, Vt=Vt,
    )  # fmt: skip
