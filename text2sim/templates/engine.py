"""Fixes for faults of the engine; each applies only to a release that has the fault."""

import inspect
from hashlib import sha256

import genesis as gs
import quadrants as qd
from genesis.engine.couplers import SAPCoupler, sap_coupler
from genesis.engine.entities.rigid_entity.rigid_equality import RigidEquality
from genesis.engine.materials.MPM.base import Base as MPMMaterial
from genesis.engine.solvers.pbd_solver import PBDSolver
from genesis.engine.solvers.rigid.abd import forward_kinematics
from genesis.engine.solvers.rigid.collider import support_field
from genesis.utils import array_class
from genesis.utils import geom as gu
from quadrants.lang.snode import SNode

MOST_SWEEPS = 8  # largest number of sweeps over the threads of cloth in one kernel
PARTING = 1.0  # largest speed at which the SAP coupler separates overlapping bodies [m/s]
CONTACT_CAPACITY_FACTOR = (
    4  # factor on the number of contacts between rigid triangles and tetrahedra that the SAP coupler allocates
)


def mend(sap: bool = False) -> None:
    """Applies the fixes. Call once per process, before `gs.init`.

    Args:
        sap: Whether the scene uses the SAP coupler. Its fixes cause all kernels to be compiled again, so other scenes
            do without them.
    """
    _mend_cylinders()
    _mend_ball_springs()
    _mend_equalities()
    _mend_many_sweeps()
    _mend_equal_materials()
    if sap:
        _mend_motionless_scenes()
        _mend_deep_contacts()
        _mend_contact_room()


def _mend_motionless_scenes() -> None:
    """Lets the SAP coupler build a scene in which no rigid body can move.

    Genesis 1.4.5 allocates fields with one column per rigid degree of freedom, and the compiler rejects fields without
    columns. So a soft body on a bare floor would end in an error. Such fields get one unused column.
    """
    build = SAPCoupler.build

    def build_with_columns(coupler):
        dense = SNode.dense
        SNode.dense = lambda tree, axes, sizes: dense(tree, axes, _at_least_one(sizes))
        try:
            build(coupler)
        finally:
            SNode.dense = dense

    SAPCoupler.build = build_with_columns


def _mend_deep_contacts() -> None:
    """Keeps the SAP coupler from throwing bodies apart.

    Genesis 1.4.5 computes the depth of a contact as the pressure in a tetrahedron divided by the pressure gradient
    normal to the surface. If the surface is nearly parallel to the gradient, the depth comes out as metres: a brick of
    6 cm that fell from 10 cm left the ground at 104 m/s. The fix limits the speed of separation to `PARTING`.
    """
    regularization = _DeepContacts.compute_contact_regularization
    if "vn_hat = -sap_info[i_p].phi0" not in inspect.getsource(sap_coupler.BaseContactHandler):
        return
    sap_coupler.BaseContactHandler.compute_contact_regularization = regularization
    qd.__version_str__ += "+" + sha256(inspect.getsource(_DeepContacts).encode()).hexdigest()[:8]


@qd.data_oriented
class _DeepContacts:
    @qd.func
    def compute_contact_regularization(self, sap_info, i_p, w_rms, time_step):
        beta_factor = self.coupler._sap_beta**2 / (4.0 * qd.math.pi**2)
        k = sap_info[i_p].k
        Rn = max(beta_factor * w_rms, 1.0 / (time_step * k * (time_step + self.coupler._sap_taud)))
        Rt = self.coupler._sap_sigma * w_rms
        vn_hat = min(-sap_info[i_p].phi0 / (time_step + self.coupler._sap_taud), PARTING)
        sap_info[i_p].Rn = Rn
        sap_info[i_p].Rt = Rt
        sap_info[i_p].Rn_inv = 1.0 / Rn
        sap_info[i_p].Rt_inv = 1.0 / Rt
        sap_info[i_p].vn_hat = vn_hat
        sap_info[i_p].mu_hat = sap_info[i_p].mu * Rt * sap_info[i_p].Rn_inv
        sap_info[i_p].mu_factor = 1.0 / (1.0 + sap_info[i_p].mu * sap_info[i_p].mu_hat)


def _mend_contact_room() -> None:
    """Gives the SAP coupler room for bodies that are touched all round.

    Genesis 1.4.5 allocates one contact per surface tetrahedron or per rigid triangle, whichever are more, and fails
    beyond that. A body of 300 vertices in a tube of 16 staves has more contacts: a triangle touches several tetrahedra,
    and where staves meet, a tetrahedron touches several triangles.
    """
    handler = sap_coupler.RigidFemTriTetContactHandler
    init = handler.__init__

    def with_capacity(self, *args, **options):
        init(self, *args, **options)
        self.max_contact_pairs = capacity = CONTACT_CAPACITY_FACTOR * self.max_contact_pairs
        columns = capacity, self.rigid_solver.n_dofs
        self.contact_pairs = self.contact_pair_type.field(shape=(capacity,))
        self.Jt, self.M_inv_Jt = (qd.field(gs.qd_vec3, shape=columns) for _ in range(2))
        self.W = qd.field(gs.qd_mat3, shape=(capacity,))

    handler.__init__ = with_capacity
    qd.__version_str__ += f"+{CONTACT_CAPACITY_FACTOR}"


