"""Records all contacts of every step, and lets properties of contacts be changed before their forces are computed."""

import genesis as gs
import numpy as np
from genesis.utils.misc import qd_to_numpy, qd_to_torch

CONTACTS_IN_HAND = 200_000
NO_CONTACTS = [np.zeros(0, int)] * 2 + [np.zeros((0, 3), np.float32)] * 3 + [np.zeros(0, np.float32)]


def in_place() -> bool:
    """Whether fields of the engine can be read without a copy."""
    return gs.use_zerocopy and gs.backend == gs.cpu


def edit_contacts(solver, name, change):
    """Change one property of all contacts in every substep, before their forces are computed.

    Args:
        solver: The rigid solver of a built scene.
        name: Name of the property: `friction` or `sol_params`.
        change: Called with the values (n, …), which it changes in place, and the indices of both geometries, (n,) each.
    """
    state, detect = solver.collider.collider_state, solver.collider.detection
    data, field = state.contact_data, getattr(state.contact_data, name)

    def view(one):
        return qd_to_torch(one, copy=not gs.use_zerocopy)

    def detection():
        detect()
        count = int(view(state.n_contacts)[0])
        if count:
            # Contacts that the engine dropped keep their rows: those that count can lie beyond the first `count`.
            live, values = view(state.contact_sort_idx)[:count, 0].long(), view(field)
            chosen = values[live, 0]
            change(chosen, view(data.geom_a)[live, 0].long(), view(data.geom_b)[live, 0].long())
            values[live, 0] = chosen
            if not gs.use_zerocopy:
                field.from_torch(values)

    solver.collider.detection = detection


def part_of(geom) -> str:
    """Returns the part of a compound that a geometry belongs to; the compiler puts it in its name, behind an `@`."""
    return str(geom.metadata.get("name", "")).partition("@")[2]


def surfaces_of(solver) -> tuple[list[tuple[int, str]], np.ndarray]:
    """Returns what contacts are told apart by, and the number of it for every collision geometry, (G,).

    A surface is a link, or a part of a compound: (link index, name of the part or ""), sorted.
    """
    of_geoms = [(geom.link.idx, part_of(geom)) for geom in (solver.geoms if solver.is_active else ())]
    surfaces = sorted({*of_geoms, *((link, "") for link in range(solver.n_links))})
    number = {surface: i for i, surface in enumerate(surfaces)}
    return surfaces, np.array([number[surface] for surface in of_geoms], int)


class Contacts:
    """Gathers the contacts of every step, and sums them per pair of links, or of parts of compounds.

    On the CPU it reads the solver's buffers in place, which takes 10 us a substep; `collider.get_contacts` takes 70 us.
    Forces are means over the substeps of a step, so that force times dt is the impulse of the contact.
    """

    def __init__(self, solver):
        self._collider, self._views = solver.collider if solver.is_active else None, None
        surfaces, self._surface_of_geom = surfaces_of(solver)
        self.parts = [surface for surface in surfaces if surface[1]]  # (link index, name) of parts of compounds
        self._link = np.array([link for link, _ in surfaces], np.int32)
        part = {surface: i for i, surface in enumerate(self.parts)}
        self._part = np.array([part.get(surface, -1) for surface in surfaces], np.int32)
        self._steps, self._rows, self._sums, self._in_hand = [], [NO_CONTACTS], [], 0
        if self._collider is not None and in_place():
            state = self._collider.collider_state
            data = state.contact_data
            self._count = qd_to_numpy(state.n_contacts, copy=False)
            self._order = qd_to_numpy(state.contact_sort_idx, transpose=True, copy=False)[0]
            fields = data.geom_a, data.geom_b, data.pos, data.normal, data.force, data.penetration
            self._views = [qd_to_numpy(field, transpose=True, copy=False)[0] for field in fields]

    def gather(self, step: int) -> None:
        """Reads the contacts once; `step` is the number of the current step, from 1."""
        if self._collider is None:
            return
        if self._views is not None:
            live = self._order[: self._count[0]]
            row = [view[live] for view in self._views]
        else:
            contacts = self._collider.get_contacts(as_tensor=True, to_torch=False)
            row = [contacts[name] for name in ("geom_a", "geom_b", "position", "normal", "force", "penetration")]
        self._steps.append((step, len(row[0])))
        self._rows.append(row)
        self._in_hand += len(row[0])

    def end_step(self, step: int) -> None:
        """Ends a step; reads the contacts if `gather` was not called during it."""
        if not self._steps or self._steps[-1][0] != step:
            self.gather(step)
        if self._in_hand > CONTACTS_IN_HAND:
            self._sum()

    def take(self, keep: bool = False) -> dict[str, np.ndarray]:
        """Returns the contacts since the last call: n rows, sorted by step, then link.

        There is one row per step and pair of links, or of their parts, where they are compounds.

        Args:
            keep: Whether the next call returns them again, together with later ones.

        Returns:
            contact_step (n,): Step in which the pair touched, 1 being the first.
            contact_links (n, 2): Link indices a < b.
            contact_parts (n, 2): Indices of their parts in `parts`; -1 without parts.
            contact_force (n, 3): Force on b [N], mean over the substeps; a feels the opposite.
            contact_normal_force (n,): Sum of the magnitudes along the contact normals [N], mean over the substeps.
            contact_pos (n, 3): Mean position of the contact points, weighted by force [m].
            contact_penetration (n,): Deepest overlap [m].
            contact_count (n,): Number of contact points, mean over the substeps, rounded up.
        """
        self._sum()
        taken = {name: np.concatenate([part[name] for part in self._sums]) for name in self._sums[0]}
        self._sums = [taken] if keep else []
        return taken

    def _sum(self) -> None:
        steps, sizes = np.array(self._steps or [(0, 0)]).T
        step = np.repeat(steps, sizes)
        looks = np.bincount(steps - steps[0]).astype(np.float32)
        a, b, pos, normal, force, depth = (np.concatenate(column) for column in zip(*self._rows, strict=True))
        a, b, n = self._surface_of_geom[a], self._surface_of_geom[b], len(self._link)
        low, high = np.minimum(a, b), np.maximum(a, b)
        key = (step * n + low) * n + high
        order = np.argsort(key, kind="stable")
        first = np.flatnonzero(np.diff(key[order], prepend=-1))
        share = 1 / looks[step[order] - steps[0]]
        force, pos = np.where((a > b)[:, None], -force, force)[order] * share[:, None], pos[order]
        along = np.abs(np.einsum("ij,ij->i", force, normal[order]))
        weight = np.linalg.norm(force, axis=1, keepdims=True) + np.float32(1e-9)
        mean = np.add.reduceat(pos * weight, first) / np.add.reduceat(weight, first)
        pair = np.stack([low, high], axis=1)[order][first]
        self._sums.append(
            {
                "contact_step": step[order][first].astype(np.int32),
                "contact_links": self._link[pair],
                "contact_parts": self._part[pair],
                "contact_force": np.add.reduceat(force, first).astype(np.float32),
                "contact_normal_force": np.add.reduceat(along, first).astype(np.float32),
                "contact_pos": mean.astype(np.float32),
                "contact_penetration": np.maximum.reduceat(depth[order], first).astype(np.float32),
                "contact_count": np.ceil(np.add.reduceat(share, first) - 1e-3).astype(np.int32),
            }
        )
        self._steps, self._rows, self._in_hand = [], [NO_CONTACTS], 0
