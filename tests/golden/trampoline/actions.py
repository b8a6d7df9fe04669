"""What acts on the bodies of trampoline, step by step."""

from holds import Hold, Holds
from points import sides
from scene import DT


def main_link(body):
    """The first link of a body that is not the world."""
    return next(link for link in body.links if link.name != "world")


def make_holds(scene, bodies):
    """Points of deformable bodies that are held."""
    return [
        # case.yaml:51 hold_left
        Hold(
            scene,
            bodies["sheet"],
            pose=((0.0, 0.0, 0.9), (1.0, 0.0, 0.0, 0.0)),
            region=sides((0, -1), within=0.01),
        ),
        # case.yaml:52 hold_right
        Hold(
            scene,
            bodies["sheet"],
            pose=((0.0, 0.0, 0.9), (1.0, 0.0, 0.0, 0.0)),
            region=sides((0, 1), within=0.01),
        ),
        # case.yaml:53 hold_front
        Hold(
            scene,
            bodies["sheet"],
            pose=((0.0, 0.0, 0.9), (1.0, 0.0, 0.0, 0.0)),
            region=sides((1, -1), within=0.01),
        ),
        # case.yaml:54 hold_back
        Hold(
            scene,
            bodies["sheet"],
            pose=((0.0, 0.0, 0.9), (1.0, 0.0, 0.0, 0.0)),
            region=sides((1, 1), within=0.01),
        ),
    ]


class Actions:
    """Everything that happens to the bodies besides physics."""

    def __init__(self, scene, bodies):
        """Set start velocities, and look up the joints and links that are acted on."""
        self.each_step = [
            Holds(make_holds(scene, bodies)),
        ]

    def before_step(self, step):
        """Act on the bodies before time step number `step`, which begins at `step * DT`."""
        t = step * DT
        for act in self.each_step:
            act(t)
