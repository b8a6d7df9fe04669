"""Gives pairs of bodies a coefficient of friction of their own.

Genesis 1.4.5 knows one coefficient for each geometry, and takes the larger of the two. It is written with each contact
before the contact forces are solved: there the pairs that have their own get it.
"""

import genesis as gs
import torch
from genesis.utils.misc import qd_to_torch


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
    state, detect = solver.collider.collider_state, solver.collider.detection
    data = state.contact_data

    def detection():
        detect()
        count = int(_view(state.n_contacts)[0])
        if count:
            pairs = own[_view(data.geom_a)[:count, 0].long(), _view(data.geom_b)[:count, 0].long()]
            friction = _view(data.friction)
            friction[:count, 0] = torch.where(pairs >= 0.0, pairs, friction[:count, 0])
            if not gs.use_zerocopy:
                data.friction.from_torch(friction)

    solver.collider.detection = detection


def _view(field):
    return qd_to_torch(field, copy=not gs.use_zerocopy)


def _geoms(bodies, names, link):
    chosen = [bodies[name].get_link(link) if link else bodies[name] for name in names]
    return torch.tensor([geom.idx for one in chosen for geom in one.geoms], device=gs.device)
