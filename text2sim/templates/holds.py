"""Points of deformable bodies that are held by the world, or by links that carry them.

A link moves its points. Those of mpm and pbd bodies act on the link, too, if it can be moved.

    fem   vertices are placed where the link will be, in every substep; the prediction neglects its acceleration
    pbd   particles are placed in every step, and move with the link's velocity in between
          two-way: they are placed in every substep, and the pull of the threads becomes a force on the link
          breakable: likewise, but a link that nothing moves only counts the force
    mpm   springs pull particles after every substep; what that changes becomes a force on the link
"""

import genesis as gs
import numpy as np
import torch
from genesis.engine.couplers import SAPCoupler
from mpm_holds import Carried, Carrying
from points import INVERSE, Points, array, assign, choose, each_substep, rotate, tensor
from two_way_holds import Mutual, carry

SHAKY = 0.8
"""Angular frequency of springs times substep above which they vibrate. At 2 they are unstable."""


class Hold:
    """Holds points of a body from a given time on.

    Args:
        scene: The built scene, before its first step.
        body: The deformable body.
        pose: Pose of its frame at the start: position [m], quaternion.
        region: Region that is held, one of the functions of `points.py`.
        count: Number of points of the region, evenly spread; None: all.
        to: Links that hold it; each takes the points nearest to it. If empty, the world holds them.
        stiffness: Total stiffness of the springs [N/m]; None: hold firmly.
        both_ways: Whether the points act on the links; mpm and pbd only.
        loads: What keeps the load of each link, and says when it breaks; pbd only. None: the hold does not break.
        start: Time at which the hold begins [s].
        until: Times [s] or names of events; the first of them ends the hold.

    Raises:
        ValueError: If there are fewer points than links, or the springs are too stiff for the substep.
    """

    def __init__(
        self,
        scene,
        body,
        *,
        pose,
        region,
        count=None,
        to=(),
        stiffness=None,
        both_ways=False,
        loads=None,
        start=0.0,
        until=(),
    ):
        self.start, self.until, self.active, self.over = start, until, False, False
        self.rigid, self.links, self.clock, self.h = (
            scene.rigid_solver,
            [link.idx for link in to],
            0,
            scene.sim.substep_dt,
        )
        self.points = Points(body)
        self.share = count // len(to) if count is not None and len(to) > 1 else None
        if self.share == 0:
            raise ValueError(f"{count} points are too few for {len(to)} holders")
        self.chosen = choose(self.points, pose, region, None if self.share else count)
        self.stiffness, held = stiffness, self.share * len(to) if self.share else len(self.chosen)
        self.mass = self.points.masses[self.chosen].mean() * held
        if stiffness is not None and self.h * np.sqrt(stiffness / self.mass) > SHAKY:
            longest = np.sqrt(self.mass / stiffness)
            raise ValueError(
                f"springs of {stiffness:g} N/m on {self.mass:.3g} kg need substeps of at most {longest:.2g} s (they "
                f"last {self.h:.2g} s): make it softer, or leave `stiffness` out to hold firmly"
            )
        self.both_ways, self.loads = both_ways, loads
        pbd = Mutual if both_ways or loads is not None else _Placed
        self.grip = (_Fem if self.points.fem else Carried if self.points.mpm else pbd)(self)

    def begin(self):
        """Begin to hold: every point keeps its present place in the frame of its holder."""
        self.active = True
        at = self.points.positions()
        self.owner = np.zeros(len(self.chosen), dtype=int)
        if len(self.links) > 1:
            anchors = array(self.rigid.get_links_pos(self.links)).reshape(-1, 3)
            if self.share:
                taken = assign(anchors, at[self.chosen], self.share)
                self.owner, self.chosen = np.repeat(np.arange(len(anchors)), self.share), self.chosen[taken.ravel()]
            else:
                self.owner = np.linalg.norm(at[self.chosen, None] - anchors, axis=2).argmin(axis=1)
        self.at = at[self.chosen]
        self.look()
        self.local = self.at.copy()
        for k in range(len(self.links)):
            mine = self.owner == k
            self.local[mine] = rotate(self.quat[k] * INVERSE, self.at[mine] - self.pos[k])
        if self.loads is not None:
            held = [self.at[self.owner == k] for k in range(len(self.links))]
            self.loads.begin([at.mean(axis=0) if len(at) else self.pos[k] for k, at in enumerate(held)])
        self.grip.begin()

    def step(self, t):
        """Hold for the step that begins at t [s], unless the one that ended then has overloaded it."""
        self.grip.step()
        if self.loads is None:
            return
        given, self.grip.given = array(self.grip.given), self.grip.given * 0.0
        pulls = [np.linalg.norm(given[self.owner == k].sum(axis=0)) for k in range(len(self.links))]
        for k in self.loads.take(pulls, t):
            self.let_go(self.owner == k)

    def end(self):
        """Let go of all points."""
        self.let_go(np.ones(len(self.chosen), dtype=bool))

    def let_go(self, gone):
        """Let go of some of the points, given as a mask."""
        self.grip.drop(gone)
        self.chosen, self.owner, self.at, self.local = (
            some[~gone] for some in (self.chosen, self.owner, self.at, self.local)
        )
        if not len(self.chosen):
            self.active, self.over = False, True

    def look(self):
        """Read poses and velocities of the links."""
        if self.links:
            get = (
                self.rigid.get_links_pos,
                self.rigid.get_links_quat,
                self.rigid.get_links_vel,
                self.rigid.get_links_ang,
            )
            self.pos, self.quat, self.vel, self.ang = (
                array(one(self.links)).reshape(len(self.links), -1) for one in get
            )

    def carried(self, later):
        """Return positions [m] and velocities [m/s] of the held points `later` [s] from now, each (n, 3)."""
        if not self.links:
            return self.at, np.zeros_like(self.at)
        places, speeds = np.empty_like(self.at), np.empty_like(self.at)
        for k in range(len(self.links)):
            mine = self.owner == k
            arm = rotate(_turned(self.quat[k], self.ang[k] * later), self.local[mine])
            places[mine] = self.pos[k] + self.vel[k] * later + arm
            speeds[mine] = self.vel[k] + np.cross(self.ang[k], arm)
        return places, speeds


