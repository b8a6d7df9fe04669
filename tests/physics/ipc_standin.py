"""Builds the scene of a program of contact model ipc with a stand-in for libuipc, and prints what it was asked for.

    python tests/physics/ipc_standin.py PROGRAM [--no-device]

The stand-in computes nothing: it lets the engine's coupler make all its own checks, and notes the contacts that the
coupler registers. With `--no-device` it fails as libuipc does where there is no CUDA device.
"""

import json
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any
from unittest.mock import MagicMock

import numpy as np

contacts: list[tuple[str, str, float, bool]] = []


class Table:
    """Of contacts between elements."""

    def create(self, name: str) -> Any:
        element = MagicMock()
        element.label = name
        return element

    def insert(self, a: Any, b: Any, friction: float, resistance: float, enabled: bool) -> None:
        contacts.append((a.label, b.label, round(float(friction), 4), bool(enabled)))


class Objects:
    """Of the scene."""

    def create(self, name: str) -> Any:
        made = MagicMock()
        made.geometries().create.return_value = (MagicMock(), MagicMock())
        return made


class Scene:
    """Takes what it is given."""

    def __init__(self, config: Any) -> None:
        self.config = config

    @staticmethod
    def default_config() -> dict:
        return {"contact": {"friction": {}}, "newton": {}, "sanity_check": {}, "diff_sim": {}}

    def contact_tabular(self) -> Table:
        return Table()

    def objects(self) -> Objects:
        return Objects()

    def __getattr__(self, name: str) -> Any:
        return MagicMock(name=name)


def no_device(*_: Any) -> None:
    """Fail as libuipc does."""
    raise RuntimeError("CUDA error cudaGetDeviceCount: no CUDA-capable device is detected")


def stand_in(*, device: bool) -> None:
    """Put the stand-in where Python looks for libuipc."""
    names = ("backend", "constitution", "core", "geometry", "gui")
    parts: dict[str, Any] = {name: MagicMock(name=name) for name in names}
    parts["core"].Scene = Scene
    if not device:
        parts["core"].Engine = no_device
    uipc: Any = ModuleType("uipc")
    uipc.__dict__.update(parts, Logger=MagicMock(), Timer=MagicMock(), builtin=MagicMock(), unit=MagicMock())
    uipc.view = lambda what: np.zeros((4, 4, 4))
    uipc.Vector12 = MagicMock()
    sys.modules |= {"uipc": uipc, "polyscope": MagicMock(), **{f"uipc.{name}": part for name, part in parts.items()}}


def mends(coupler: Any, entities: dict[str, Any], restore: Callable[[Any], None]) -> dict[str, Any]:
    """Give the coupler states as libuipc would, and return what the fixes make of them."""
    from genesis.engine.couplers.ipc_coupler.data import ABDLinkEntry, IPCCouplingData

    pose, rate = np.eye(4), np.zeros((4, 4))
    pose[:3, :3], pose[:3, 3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]], [0.1, 0.2, 0.9]
    rate[:3, :3], rate[:3, 3] = np.array([[0, -4, 0], [4, 0, 0], [0, 0, 0]]) @ pose[:3, :3], [1, 2, 3]
    plate = entities["plate"]
    coupler._abd_data_by_link = {plate.base_link: [ABDLinkEntry(transform=pose, velocity=rate)]}
    restore(coupler)
    found = [plate.get_pos(), plate.get_quat(), plate.get_vel(), plate.get_ang()]

    forces: list[np.ndarray] = []
    links = [plate.base_link, entities["clamp"].links[-1]]
    data = IPCCouplingData(links, {link: [row] for row, link in enumerate(links)}, 1)
    data.ipc_transforms[:], data.aim_transforms[:] = pose, pose
    data.ipc_transforms[..., 2, 3] += 0.001
    coupler._coupling_data = data
    coupler._constraint_strength_translation_scaled = coupler._constraint_strength_rotation_scaled = 1e4
    coupler.rigid_solver.apply_links_external_wrench = lambda force, *_, **__: forces.append(force.copy())
    coupler._apply_abd_coupling_forces()
    return {
        "restored": [round(float(x), 5) for tensor in found for x in tensor.cpu().numpy().ravel()],
        "lift": [float(force[2]) / link.desc.mass for force, link in zip(forces[0], links, strict=True)],
    }


def main() -> None:
    """Build the scene, say how it went."""
    program, *flags = sys.argv[1:]
    stand_in(device=not flags)
    sys.path.insert(0, program)
    import genesis as gs
    import ipc_coupler
    from bodies import add_bodies
    from genesis.engine.couplers.ipc_coupler.coupler import IPCCoupler
    from scene import add_statics, make_scene, start_engine

    # What follows the coupler's checks needs libuipc itself.
    IPCCoupler._init_accessors = IPCCoupler.couple = IPCCoupler.reset = lambda *_, **__: None
    start_engine(gs.cpu)
    restore, ipc_coupler._restore = ipc_coupler._restore, lambda _: None
    scene = make_scene()
    entities = {**add_statics(scene), **add_bodies(scene)}
    failure = ""
    try:
        scene.build()
    except Exception as error:
        failure = f"{type(error).__name__}: {error}"
    coupler = scene.sim.coupler
    kinds = {e: kind.name.lower() for e, kind in coupler._coup_type_by_entity.items()}
    coupled = {name: kinds[entity] for name, entity in entities.items() if entity in kinds}
    labels = {
        element.label: name
        for name, entity in entities.items()
        for table in ("_ipc_cloth_contacts", "_ipc_fem_contacts", "_ipc_abd_contacts", "_ipc_ground_contacts")
        if (element := getattr(coupler, table).get(entity)) is not None
    }
    pairs = [[labels.get(a, a), labels.get(b, b), friction] for a, b, friction, enabled in contacts if enabled]
    mended = mends(coupler, entities, restore) if not failure else {}
    print("RESULT " + json.dumps({"failure": failure, "coupled": coupled, "pairs": pairs, **mended}))


if __name__ == "__main__":
    main()