def _mend_ball_springs() -> None:
    """Keeps twisted ropes from shaking themselves apart.

    Genesis 1.4.5 multiplies the stiffness of a ball joint's spring with its three Euler angles. The moment of a joint
    that is bent and twisted then has no potential: a rope of 50 links with two turns in it gained energy until it flew
    apart. The moment of a spring of energy `k |r|^2 / 2` is `-k r`, with the rotation vector r. The fix makes it the
    position of ball and free joints, in both directions.
    """
    if "qd_quat_to_xyz" not in inspect.getsource(forward_kinematics):
        return
    gu.qd_quat_to_xyz, gu.qd_xyz_to_quat = gu.qd_quat_to_rotvec, _rotvec_to_quat
    qd.__version_str__ += "+rotvec"


@qd.func
def _rotvec_to_quat(rotvec):
    return gu.qd_rotvec_to_quat(rotvec, gs.EPS)


def _mend_equalities() -> None:
    """Lets joints of URDF files that mimic others share a scene with loops and with MJCF files.

    Genesis 1.4.5 stacks the numbers of all constraints into one array: 11 of each `mimic`, but as many as MuJoCo keeps
    (12 since 4.0) of each loop. Its kernel reads the first 11.
    """
    RigidEquality.eq_data = property(lambda equality: equality.desc.data[:11])


def _mend_many_sweeps() -> None:
    """Compiles many sweeps over the threads of cloth as one kernel of few that runs many times.

    Genesis 1.4.5 unrolls all of them into one kernel, so that the more there are, the longer it takes to compile.
    """
    build = PBDSolver.build
    if "qd.static(range(self._max_stretch_solver_iterations))" not in inspect.getsource(PBDSolver):
        return

    def build_and_divide(solver):
        build(solver)
        sweeps, sweep = solver._max_stretch_solver_iterations, solver._kernel_solve_stretch
        few = next(few for few in range(MOST_SWEEPS, 0, -1) if sweeps % few == 0)
        if few == sweeps:
            return

        def sweep_all(f):
            solver._max_stretch_solver_iterations = few  # as many as the kernel is compiled with
            for _ in range(sweeps // few):
                sweep(f)
            solver._max_stretch_solver_iterations = sweeps

        solver._kernel_solve_stretch = sweep_all

    PBDSolver.build = build_and_divide


def _mend_equal_materials() -> None:
    """Compiles the law of an mpm material once, however many bodies are of it.

    Genesis 1.4.5 looks for an equal material, but none is, for each has methods of its own: a kernel contained the law
    of each copy of a body.
    """
    MPMMaterial.__eq__ = lambda one, other: type(one) is type(other) and one.model_dump() == other.model_dump()


def _at_least_one(sizes):
    return max(1, sizes) if isinstance(sizes, int) else [max(1, size) for size in sizes]


def _mend_cylinders() -> None:
    """Keeps cylinders from jumping off slopes.

    Genesis 1.4.5 throws a cylinder that stands on a slope metres into the air. Its support point lies off the axis, in
    the direction of the radial component of the search direction. The engine uses that component down to a length of
    1e-9, where it is mere rounding error and may point along the axis. The fix uses the centre of the face below 1e-5.

    The kernel cache identifies a kernel by the compiler's version and the kernel's own source, and so does not notice
    that a function it calls was replaced. Therefore each fix changes the version.
    """
    if "> 1e-9" not in inspect.getsource(support_field._func_support_cylinder):
        return
    support_field._func_support_cylinder = _support_cylinder
    qd.__version_str__ += "+" + sha256(inspect.getsource(_support_cylinder).encode()).hexdigest()[:8]


@qd.func
def _support_cylinder(
    i_g: int,
    d: qd.types.vector(3),
    pos: qd.types.vector(3),
    quat: qd.types.vector(4),
    dyn_info: array_class.DynInfo,
    shrink: bool,
):
    radius = dyn_info.geoms.data[i_g][0]
    half_length = 0.5 * dyn_info.geoms.data[i_g][1]
    axis = gu.qd_transform_by_quat(qd.Vector([0.0, 0.0, 1.0], dt=gs.qd_float), quat)
    side = -1.0 if d.dot(axis) < 0.0 else 1.0
    point = pos + half_length * side * axis
    if not shrink:
        across = d - d.dot(axis) * axis
        across = across - across.dot(axis) * axis  # once more: rounding has left some of it along the axis
        norm = across.norm()
        if norm > 1e-5:
            point = point + (radius / norm) * across
    return point
