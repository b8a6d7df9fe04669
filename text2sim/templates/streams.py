"""Streams: what comes out of a mouth during the run."""

import numpy as np

PIPE = 3.0  # length of the pipe behind a mouth, in distances of particles: two cells of the grid
GOLDEN = (5**0.5 - 1) / 2  # its multiples, modulo 1, are spread evenly
JITTER = 0.1  # offset of particles across the stream, in distances of particles: a perfect one would never bend or coil

STILL = 1e-3  # largest offset of what waits, in distances of particles: positions are rounded


class Stream:
    """Particles that come through a short pipe, which ends in a mouth, at a constant speed.

    The pipe holds them, so that what hangs from the mouth can be drawn out. Beyond the mouth they are free.

    Args:
        pos: Centre of the mouth [m].
        direction: Direction of the stream, a unit vector.
        radius: Radius of the mouth [m].
        speed: Speed in the pipe [m/s].
        start: Time at which the first comes out [s].
        duration: How long the stream lasts [s].
        spacing: Distance of particles [m].

    Attributes:
        mouth: Where each particle comes out [m], shape (n, 3).
        times: When each comes out [s], in ascending order, shape (n,).
        velocity: Velocity in the pipe [m/s].
        ahead: How long before it comes out a particle enters the pipe [s].
        now: Time up to which it was let flow [s].
    """

    def __init__(self, pos, direction, radius, speed, start, duration, spacing):
        direction = np.asarray(direction, float)
        self.velocity, self.ahead, self.now = speed * direction, PIPE * spacing / speed, 0.0
        layers = max(1, round(speed * duration / spacing))
        chance = np.random.default_rng(0)
        across = [_disc(radius, spacing, k % 2 / 2, chance.uniform(0, 2 * np.pi)) for k in range(layers)]
        flat = np.concatenate(across)
        # No two particles of a layer leave together: a stream that is drawn out would fall apart into discs.
        within = np.concatenate([np.arange(len(disc)) * GOLDEN % 1 for disc in across])
        layer = np.repeat(np.arange(layers), [len(disc) for disc in across])
        self.times = start + (layer + within) * duration / layers
        order = np.argsort(self.times, kind="stable")
        flat = flat + JITTER * spacing * chance.uniform(-1, 1, flat.shape)
        self.times, flat = self.times[order], flat[order]
        u, v = _normals_of(direction)
        self.mouth = np.asarray(pos, float) + flat[:, :1] * u + flat[:, 1:] * v

    def __len__(self):
        return len(self.times)

    def fill_in(self, values, which):
        """Return positions (`which` is 0) or velocities (1) of all particles: of those to come, at rest in the mouth.

        Args:
            values: Those that the engine has, shape (n, 3).
            which: 0 or 1.
        """
        come = self.times[:, None] < self.now
        return np.where(come, values, 0.0 if which else self.mouth)


def flowing(points, mouth, spacing):
    """Return which points of a stream no longer wait where they did at the start.

    Args:
        points: Recorded positions [m], shape (n, 3).
        mouth: Those at the start [m], shape (n, 3).
        spacing: Distance of particles [m].
    """
    return (np.abs(points - mouth) > STILL * spacing).any(axis=1)


def _disc(radius, spacing, shift, angle):
    """Return the places of particles across a round stream [m], shape (k, 2), shifted by parts of their distance.

    They are turned by an angle [rad], since equal layers would come down in columns, and run away in as many arms.
    """
    reach = int(radius / spacing) + 1
    line = (np.arange(-reach, reach + 1) + shift) * spacing
    grid = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    c, s = np.cos(angle), np.sin(angle)
    return grid[(grid**2).sum(axis=1) <= radius**2] @ np.array([[c, s], [-s, c]])


def _normals_of(direction):
    """Return two unit vectors normal to a direction and to each other."""
    least = np.eye(3)[np.abs(direction).argmin()]
    u = np.cross(direction, least)
    u /= np.linalg.norm(u)
    return u, np.cross(direction, u)
