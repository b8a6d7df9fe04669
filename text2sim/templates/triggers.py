"""Events that the program detects while it runs, because something is released on them.

The same rules find them later in the recording: touches by the contacts of every substep, all others by the zero
crossing of a number, interpolated linearly between two steps. Rest is known only when it has lasted.
"""

import genesis as gs
import numpy as np
from points import Points, array, choose

GAP = 2
"""Steps without contact that do not end a touch: contacts flicker in a discrete simulation."""
REDUCE = {
    "max": np.max,
    "min": np.min,
    "mean": np.mean,
    "std": np.std,
    "sum": np.sum,
    "range": np.ptp,
}


class Triggers:
    """Watches for the events at every step.

    `happened` has the time [s] at which the program acts on the first occurrence of each: that of the event itself, or
    for rest, which is known only later, when it has lasted.

    Args:
        dt: Time step [s].
        watches: Rows (event, watch, event that must come first or None), each behind the event that it waits for.
    """

    def __init__(self, dt, watches):
        self.dt, self.watches, self.began, self.happened = dt, watches, {}, {}

    def __call__(self, t):
        """Call every watch before the step that begins at t [s]."""
        for name, watch, after in self.watches:
            if name in self.began:
                continue
            watch(round(t / self.dt), self.dt, self.happened)
            since = -np.inf if after is None else self.began.get(after)
            if since is not None and (moment := watch.first(since)) is not None:
                self.began[name], self.happened[name] = moment, moment + watch.lasts


class Moments:
    """Watches for moments. All are kept: what they have to come after may be known only later."""

    lasts = 0.0

    def __init__(self):
        self.moments = []

    def __call__(self, step, dt, happened):
        """Note whether it happened in the step that ends now."""
        moment = self.moment(step, dt)
        if moment is not None:
            self.moments.append(moment)

    def first(self, since):
        """Return the first time [s] after another, or None."""
        return next((moment for moment in self.moments if moment > since), None)


class Touch(Moments):
    """Watches for the beginning of contact between links of two groups.

    Args:
        scene: The built scene.
        first: Bodies of the one group, each a list of its links.
        second: Bodies of the other group, likewise.
    """

    def __init__(self, scene, first, second):
        super().__init__()
        self.solver, self.groups = scene.rigid_solver, []
        for things in (first, second):
            group = np.full(self.solver.n_links, -1)
            for number, links in enumerate(things):
                group[[link.idx for link in links]] = number
            self.groups.append(group)
        self.last, self.now = {}, set()
        # Contacts exist only within a substep, and the engine has no callback.
        substep = self.solver.substep

        def watched(f):
            substep(f)
            self._gather()

        self.solver.substep = watched

    def _gather(self):
        contacts = self.solver.collider.get_contacts(as_tensor=True, to_torch=False)
        first, second = self.groups
        for a, b in ((contacts["link_a"], contacts["link_b"]), (contacts["link_b"], contacts["link_a"])):
            same_body = (first[a] == first[b]) & (second[a] == second[b])
            rows = (first[a] >= 0) & (second[b] >= 0) & ~same_body
            self.now.update(zip(first[a[rows]].tolist(), second[b[rows]].tolist(), strict=True))

    def moment(self, step, dt):
        """Return the time [s] of a touch that began in the last step, or None."""
        begun = any(step - self.last.get(pair, -GAP - 2) > GAP + 1 for pair in self.now)
        self.last.update(dict.fromkeys(self.now, step))
        self.now = set()
        return step * dt if begun else None


class Crossing(Moments):
    """Watches for the first of several numbers to rise through zero."""

    def __init__(self, heights):
        super().__init__()
        self.heights, self.before = heights, None

    def moment(self, step, dt):
        """Return the time [s] of the first crossing in the last step, or None."""
        now = np.array([height() for height in self.heights])
        before, self.before = self.before, now
        if before is None or not (crossed := (before < 0.0) & (now >= 0.0)).any():
            return None
        return (step - 1 + (before[crossed] / (before[crossed] - now[crossed])).min()) * dt


class Deed(Moments):
    """Watches for what the program itself does, such as a release.

    Args:
        whens: When it does so: times [s] and events.
    """

    def __init__(self, whens):
        super().__init__()
        self.whens = set(whens)

    def __call__(self, step, dt, happened):
        """Note what is due in the step that begins now."""
        for when in list(self.whens):
            moment = happened.get(when) if isinstance(when, str) else when
            if moment is not None and moment <= step * dt + 1e-9:
                self.whens.remove(when)
                self.moments.append(moment)


