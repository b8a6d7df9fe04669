"""Events that the program itself has to see, because something is released on them.

They are those that are found later in the recording, by the same rules: contacts in every substep, all else by what
passes zero on a straight line between two steps.
"""

import genesis as gs
import numpy as np
from points import Points, array, choose

GAP = 2
"""Steps without contact that do not end a touch: touches flicker in a discrete simulation."""
REDUCE = {
    "max": np.max,
    "min": np.min,
    "mean": np.mean,
    "std": np.std,
    "sum": np.sum,
    "range": np.ptp,
}


class Triggers:
    """Looks for the events at every step; `happened` says when each was seen first [s].

    Args:
        dt: Length of a step [s].
        watches: Of each event its name, what watches for it, and the name of an event that has to come first, or None.
    """

    def __init__(self, dt, watches):
        self.dt, self.watches, self.happened = dt, watches, {}

    def __call__(self, t):
        """Look at what is there before the step that begins at t [s]."""
        for name, watch, after in self.watches:
            moment = watch(round(t / self.dt), self.dt)
            since = self.happened.get(after)
            if moment is None or name in self.happened or (after is not None and (since is None or moment <= since)):
                continue
            self.happened[name] = moment


class Touch:
    """Something of one list of links begins to touch something of another."""

    def __init__(self, scene, first, second):
        self.solver, self.groups = scene.rigid_solver, []
        for things in (first, second):
            group = np.full(self.solver.n_links, -1)
            for number, links in enumerate(things):
                group[[link.idx for link in links]] = number
            self.groups.append(group)
        self.last, self.now = {}, set()
        substep = self.solver.substep

        def watched(f):
            substep(f)
            self._gather()

        self.solver.substep = watched

    def _gather(self):
        contacts = self.solver.collider.get_contacts(as_tensor=True, to_torch=False)
        first, second = self.groups
        for a, b in ((contacts["link_a"], contacts["link_b"]), (contacts["link_b"], contacts["link_a"])):
            itself = (first[a] == first[b]) & (second[a] == second[b])
            rows = (first[a] >= 0) & (second[b] >= 0) & ~itself
            self.now.update(zip(first[a[rows]].tolist(), second[b[rows]].tolist(), strict=True))

    def __call__(self, step, dt):
        """Return the time [s] of a touch that began in the last step, or None."""
        begun = any(step - self.last.get(pair, -GAP - 2) > GAP + 1 for pair in self.now)
        self.last.update(dict.fromkeys(self.now, step))
        self.now = set()
        return step * dt if begun else None


class Crossing:
    """One of several numbers rises from below zero."""

    def __init__(self, heights):
        self.heights, self.before = heights, None

    def __call__(self, step, dt):
        """Return the time [s] at which one first did so in the last step, or None."""
        now = np.array([height() for height in self.heights])
        before, self.before = self.before, now
        if before is None or not (crossed := (before < 0.0) & (now >= 0.0)).any():
            return None
        return (step - 1 + (before[crossed] / (before[crossed] - now[crossed])).min()) * dt


# --- places and speeds: functions without arguments ---------------------------------------------------------------


def main_link(body):
    """The first link of a body that is not the world."""
    return next(link for link in body.links if link.name != "world")


def links(body, link=None):
    """Return the links that are meant: one, or all of a body."""
    return [body.get_link(link)] if link else body.links


def origin(scene, body, link=None):
    """Return a function: position of the frame of a body [m].

    Args:
        scene: The built scene.
        body: A body of links.
        link: Name of the link; the main one if None.
    """
    index = (body.get_link(link) if link else main_link(body)).idx
    return lambda: array(scene.rigid_solver.get_links_pos([index], relative=True)).reshape(3)


def velocity(scene, body, link=None):
    """Return a function: velocity of the centre of mass of a body [m/s].

    Args:
        scene: The built scene.
        body: A body of links.
        link: Name of the only link that counts; all links if None.
    """
    chosen = [one.idx for one in links(body, link)]
    masses = np.array([one.get_mass() for one in links(body, link)])
    get, ref = scene.rigid_solver.get_links_vel, gs.link_ref_frame.link_COM
    return lambda: masses @ array(get(chosen, ref=ref)).reshape(-1, 3) / masses.sum()


def center(body, pose=None, region=None):
    """Return a function: centre of mass of a deformable body, or mean position of a region [m].

    Args:
        body: The deformable body.
        pose: Pose of its frame at the start: position [m], quaternion.
        region: The part of it that counts; all of it if None.
    """
    points, weights = _weights(body, pose, region)
    return lambda: weights @ points.positions()


def center_velocity(body, pose=None, region=None):
    """Return a function: velocity of the centre of mass of a deformable body, or mean of a region [m/s].

    Args:
        body: The deformable body.
        pose: Pose of its frame at the start: position [m], quaternion.
        region: The part of it that counts; all of it if None.
    """
    points, weights = _weights(body, pose, region)
    return lambda: weights @ points.velocities()


def _weights(body, pose, region):
    points = Points(body)
    if region is None:
        return points, points.masses / points.masses.sum()
    weights, chosen = np.zeros(len(points.rest)), choose(points, pose, region)
    weights[chosen] = 1.0 / len(chosen)
    return points, weights


# --- numbers: functions without arguments -------------------------------------------------------------------------


def joint(scene, body, name):
    """Return a function: position of a hinge [rad] or slider [m].

    Args:
        scene: The built scene.
        body: The articulated body.
        name: Name of the joint.
    """
    index = body.get_joint(name).qs_idx[0]
    return lambda: array(scene.rigid_solver.get_qpos([index])).item()


def coordinate(vector, axis):
    """One component of a vector."""
    return lambda: vector()[axis]


def size(vector):
    """Length of a vector."""
    return lambda: np.linalg.norm(vector())


def moved(place, axis=None):
    """How far something is from where it is now [m], or by how much along an axis."""
    start = place()
    return (lambda: np.linalg.norm(place() - start)) if axis is None else (lambda: (place() - start)[axis])


def distance(pairs):
    """Distance of the nearest pair of places [m]."""
    return lambda: min(np.linalg.norm(first() - second()) for first, second in pairs)


def since_start(value):
    """How much a number has changed since now."""
    start = value()
    return lambda: value() - start


def reduce(how, values):
    """One number for several."""
    return lambda: REDUCE[how]([value() for value in values])


def above(value, bound):
    """How far a number is above a bound."""
    return lambda: value() - bound


def below(value, bound):
    """How far a number is below a bound."""
    return lambda: bound - value()


# --- regions: how deep a place lies in one [m], negative outside --------------------------------------------------


def in_box(place, low, high):
    """Return a function: depth inside an upright box [m], negative outside.

    Args:
        place: Returns the position [m].
        low: Lowest corner [m].
        high: Highest corner [m].
    """
    return lambda: np.minimum(place() - low, high - place()).min()


def in_ball(place, middle, radius):
    """Return a function: depth inside a ball [m], negative outside.

    Args:
        place: Returns the position [m].
        middle: Centre [m].
        radius: Radius [m].
    """
    return lambda: radius - np.linalg.norm(place() - middle)


def in_cylinder(place, middle, axis, radius, height):
    """Return a function: depth inside a cylinder [m], negative outside.

    Args:
        place: Returns the position [m].
        middle: Centre [m].
        axis: Unit vector along its axis.
        radius: Radius [m].
        height: Height [m].
    """

    def depth():
        offset = place() - middle
        along = offset @ axis
        return min(radius - np.linalg.norm(offset - along * np.array(axis)), height / 2.0 - abs(along))

    return depth


def outside(depth):
    """The other way round."""
    return lambda: -depth()
