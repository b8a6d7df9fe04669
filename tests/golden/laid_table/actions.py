"""What acts on the bodies of laid_table, step by step."""

import genesis as gs
import numpy as np
from scene import DT


def rotate(quat, vector):
    """Rotate a vector by a quaternion (w, x, y, z)."""
    w, axis = quat[0], quat[1:]
    return vector + 2.0 * np.cross(axis, np.cross(axis, vector) + w * vector)


# Body, velocity of its centre of mass [m/s], angular velocity [rad/s], both in the world.
VELOCITIES = [
    ("ball", (2.5, 0.0, 0.0), (0.0, 46.728972, 0.0)),  # case.yaml:48 roll
]


def set_velocities(scene, bodies):
    """Give bodies their start velocities."""
    solver = scene.rigid_solver
    for name, linear, angular in VELOCITIES:
        body = bodies[name]
        root = next(joint for joint in body.joints if joint.type == gs.JOINT_TYPE.FREE)
        quat, origin, center = (
            np.asarray(value.cpu()).reshape(-1)
            for value in (
                solver.get_links_quat([root.link.idx]),
                solver.get_links_pos([root.link.idx]),
                solver.get_links_pos([root.link.idx], ref=gs.link_ref_frame.link_COM),
            )
        )
        # The engine wants the velocity of the link's origin, and the angular velocity in the link's own axes.
        velocity = np.asarray(linear) + np.cross(angular, origin - center)
        spin = rotate(quat * (1.0, -1.0, -1.0, -1.0), np.asarray(angular))
        body.set_dofs_velocity(np.concatenate([velocity, spin]), root.dofs_idx_local)


class Actions:
    """Everything that happens to the bodies besides physics."""

    def __init__(self, scene, bodies):
        """Set start velocities, and look up the joints and links that are acted on."""
        set_velocities(scene, bodies)
        self.each_step = []

    def before_step(self, step):
        """Act on the bodies before time step number `step`, which begins at `step * DT`."""
        t = step * DT
        for act in self.each_step:
            act(t)
