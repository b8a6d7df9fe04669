"""Texts of model files."""

TETRAHEDRON = """\
v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 0.1
f 1 3 2
f 1 2 4
f 2 3 4
f 1 4 3
"""

ARM = """\
<robot name="arm">
  <link name="base"><collision><geometry><cylinder radius="0.1" length="0.1"/></geometry></collision></link>
  <link name="upper">
    <inertial><origin xyz="0 0 0.15"/><mass value="2"/>
      <inertia ixx="0.02" iyy="0.02" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="meshes/part.obj"/></geometry></visual>
    <collision><geometry><mesh filename="meshes/part.obj" scale="2 2 2"/></geometry></collision>
  </link>
  <link name="hand"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="30" velocity="5"/><dynamics damping="0.3"/>
    <safety_controller k_position="100" k_velocity="40"/>
  </joint>
  <joint name="wrist" type="fixed"><parent link="upper"/><child link="hand"/><origin xyz="0 0 0.3"/></joint>
  <gazebo><plugin name="p" filename="libp.so"/></gazebo>
</robot>
"""


def mjcf(body: str, rest: str = "") -> str:
    return f"<mujoco>{rest}<worldbody><body name='b'><geom size='0.1'/>{body}</body></worldbody></mujoco>"
