"""What acts on the bodies of sand_hourglass, step by step."""

from scene import DT


class Actions:
    """Everything that happens to the bodies besides physics."""

    def __init__(self, scene, bodies):
        """Set start velocities, and look up the joints and links that are acted on."""
        self.each_step = []

    def before_step(self, step):
        """Act on the bodies before time step number `step`, which begins at `step * DT`."""
        t = step * DT
        for act in self.each_step:
            act(t)
