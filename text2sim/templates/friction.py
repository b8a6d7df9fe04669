"""Gives pairs of bodies their own coefficient of friction.

Genesis 1.4.5 has one coefficient per geometry, and a contact takes the larger of the two. It stores the coefficient
with each contact before it solves for the forces; the values of the chosen pairs are replaced there.
"""

import genesis as gs
import torch
from contacts import edit_contacts


def set_friction(bodies, rows):
    """Set the friction of pairs; if several rows apply to a pair, the last one counts.

    Args:
        bodies: Entities of a built scene by name.
        rows: Names of bodies, their link or None for all, names and link of the bodies they touch, coefficient.
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
