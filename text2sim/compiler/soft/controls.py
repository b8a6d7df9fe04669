"""Controls of deformable bodies as rows of the program: holds, pushes and fields."""

from dataclasses import dataclass
from pathlib import Path

from text2sim.compiler.action_rows import Airflow as AirflowRow
from text2sim.compiler.action_rows import Field, Hold, Origin, Push
from text2sim.compiler.literal import Code
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.schedules import call_of, largest, scale_constructor
from text2sim.compiler.selection import select
from text2sim.compiler.shapes.regions import RegionError
from text2sim.compiler.shapes.rotation import vector_unit
from text2sim.compiler.soft.regions import region_finder
from text2sim.compiler.soft.scales import Scales
from text2sim.compiler.soft.solvers import solver_of
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.bodies import Articulated, Rigid
from text2sim.spec_schema.models.controls import Attach, Force, Impulse, Release
from text2sim.spec_schema.models.fields import Airflow, Attraction, Drag, Turbulence, Vortex, Wind
from text2sim.spec_schema.models.placed import Linked
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.models.scene import Scene
from text2sim.spec_schema.models.soft_bodies import Cloth

WORLD = "world"
"""Value of `to` that holds a body where it is."""
NEVER_REACHED = 1e9
"""Time [s] that no run reaches."""
ANY_FIELD = Wind | Drag | Attraction | Vortex | Turbulence


class SeamRegionError(RegionError):
    """The cloth to which another one is sewn does not reach into `to_region`."""


@dataclass
class SoftControls:
    """Lowers controls of deformable bodies."""

    scene: Scene
    scales: Scales
    folder: Path

    def finder(self, copy: Copy, region: BodyRegion | None) -> Code:
        """Return the constructor of the function that finds the points of a region of a copy.

        Raises:
            RegionError: if the body does not reach into the region.
        """
        solver = solver_of(copy.model, self.scene)
        assert solver is not None
        return region_finder(region, copy.shape, self.scales.spacing(copy.body, solver), solver, self.folder)

    def hold(self, copy: Copy, held: "Held", until: list[float | str], origin: Origin) -> Hold:
        """Return the row for one copy that the world, or links of other copies, hold.

        Args:
            copy: What is held.
            held: What holds it, and how.
            until: Times [s] and events that end it.
            origin: The control.

        Raises:
            SeamRegionError: If it is sewn to a region of a cloth that has no such part.
        """
        attach = held.attach
        sewn = next((holder for holder in held.by if isinstance(holder.model, Cloth)), None)
        return Hold(
            entity=copy.name,
            pose=(copy.pos, copy.quat),
            region=self.finder(copy, attach.region),
            count=attach.points,
            to=tuple(holder.name for holder in held.by),
            link=held.part,
            stiffness=attach.stiffness,
            both_ways=bool(held.by) and all(_feels(holder, solver_of(copy.model, self.scene)) for holder in held.by),
            strength=attach.strength,
            seam=None if sewn is None else ((sewn.pos, sewn.quat), self._finder_of_seam(sewn, attach.to_region)),
            start=attach.at,
            until=tuple(until),
            **origin._asdict(),
        )

    def _finder_of_seam(self, to: Copy, region: BodyRegion | None) -> Code:
        try:
            return self.finder(to, region)
        except RegionError as error:
            raise SeamRegionError(f"`{to.body}`: {error}") from None

    def push(self, copy: Copy, control: Force | Impulse, origin: Origin) -> Push:
        """Return the row for a force or an impulse on one copy.

        Args:
            copy: What is pushed.
            control: The force or impulse.
            origin: The control.
        """
        pose = (copy.pos, copy.quat)
        if isinstance(control, Impulse):
            assert not isinstance(control.point, tuple)
            region = self.finder(copy, control.point)
            return Push(copy.name, pose, region, control.impulse, None, 0.0, control.at, control.at, *origin)
        start, end = span_of(control.during, NEVER_REACHED)
        scale = scale_constructor(control.scale)
        region = self.finder(copy, control.region)
        return Push(copy.name, pose, region, control.force, scale, control.drag, start, end, *origin)


@dataclass(frozen=True)
class Held:
    """How an `attach` holds one copy of a deformable body."""

    attach: Attach
    """The control, as the copy has it."""
    by: list[Copy]
    """What holds it; empty for the world."""
    part: str | None
    """The link that holds it."""