class Holds:
    """Begins and ends the holds at their times or events.

    Args:
        holds: The holds and seams.
        happened: Time [s] of each event that has happened.
        gone: Set of the links of removed bodies, which hold nothing any more.
    """

    def __init__(self, holds, happened=None, gone=frozenset()):
        self.holds, self.happened, self.gone = holds, {} if happened is None else happened, gone
        grips = [hold.grip for hold in holds if isinstance(hold, Hold)]
        self.place = _Placing([grip.hold for grip in grips if isinstance(grip, _Placed)])
        self.carry = Carrying([grip for grip in grips if isinstance(grip, Carried)])

    def __call__(self, t):
        """Update the holds before the step that begins at t [s]."""
        for hold in self.holds:
            if hold.over:
                continue
            if hold.active and any(self._is_over(hold, end, t) for end in hold.until):
                hold.end()
            elif not hold.active and t >= hold.start - 1e-9:
                hold.begin()
            for k, link in enumerate(hold.links if hold.active and self.gone else ()):
                if link in self.gone and (held := hold.owner == k).any():
                    hold.let_go(held)
            if hold.active:
                hold.step(t)
        self.place()
        self.carry()

    def report(self):
        """Return the loads of all that can break, as the rows of `Bonds.report`."""
        return [row for hold in self.holds if hold.loads is not None for row in hold.loads.report()]

    def _is_over(self, hold, end, t):
        if isinstance(end, str):  # an event before the hold began does not end it
            return self.happened.get(end, -1.0) >= hold.start
        return t >= end - 1e-9


class _Placed:
    """Particles that are placed in every step, by `_Placing`."""

    def __init__(self, hold):
        self.hold, self.entity = hold, hold.points.entity

    def begin(self):
        self.entity.fix_particles(self.hold.chosen, zero_velocity=False)

    def step(self):
        pass

    def drop(self, gone):
        let = self.hold.chosen[gone]
        if self.hold.rigid.is_active:
            self.entity.release_particle(let)
        else:  # `release_particle` needs links, and there are none
            chosen = torch.as_tensor(let[None] + self.entity.particle_start, dtype=gs.tc_int, device=gs.device)
            self.entity.solver._kernel_release_particle(chosen, torch.zeros(1, dtype=gs.tc_int, device=gs.device))


