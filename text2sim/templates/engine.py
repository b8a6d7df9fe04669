"""Mends what is wrong with the engine, in the release that has the fault."""

import inspect
from hashlib import sha256

import genesis as gs
import quadrants as qd
from genesis.engine.solvers.rigid.collider import support_field
from genesis.utils import array_class
from genesis.utils import geom as gu


def mend() -> None:
    """Mends the engine; call before `gs.init`, once in a process.

    Genesis 1.4.5 throws a cylinder that stands on a slope metres into the air: the point of a cylinder that lies
    farthest in a direction is moved out from the axis along what the direction has across it, and where that is little
    but rounding (it is done from 1e-9 on), it may point along the axis. Below 1e-5 the middle of the face is as good.

    Compiled kernels are looked up by the release of the compiler and the source of the kernel, which does not say by
    what the functions that it calls were replaced: those of a mended engine get a release of their own.
    """
    if "> 1e-9" not in inspect.getsource(support_field._func_support_cylinder):
        return
    support_field._func_support_cylinder = _support_cylinder
    qd.__version_str__ += "+" + sha256(inspect.getsource(_support_cylinder).encode()).hexdigest()[:8]


@qd.func
def _support_cylinder(
    i_g: int,
    d: qd.types.vector(3),
    pos: qd.types.vector(3),
    quat: qd.types.vector(4),
    dyn_info: array_class.DynInfo,
    shrink: bool,
):
    radius = dyn_info.geoms.data[i_g][0]
    half_length = 0.5 * dyn_info.geoms.data[i_g][1]
    axis = gu.qd_transform_by_quat(qd.Vector([0.0, 0.0, 1.0], dt=gs.qd_float), quat)
    side = -1.0 if d.dot(axis) < 0.0 else 1.0
    point = pos + half_length * side * axis
    if not shrink:
        across = d - d.dot(axis) * axis
        across = across - across.dot(axis) * axis  # once more: rounding has left some of it along the axis
        norm = across.norm()
        if norm > 1e-5:
            point = point + (radius / norm) * across
    return point
