"""Takes bodies out of the scene in the middle of a run.

A body is switched off where it is: nothing touches it any more, it has no weight and no speed, and no picture shows it.
It is not moved, so that nothing can be put anywhere by this way.
"""

import numpy as np


class Removals:
    """Switches bodies off when their time has come.

    Args:
        scene: Built scene.
        rows: Of each body its name, the entity, and when: a time [s], or the name of an event.
        gone: Gets the time [s] at which each went, by its name.
        happened: First times of events [s].
    """

    def __init__(self, scene, rows, gone, happened=None):
        self.solver, self.waiting, self.gone = scene.rigid_solver, rows, gone
        self.happened = {} if happened is None else happened
        self.links = set()

    def __call__(self, t):
        """Do what is to be done before the step that begins at t [s]."""
        for row in list(self.waiting):
            name, entity, when = row
            due = when in self.happened if isinstance(when, str) else t >= when - 1e-9
            if not due:
                continue
            self.waiting.remove(row)
            if name not in self.gone:
                self.gone[name] = t
                self.links.update(link.idx for link in entity.links)
                switch_off(self.solver, entity)


def switch_off(solver, entity):
    """Let nothing touch a body, and nothing move it."""
    geoms = [geom.idx for geom in entity.geoms]
    collider = solver.collider
    pairs = collider.collider_info.collision_pair_idx
    table = pairs.to_numpy()
    table[geoms, :] = table[:, geoms] = -1
    pairs.from_numpy(table)
    # The engine looks up the pairs that were near before, which must not be those that are none any more.
    collider.collider_state.n_broad_pairs.fill(0)
    collider.clear()
    _set(solver.dyn_info.geoms.needs_coup, geoms, 0)  # what mpm and pbd bodies feel
    _set(solver.dyn_info.entities.gravity_compensation, [solver.entities.index(entity)], 1.0)
    if entity.n_dofs:
        entity.set_dofs_velocity(np.zeros(entity.n_dofs))


def _set(field, rows, value):
    values = field.to_numpy()
    values[rows] = value
    field.from_numpy(values)
