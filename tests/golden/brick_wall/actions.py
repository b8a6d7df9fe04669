"""The actions on the bodies of brick_wall, applied step by step."""

import genesis as gs
import numpy as np
from scene import DT


def rotate(quat, vector):
    """Rotate a vector by a quaternion (w, x, y, z)."""
    w, axis = quat[0], quat[1:]
    return vector + 2.0 * np.cross(axis, np.cross(axis, vector) + w * vector)


# Body, velocity of its centre of mass [m/s], angular velocity [rad/s], both in the world frame.
VELOCITIES = [
    ("ball", (0.0, 11.0, 0.6), (0.0, 0.0, 0.0)),  # case.yaml:35 launch
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
        # The engine expects the velocity of the link's origin, and the angular velocity in the link's frame.
        velocity = np.asarray(linear) + np.cross(angular, origin - center)
        spin = rotate(quat * (1.0, -1.0, -1.0, -1.0), np.asarray(angular))
        body.set_dofs_velocity(np.concatenate([velocity, spin]), root.dofs_idx_local)


class Actions:
    """Everything that acts on the bodies besides gravity, contacts and joints."""

    def __init__(self, scene, bodies):
        """Set the start velocities, and look up the joints and links that the actions need."""
        set_velocities(scene, bodies)
        self.each_step = []

    def before_step(self, step):
        """Apply all actions before time step `step`, which begins at `step * DT`."""
        t = step * DT
        for act in self.each_step:
            act(t)
