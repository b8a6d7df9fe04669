"""Fixes for faults of the engine's IPC coupler; only programs with contact model ipc contain them.

Bodies that only contact and gravity move (`ipc_only`) are computed by libuipc. Genesis 1.4.5 copies their poses into
its rigid solver, and then lets that solver make a step.
"""

import numpy as np
from genesis.engine.couplers.ipc_coupler.coupler import IPCCoupler
from genesis.engine.couplers.ipc_coupler.data import COUPLING_TYPE
from genesis.engine.solvers import RigidSolver
from genesis.utils.geom import T_to_trans_quat


def mend_ipc() -> None:
    """Applies the fixes. Call once per process, before the scene is built."""
    _mend_forces()
    _mend_states()


def _mend_forces() -> None:
    """Applies the springs between both solvers to the bodies that they tie, and to no others.

    Genesis 1.4.5 computes them for bodies of libuipc as well. As soon as one body of the scene has a joint, these grow
    a hundredfold with every step.
    """
    apply_forces = IPCCoupler._apply_abd_coupling_forces

    def apply_forces_to_tied(coupler):
        data = coupler._coupling_data
        if data is not None:
            kinds = [coupler._coup_type_by_entity[link.entity] for link in data.links]
            untied = [k for k, kind in enumerate(kinds) if kind == COUPLING_TYPE.IPC_ONLY]
            data.aim_transforms[:, untied] = data.ipc_transforms[:, untied]
        apply_forces(coupler)

    IPCCoupler._apply_abd_coupling_forces = apply_forces_to_tied


def _mend_states() -> None:
    """Ends every step with the poses and velocities that libuipc computed.

    After the step of the rigid solver, its bodies are where they would be after one step of free fall from rest: 1 mm
    too low at a time step of 10 ms, at a speed of 0.1 m/s.
    """
    step = RigidSolver.substep_post_coupling

    def step_and_restore(solver, f):
        step(solver, f)
        if isinstance(solver.sim.coupler, IPCCoupler):
            _restore(solver.sim.coupler)

    RigidSolver.substep_post_coupling = step_and_restore


def _restore(coupler: IPCCoupler) -> None:
    entities = coupler._entities_by_coup_type.get(COUPLING_TYPE.IPC_ONLY, [])
    entities = [entity for entity in entities if not entity.base_link.is_fixed]
    if not entities:
        return
    states = [coupler._abd_data_by_link[entity.base_link][0] for entity in entities]
    poses = [np.concatenate(T_to_trans_quat(state.transform)) for state in states]
    places = np.concatenate([np.arange(entity.q_start, entity.q_start + 7) for entity in entities])
    dofs = np.concatenate([np.arange(entity.dof_start, entity.dof_start + 6) for entity in entities])
    velocities = np.concatenate([_velocity(state) for state in states])
    solver = coupler.rigid_solver
    solver.set_dofs_velocity(velocities, dofs_idx=dofs, skip_forward=True)
    solver.set_qpos(np.concatenate(poses), qs_idx=places)


def _velocity(state) -> np.ndarray:
    """Returns linear and angular velocity of a body, shape (6,), from the rate of its transform."""
    spin = state.velocity[:3, :3] @ state.transform[:3, :3].T
    turn = (spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1])
    return np.array([*state.velocity[:3, 3], *turn]) / [1, 1, 1, 2, 2, 2]
