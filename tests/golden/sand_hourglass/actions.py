"""The actions on the bodies of sand_hourglass, applied step by step."""

from scene import DT


class Actions:
    """Everything that acts on the bodies besides gravity, contacts and joints."""

    def __init__(self, scene, bodies):
        """Set the start velocities, and look up the joints and links that the actions need."""
        self.each_step = []

    def before_step(self, step):
        """Apply all actions before time step `step`, which begins at `step * DT`."""
        t = step * DT
        for act in self.each_step:
            act(t)
