"""Keeps contacts stiff between bodies of different restitution.

Genesis 1.4.5 averages the time constants and the damping ratios of both geometries. The stiffness of a contact is
proportional to 1 / (time constant x ratio)^2, so the contact between a body that bounces and one that does not would
be up to 15 times softer than the contacts of either. Here a contact gets the mean ratio, and a time constant that keeps
it stiff.
"""

import genesis as gs
import torch
from contacts import edit_contacts


def even_contacts(bodies, damping, link_damping, silent):
    """Set time constant and damping ratio of every contact before its force is computed.

    Args:
        bodies: Entities of a built scene by name.
        damping: Time constant [s] and damping ratio by body.
        link_damping: Time constant [s] and damping ratio of links that have their own, by body and link.
        silent: Bodies that take the ratio of whatever touches them.
    """
    solver = next(bodies[name].solver for name in damping)
    ratios = torch.ones(solver.n_geoms, dtype=gs.tc_float, device=gs.device)
    hardness = ratios.clone()
    chosen = [(bodies[name], name in silent, value) for name, value in damping.items()]
    chosen += [(bodies[name].get_link(link), False, value) for (name, link), value in link_damping.items()]
    for body, follows, (time, ratio) in chosen:
        geoms = [geom.idx for geom in body.geoms]
        ratios[geoms], hardness[geoms] = torch.nan if follows else ratio, time * ratio

    def change(settings, a, b):
        ratio = torch.stack((ratios[a], ratios[b])).nanmean(dim=0).nan_to_num(1.0)
        settings[:, 0], settings[:, 1] = (hardness[a] + hardness[b]) / 2 / ratio, ratio

    edit_contacts(solver, "sol_params", change)