def _feels(holder: Copy, solver: str | None) -> bool:
    """Return whether a body feels points of a solver that hang on it: not if a mount or a given motion places it.

    A link with a motor feels those of mpm alone.
    """
    model = holder.model
    if isinstance(model, Rigid):
        motor = getattr(model.mount, "actuator", None) is not None
        return model.mount.kind != "fixed" and (solver == "mpm" or solver == "pbd" and not motor)
    if solver == "mpm":
        return isinstance(model, (Linked, Articulated))
    return solver == "pbd" and (isinstance(model, Linked) or getattr(model, "base", None) == "free")


def held_copies(loaded: LoadedCase, name: str, copies: dict[str, list[Copy]]) -> list[tuple[Copy, Held]]:
    """Return the copies that an `attach` of a deformable body holds, each with what holds it.

    A single copy is held by all holders together. Several copies are all held by the same ones, or paired one by one.

    Args:
        loaded: The case.
        name: Name of the control.
        copies: Copies by static and body.
    """
    attach = loaded.case.actions.controls[name]
    assert isinstance(attach, Attach)
    chosen, _ = select(attach.body, copies)
    found = []
    for index, copy in enumerate(chosen):
        own = loaded.control_copy(name, copy.variables)
        assert isinstance(own, Attach)
        holders, part = ([], None) if own.to == WORLD and WORLD not in copies else select(own.to, copies)
        if own.to == attach.to and len(chosen) > 1 and len(holders) == len(chosen):
            holders = [holders[index]]
        found.append((copy, Held(own, holders, part)))
    return found


def ends_of(loaded: LoadedCase, name: str) -> list[float | str]:
    """Return the times [s] and events at which an `attach` is released."""
    ends: list[float | str] = []
    for control in loaded.case.actions.controls.values():
        if isinstance(control, Release) and control.attach == name:
            ends += [end for end in (control.at, control.on) if end is not None]
    return ends


def lower_airflow(copy: Copy, control: Airflow, duration: float, origin: Origin) -> AirflowRow:
    """Return the row of the air that flows past a copy of a cloth.

    Args:
        copy: The cloth.
        control: The airflow, as the copy has it.
        duration: Duration of the run [s].
        origin: The control.
    """
    start, end = span_of(control.during, NEVER_REACHED)
    scale = scale_constructor(control.scale)
    gusts = (control.gusts, control.gust_size, control.seed)
    strongest = largest(control.scale, duration)
    return AirflowRow(copy.name, control.velocity, scale, strongest, *gusts, start, end, *origin)


def lower_field(control: ANY_FIELD, origin: Origin) -> Field:
    """Return the row of a field.

    Args:
        control: The field.
        origin: The control.
    """
    start, end = span_of(control.during, NEVER_REACHED)
    scale = scale_constructor(control.scale)
    drift = control.drift if isinstance(control, Turbulence) and any(control.drift) else None
    field = _force_field(control)
    changing = field if scale is None and drift is None else Code(f"Changing({field})")
    return Field(changing, start, end, *origin, scale, drift)


def _force_field(control: ANY_FIELD) -> Code:
    if isinstance(control, Wind):
        direction, strength = vector_unit(control.direction), control.acceleration
        if control.radius is None:
            return call_of("gs.force_fields.Constant", direction=direction, strength=strength)
        # The engine wants the middle of the stream as an array.
        where = {"radius": control.radius, "center": tuple(control.center)}
        return call_of("gs.force_fields.Wind", direction=direction, strength=strength, **where)
    if isinstance(control, Drag):
        return call_of("gs.force_fields.Drag", linear=control.linear, quadratic=control.quadratic)
    if isinstance(control, Attraction):
        where = tuple(control.center)
        return call_of("Attraction", center=where, strength=control.strength, falloff=control.falloff)
    if isinstance(control, Vortex):
        around = {"swirl": control.swirl, "inward": control.inward, "falloff": control.falloff}
        return call_of("Whirl", center=tuple(control.center), **around)
    gusts = {"strength": control.strength, "frequency": control.frequency, "seed": control.seed}
    return call_of("gs.force_fields.Turbulence", **gusts)
