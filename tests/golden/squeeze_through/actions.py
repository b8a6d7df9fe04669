"""What acts on the bodies of squeeze_through, step by step."""

from points import everything
from pushes import Push
from scene import DT


def make_pushes(scene, bodies):
    """Forces on deformable bodies, or on regions of them."""
    return [
        # case.yaml:44 pull
        Push(
            scene,
            bodies["jelly"],
            pose=((-0.22, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
            region=everything,
            force=(460.0, 0.0, 0.0),
            drag=430.0,
            start=0.05,
            end=0.9,
        ),
    ]


class Actions:
    """Everything that happens to the bodies besides physics."""

    def __init__(self, scene, bodies):
        """Set start velocities, and look up the joints and links that are acted on."""
        self.each_step = [
            *make_pushes(scene, bodies),
        ]

    def before_step(self, step):
        """Act on the bodies before time step number `step`, which begins at `step * DT`."""
        t = step * DT
        for act in self.each_step:
            act(t)
