"""Removes bodies from the scene during a run.

A removed body stays where it is, but without contacts, weight, speed or image. It is not moved, so a removal cannot be
used to place a body.
"""

import numpy as np


class Removals:
    """Removes bodies at their times or events.

    Args:
        scene: Built scene.
        rows: Name and entity of each body, and when it is removed: a time [s] or the name of an event.
        removed_at: Dictionary that receives the time of removal [s] by name.
        happened: First times of events [s].
    """

    def __init__(self, scene, rows, removed_at, happened=None):
        self.solver, self.waiting, self.removed_at = scene.rigid_solver, list(rows), removed_at
        self.happened = {} if happened is None else happened
        self.links = set()

    def __call__(self, t):
        """Remove the bodies that are due before the step that begins at t [s]."""
        for row in list(self.waiting):
            name, entity, when = row
            due = when in self.happened if isinstance(when, str) else t >= when - 1e-9
            if not due:
                continue
            self.waiting.remove(row)
            if name not in self.removed_at:
                self.removed_at[name] = t
                self.links.update(link.idx for link in entity.links)
                switch_off(self.solver, entity)


def switch_off(solver, entity):
    """Take a body out of all contacts, cancel its weight and stop it."""
    geoms = [geom.idx for geom in entity.geoms]
    collider = solver.collider
    pairs = collider.collider_info.collision_pair_idx
    table = pairs.to_numpy()
    table[geoms, :] = table[:, geoms] = -1
    pairs.from_numpy(table)
    # The engine reuses pairs of the previous broad phase, which must not contain disabled pairs.
    collider.collider_state.n_broad_pairs.fill(0)
    collider.clear()
    _set(solver.dyn_info.geoms.needs_coup, geoms, 0)  # contact with mpm and pbd bodies
    _set(solver.dyn_info.entities.gravity_compensation, [solver.entities.index(entity)], 1.0)
    if entity.n_dofs:
        entity.set_dofs_velocity(np.zeros(entity.n_dofs))


def _set(field, rows, value):
    values = field.to_numpy()
    values[rows] = value
    field.from_numpy(values)
