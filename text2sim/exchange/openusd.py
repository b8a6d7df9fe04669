"""OpenUSD, behind one door: it is heavy, comes with an extra, and tells type checkers nothing."""

from functools import cache
from types import SimpleNamespace
from typing import Any

from text2sim.spec_schema.errors import MachineError


@cache
def openusd() -> Any:
    """Return the modules of OpenUSD, by their names.

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