class _Placing:
    """Places the particles of many holds with one kernel, since calls of the engine for each hold add up."""

    def __init__(self, holds):
        self.holds, self.counts, self.carried, self.fixed = holds, [], None, None

    def __call__(self):
        counts = [len(hold.chosen) if hold.active else 0 for hold in self.holds]
        if counts != self.counts:
            self.counts = counts
            self._gather([hold for hold in self.holds if hold.active])
        if self.carried is not None:
            hold = self.holds[0]
            carry(hold.points.solver.particles, *self.carried, hold.h, hold.rigid.dyn_state.links)
        if self.fixed is not None:  # this makes their velocities zero, too
            self.holds[0].points.solver._kernel_set_particles_pos(*self.fixed)

    def _gather(self, active):
        self.carried, self.fixed = None, None
        if not active:
            return
        numbers = np.concatenate([hold.chosen + hold.points.entity.particle_start for hold in active])
        links = np.concatenate(
            [np.asarray(hold.links)[hold.owner] if hold.links else np.full(len(hold.owner), -1) for hold in active]
        )
        local = np.concatenate([hold.local for hold in active])
        # Of two holds of one particle, the later one has it.
        last = len(numbers) - 1 - np.unique(numbers[::-1], return_index=True)[1]
        of_links, of_world = last[links[last] >= 0], last[links[last] < 0]
        if len(of_links):
            self.carried = _integers(numbers[of_links]), _integers(links[of_links]), tensor(local[of_links])
        if len(of_world):
            self.fixed = _integers(numbers[of_world])[None], _integers([0]), tensor(local[of_world])[None]


class _Fem:
    """Vertices that are placed, or pulled by springs that are critically damped with respect to the link.

    Under the SAP coupler the engine's own constraint neither follows links nor has springs.
    """

    def __init__(self, hold):
        self.hold, self.entity, self.hooked = hold, hold.points.entity, False
        # Links move after the vertices under the SAP coupler, and before them under the others.
        self.ahead = hold.h if isinstance(self.entity.sim.coupler, SAPCoupler) else 0.0

    def begin(self):
        if self.hold.stiffness is None:
            self.entity.set_vertex_constraints(self.hold.chosen, tensor(self.hold.at))
        if not self.hooked and (self.hold.links or self.hold.stiffness is not None):
            self.hooked = True
            each_substep(self.entity.solver, self._substep)

    def step(self):
        pass

    def drop(self, gone):
        if self.hold.stiffness is None:
            self.entity.remove_vertex_constraints(self.hold.chosen[gone])

    def _substep(self):
        hold = self.hold
        if not hold.active:
            return
        hold.look()
        places, speeds = hold.carried(self.ahead)
        if hold.stiffness is None:
            self.entity.update_constraint_targets(hold.chosen, tensor(places))
            return
        at, velocities = hold.points.positions()[hold.chosen], hold.points.velocities()
        pull = hold.stiffness / hold.mass  # in proportion to mass, so that all vertices oscillate at one frequency
        off, fast = at - places, velocities[hold.chosen] - speeds
        # `expm1`, so that damping never reverses a velocity, however long the substep.
        velocities[hold.chosen] -= hold.h * pull * off - np.expm1(-2.0 * np.sqrt(pull) * hold.h) * fast
        hold.points.set_velocities(velocities)


def _integers(values):
    return torch.as_tensor(values, dtype=gs.tc_int, device=gs.device)


def _turned(quat, vector):
    """Return a quaternion, rotated further by a rotation vector [rad] in the world frame."""
    angle = np.linalg.norm(vector)
    if angle < 1e-12:
        return quat
    w, u = np.cos(angle / 2.0), np.sin(angle / 2.0) / angle * vector
    return np.concatenate([[w * quat[0] - u @ quat[1:]], w * quat[1:] + quat[0] * u + np.cross(u, quat[1:])])