class Rest:
    """Watches for several speeds to be small at the same time, for a while.

    Args:
        speeds: Rows of the name of a body and a function that gives its speed [m/s].
        most: Largest speed of bodies at rest [m/s].
        lasts: Shortest time at rest [s].
        gone: Names of removed bodies, which do not count.
    """

    def __init__(self, speeds, most, lasts, gone=()):
        def slowness():
            return most - max((speed() for name, speed in speeds if name not in gone), default=np.inf)

        self.crossing = Crossing([slowness])
        self.lasts, self.spans, self.quiet = lasts, [], False

    def __call__(self, step, dt, happened):
        """Note whether all are at rest now, and since when."""
        begin = self.crossing.moment(step, dt)
        was, self.quiet = self.quiet, self.crossing.before[0] >= 0.0
        if self.quiet and not was:
            self.spans.append([step * dt if begin is None else begin, 0.0])
        if self.quiet:
            self.spans[-1][1] = step * dt

    def first(self, since):
        """Return the first time [s], from another on, at which a rest begins that lasts; None if there is none."""
        spans = ((max(begin, since), end) for begin, end in self.spans)
        return next((begin for begin, end in spans if end - begin >= self.lasts - 1e-9), None)


# --- places and speeds: functions without arguments ---------------------------------------------------------------


def main_link(body):
    """Return the first link of a body that is not the world."""
    return next(link for link in body.links if link.name != "world")


def links(body, link=None):
    """Return a list of the named link of a body, or of all its links."""
    return [body.get_link(link)] if link else body.links


def origin(scene, body, link=None):
    """Return a function that gives the position of a link's frame [m].

    Args:
        scene: The built scene.
        body: A body of links.
        link: Name of the link; the main one if None.
    """
    index = (body.get_link(link) if link else main_link(body)).idx
    return lambda: array(scene.rigid_solver.get_links_pos([index], relative=True)).reshape(3)


def velocity(scene, body, link=None):
    """Return a function that gives the velocity of the centre of mass of a body [m/s].

    Args:
        scene: The built scene.
        body: A body of links.
        link: Name of a link; all links if None.
    """
    chosen = [one.idx for one in links(body, link)]
    masses = np.array([one.get_mass() for one in links(body, link)])
    get, ref = scene.rigid_solver.get_links_vel, gs.link_ref_frame.link_COM
    return lambda: masses @ array(get(chosen, ref=ref)).reshape(-1, 3) / masses.sum()


def center(body, pose=None, region=None):
    """Return a function that gives the centre of mass of a deformable body, or the mean position of a region [m].

    Args:
        body: The deformable body.
        pose: Pose of its frame at the start: position [m], quaternion.
        region: The part of it that counts; all of it if None.
    """
    points, weights = _weights(body, pose, region)
    return lambda: weights @ points.positions()


def center_velocity(body, pose=None, region=None):
    """Return a function that gives the velocity of the centre of mass of a deformable body, or of a region [m/s].

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
    """Return a function that gives the position of a hinge [rad] or slider [m].

    Args:
        scene: The built scene.
        body: The articulated body.
        name: Name of the joint.
    """
    index = body.get_joint(name).qs_idx[0]
    return lambda: array(scene.rigid_solver.get_qpos([index])).item()


def coordinate(vector, axis):
    """Return a function that gives one component of a vector."""
    return lambda: vector()[axis]


def norm(vector):
    """Return a function that gives the length of a vector."""
    return lambda: np.linalg.norm(vector())


def displacement(place, axis=None):
    """Return a function that gives the distance from the present place, or the displacement along an axis [m]."""
    start = place()
    return (lambda: np.linalg.norm(place() - start)) if axis is None else (lambda: (place() - start)[axis])


def distance(pairs):
    """Return a function that gives the smallest distance of several pairs of places [m]."""
    return lambda: min(np.linalg.norm(first() - second()) for first, second in pairs)


def since_start(value):
    """Return a function that gives the change of a number from its present value."""
    start = value()
    return lambda: value() - start


def reduce(how, values):
    """Return a function that reduces several numbers to one; `how` is a key of `REDUCE`."""
    return lambda: REDUCE[how]([value() for value in values])


def above(value, bound):
    """Return a function that gives how far a number is above a bound, negative below."""
    return lambda: value() - bound


def below(value, bound):
    """Return a function that gives how far a number is below a bound, negative above."""
    return lambda: bound - value()


# --- depth of a place inside a region [m], negative outside -------------------------------------------------------


def in_box(place, low, high):
    """Return a function that gives the depth inside an axis-aligned box [m], negative outside.

    Args:
        place: Returns the position [m].
        low: Lowest corner [m].
        high: Highest corner [m].
    """
    return lambda: np.minimum(place() - low, high - place()).min()


def in_ball(place, middle, radius):
    """Return a function that gives the depth inside a ball [m], negative outside.

    Args:
        place: Returns the position [m].
        middle: Centre [m].
        radius: Radius [m].
    """
    return lambda: radius - np.linalg.norm(place() - middle)


def in_cylinder(place, middle, axis, radius, height):
    """Return a function that gives the depth inside a cylinder [m], negative outside.

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
    """Return a function that gives the depth outside a region instead of inside it."""
    return lambda: -depth()
