"""Writer of a compiled MJCF model as an OpenUSD stage with UsdPhysics."""

from pathlib import Path
from typing import Any

import numpy as np

from text2sim.compiler.plan import Plan
from text2sim.engine_benchmark.mujoco_door import mujoco
from text2sim.exchange.openusd import openusd

ROOT = "/benchmark"


def write_usd(model: Any, plan: Plan, path: Path) -> None:
    """Write bodies, shapes, masses, joints, limits, motors and gravity of a model at its start.

    Args:
        model: The model of MuJoCo.
        plan: The plan of the case.
        path: The file.
    """
    _Stage(model, plan, path).write()


class _Stage:
    def __init__(self, model: Any, plan: Plan, path: Path) -> None:
        self.usd, self.model, self.plan, self.mj = openusd(), model, plan, mujoco()
        self.data = self.mj.MjData(model)
        self.mj.mj_forward(model, self.data)
        usd = self.usd
        self.stage = usd.Usd.Stage.CreateNew(str(path))
        usd.UsdGeom.SetStageUpAxis(self.stage, usd.UsdGeom.Tokens.z)
        usd.UsdGeom.SetStageMetersPerUnit(self.stage, 1.0)
        usd.UsdPhysics.SetStageKilogramsPerUnit(self.stage, 1.0)
        self.stage.SetDefaultPrim(usd.UsdGeom.Xform.Define(self.stage, ROOT).GetPrim())
        self.paths: dict[int, str] = {}

    def write(self) -> None:
        usd, model = self.usd, self.model
        scene = usd.UsdPhysics.Scene.Define(self.stage, f"{ROOT}/scene")
        size = float(np.linalg.norm(model.opt.gravity))
        scene.CreateGravityMagnitudeAttr(size)
        scene.CreateGravityDirectionAttr(usd.Gf.Vec3f(*(model.opt.gravity / size if size else [0, 0, -1])))
        for body in range(model.nbody):
            self._body(body)
        for body in range(1, model.nbody):
            self._joints(body)
        for row in range(model.neq):
            self._loop(row)
        self.stage.GetRootLayer().Save()

    def _body(self, body: int) -> None:
        usd, model = self.usd, self.model
        name = usd.Tf.MakeValidIdentifier(model.body(body).name or "world")
        path = self.paths[body] = f"{ROOT}/{name}"
        form = usd.UsdGeom.Xform.Define(self.stage, path)
        prim = form.GetPrim()
        prim.SetDisplayName(model.body(body).name or "world")
        self._place(form, self.data.xpos[body], self.data.xquat[body])
        if body and model.body_weldid[body]:
            usd.UsdPhysics.RigidBodyAPI.Apply(prim)
            mass = usd.UsdPhysics.MassAPI.Apply(prim)
            mass.CreateMassAttr(float(model.body_mass[body]))
            mass.CreateCenterOfMassAttr(usd.Gf.Vec3f(*map(float, model.body_ipos[body])))
            mass.CreateDiagonalInertiaAttr(usd.Gf.Vec3f(*map(float, model.body_inertia[body])))
            mass.CreatePrincipalAxesAttr(usd.Gf.Quatf(*map(float, model.body_iquat[body])))
        start = int(model.body_geomadr[body])
        for geom in range(start, start + int(model.body_geomnum[body])):
            self._geom(f"{path}/shape_{geom - start}", geom)

    def _geom(self, path: str, geom: int) -> None:
        usd, model, kinds = self.usd, self.model, self.mj.mjtGeom
        kind, size = kinds(int(model.geom_type[geom])), [float(x) for x in model.geom_size[geom]]
        if kind == kinds.mjGEOM_MESH:
            prim = usd.UsdGeom.Mesh.Define(self.stage, path)
            mesh = int(model.geom_dataid[geom])
            a, n = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            b, m = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
            prim.CreatePointsAttr(usd.Vt.Vec3fArray.FromNumpy(model.mesh_vert[a : a + n].astype(np.float32)))
            prim.CreateFaceVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.full(m, 3, np.int32)))
            faces = model.mesh_face[b : b + m].astype(np.int32).ravel()
            prim.CreateFaceVertexIndicesAttr(usd.Vt.IntArray.FromNumpy(faces))
            prim.CreateSubdivisionSchemeAttr(usd.UsdGeom.Tokens.none)
            usd.UsdPhysics.MeshCollisionAPI.Apply(prim.GetPrim()).CreateApproximationAttr("convexHull")
        elif kind == kinds.mjGEOM_BOX:
            prim = usd.UsdGeom.Cube.Define(self.stage, path)
            prim.CreateSizeAttr(2.0)
        elif kind == kinds.mjGEOM_SPHERE:
            prim = usd.UsdGeom.Sphere.Define(self.stage, path)
            prim.CreateRadiusAttr(size[0])
        elif kind == kinds.mjGEOM_PLANE:
            prim = usd.UsdGeom.Plane.Define(self.stage, path)
            prim.CreateAxisAttr("Z")
        else:
            shape = usd.UsdGeom.Capsule if kind == kinds.mjGEOM_CAPSULE else usd.UsdGeom.Cylinder
            prim = shape.Define(self.stage, path)
            prim.CreateRadiusAttr(size[0])
            prim.CreateHeightAttr(2 * size[1])
            prim.CreateAxisAttr("Z")
        self._place(prim, model.geom_pos[geom], model.geom_quat[geom])
        if kind == kinds.mjGEOM_BOX:
            prim.AddScaleOp().Set(usd.Gf.Vec3f(*size))
        usd.UsdPhysics.CollisionAPI.Apply(prim.GetPrim())
        friction = float(model.geom_friction[geom][0])
        stuff = f"{ROOT}/materials/friction_{f'{friction:g}'.replace('.', '_').replace('-', '_')}"
        if not self.stage.GetPrimAtPath(stuff):
            material = usd.UsdPhysics.MaterialAPI.Apply(usd.UsdShade.Material.Define(self.stage, stuff).GetPrim())
            material.CreateStaticFrictionAttr(friction)
            material.CreateDynamicFrictionAttr(friction)
        bound = usd.UsdShade.MaterialBindingAPI.Apply(prim.GetPrim())
        bound.Bind(usd.UsdShade.Material.Get(self.stage, stuff), materialPurpose="physics")

    def _joints(self, body: int) -> None:
        usd, model, kinds = self.usd, self.model, self.mj.mjtJoint
        start, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        parent = int(model.body_parentid[body])
        if not count and model.body_weldid[body]:
            self._joint(usd.UsdPhysics.FixedJoint, f"{self.paths[body]}_fixed", parent, body, np.zeros(3), None)
        for joint in range(start, start + count):
            kind = kinds(int(model.jnt_type[joint]))
            if kind == kinds.mjJNT_FREE:
                continue
            shape = {
                kinds.mjJNT_HINGE: usd.UsdPhysics.RevoluteJoint,
                kinds.mjJNT_SLIDE: usd.UsdPhysics.PrismaticJoint,
                kinds.mjJNT_BALL: usd.UsdPhysics.SphericalJoint,
            }[kind]
            name = usd.Tf.MakeValidIdentifier(model.joint(joint).name)
            axis = None if kind == kinds.mjJNT_BALL else model.jnt_axis[joint]
            prim = self._joint(shape, f"{ROOT}/joint_{name}", parent, body, model.jnt_pos[joint], axis)
            if model.body_weldid[parent] == 0:  # the root of a fixed articulation is this joint
                usd.UsdPhysics.ArticulationRootAPI.Apply(prim.GetPrim())
            if axis is None:
                continue
            # UsdPhysics has angles in degrees.
            unit = 180 / np.pi if kind == kinds.mjJNT_HINGE else 1.0
            if model.jnt_limited[joint]:
                low, high = (float(x * unit) for x in model.jnt_range[joint])
                prim.CreateLowerLimitAttr(low)
                prim.CreateUpperLimitAttr(high)
            for motor in range(model.nu):
                if model.actuator_trnid[motor][0] == joint:
                    drive = usd.UsdPhysics.DriveAPI.Apply(prim.GetPrim(), "angular" if unit > 1 else "linear")
                    drive.CreateStiffnessAttr(float(-model.actuator_biasprm[motor][1] / unit))
                    drive.CreateDampingAttr(float(-model.actuator_biasprm[motor][2] / unit))
                    if model.actuator_forcelimited[motor]:
                        drive.CreateMaxForceAttr(float(model.actuator_forcerange[motor][1]))

    def _loop(self, row: int) -> None:
        model, name = self.model, f"{ROOT}/loop_{row}"
        if self.mj.mjtEq(int(model.eq_type[row])) == self.mj.mjtEq.mjEQ_CONNECT:
            one, other = int(model.eq_obj1id[row]), int(model.eq_obj2id[row])
            prim = self._joint(self.usd.UsdPhysics.SphericalJoint, name, other, one, model.eq_data[row][:3], None)
            prim.CreateExcludeFromArticulationAttr(True)

    def _joint(self, shape: Any, path: str, parent: int, body: int, anchor: Any, axis: Any) -> Any:
        """Define a joint at a point of a body; its axis, if any, is the joint's x axis."""
        usd, mj, data = self.usd, self.mj, self.data
        joint = shape.Define(self.stage, path)
        joint.CreateBody0Rel().SetTargets([self.paths[parent]])
        joint.CreateBody1Rel().SetTargets([self.paths[body]])
        turn = np.array([1.0, 0, 0, 0])
        if axis is not None:
            joint.CreateAxisAttr("X")
            mj.mju_quatZ2Vec(turn, np.array(axis, float))
            side = np.array([np.sqrt(0.5), 0, -np.sqrt(0.5), 0])  # rotates x to z
            mj.mju_mulQuat(turn, turn.copy(), side)
        point, world, back = np.zeros(3), np.zeros(3), np.zeros(4)
        mj.mju_rotVecQuat(point, np.array(anchor, float), data.xquat[body])
        world = point + data.xpos[body] - data.xpos[parent]
        mj.mju_negQuat(back, data.xquat[parent])
        local, quat = np.zeros(3), np.zeros(4)
        mj.mju_rotVecQuat(local, world, back)
        mj.mju_mulQuat(quat, back, data.xquat[body])
        mj.mju_mulQuat(quat, quat.copy(), turn)
        joint.CreateLocalPos0Attr(usd.Gf.Vec3f(*map(float, local)))
        joint.CreateLocalRot0Attr(usd.Gf.Quatf(*map(float, quat)))
        joint.CreateLocalPos1Attr(usd.Gf.Vec3f(*map(float, anchor)))
        joint.CreateLocalRot1Attr(usd.Gf.Quatf(*map(float, turn)))
        return joint

    def _place(self, made: Any, pos: Any, quat: Any) -> None:
        made.AddTranslateOp().Set(self.usd.Gf.Vec3d(*map(float, pos)))
        made.AddOrientOp().Set(self.usd.Gf.Quatf(*map(float, quat)))
