"""Gives pairs of bodies a coefficient of friction of their own.

Genesis 1.4.5 knows one coefficient for each geometry, and takes the larger of the two. It is written with each contact
before the contact forces are solved: there the pairs that have their own get it.
"""

import genesis as gs
import torch
from contacts import edit_contacts


def set_friction(bodies, rows):
    """Set the friction of pairs; where several rows apply, the last counts.

    Args:
        bodies: Entities of a built scene by name.
        rows: Names of bodies, a link of theirs or None, the same of what they touch, coefficient.
    """
    solver = bodies[rows[0][0][0]].solver
    own = torch.full((solver.n_geoms, solver.n_geoms), -1.0, dtype=gs.tc_float, device=gs.device)
    for first, link, second, other, friction in rows:
        a, b = _geoms(bodies, first, link), _geoms(bodies, second, other)
        own[a[:, None], b], own[b[:, None], a] = friction, friction

    def change(frictions, a, b):
        frictions[:] = torch.where(own[a, b] >= 0.0, own[a, b], frictions)

    edit_contacts(solver, "friction", change)


def _geoms(bodies, names, link):
    chosen = [bodies[name].get_link(link) if link else bodies[name] for name in names]
    return torch.tensor([geom.idx for one in chosen for geom in one.geoms], device=gs.device)
