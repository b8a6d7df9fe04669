"""Loads of what holds cloth, and when they broke it, as `bonds.py` keeps them of rigid bodies."""

import numpy as np


class Loads:
    """Loads of the holders of one control, each of which breaks at the same force.

    Args:
        control: Name of the control.
        pairs: Names of the cloth and of its holder, one pair for each holder.
        strength: Force [N] at which it breaks.
        dt: Time step [s]; a load is the mean over one.
    """

    def __init__(self, control, pairs, strength, dt):
        self.control, self.pairs, self.strength, self.dt = control, pairs, strength, dt
        self.peak, self.peak_at = np.zeros(len(pairs)), np.zeros(len(pairs))
        self.broken_at, self.middle = [None] * len(pairs), np.zeros((len(pairs), 3))

    def begin(self, middle):
        """Take the middle [m] of the points of each holder, (n, 3)."""
        self.middle = np.asarray(middle, float)

    def take(self, impulses, t):
        """Take what each holder has given in a step [N s], and return the numbers of those that it has broken.

        Args:
            impulses: One for each holder.
            t: End of the step [s].
        """
        load = np.asarray(impulses, float) / self.dt / self.strength
        load[[time is not None for time in self.broken_at]] = 0.0
        higher = load > self.peak
        self.peak[higher], self.peak_at[higher] = load[higher], t
        broken = np.flatnonzero(load >= 1.0)
        for k in broken.tolist():
            self.broken_at[k] = t
        return broken

    def report(self):
        """Return the rows of this control, as those of `Bonds.report`."""
        return [
            {
                "control": self.control, "between": [*pair], "pos": self.middle[k].tolist(), "area": None,
                "peak": float(self.peak[k]), "peak_at": float(self.peak_at[k]),
                "broken_at": self.broken_at[k], "by": None if self.broken_at[k] is None else "tension",
            }
            for k, pair in enumerate(self.pairs)
        ]  # fmt: skip
