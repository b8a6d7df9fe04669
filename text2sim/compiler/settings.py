"""Solver settings that the author left open, derived from the scene, each with its reason."""

from dataclasses import dataclass
from math import ceil, log, pi, sqrt

from text2sim.spec_schema.scene import Scene

CROWD = 100
"""More loose bodies than this and the Newton solver is 20 to 60 times slower than CG."""


@dataclass(frozen=True)
class Traits:
    """What the settings depend on."""

    loose: int
    """Bodies that can touch each other freely."""
    geoms: int
    """Convex pieces of everything."""
    chains: int
    """Links on ball joints."""
    loops: int
    """Equality constraints."""
    attaches: int
    """Run-time welds."""
    fastest: float
    """Largest known speed [m/s] at the start."""
    thinnest: float
    """Smallest thickness [m] of any piece."""
    bounciest: float
    """Largest restitution; 0 if none is given."""


@dataclass(frozen=True)
class Settings:
    """Resolved solver settings. `why` holds a sentence for each that was derived."""

    substeps: int
    solver: str
    iterations: int
    tolerance: float | None
    cone: str
    timeconst: float
    max_pairs: int
    noslip: int
    hibernation: bool
    welds: int
    why: dict[str, str]

    def notes(self) -> list[str]:
        """The reasons as lines `name = value: reason`."""
        values = {
            "substeps": self.substeps,
            "solver": self.solver,
            "friction_cone": self.cone,
            "timeconst": f"{self.timeconst:g} s",
            "max_pairs": self.max_pairs,
        }
        return [f"{name} = {values[name]}: {reason}" for name, reason in self.why.items()]


def damping_ratio(restitution: float) -> float:
    """Damping ratio of a linear spring contact that returns `restitution` of the speed.

    A damped oscillator leaves the contact with e = exp(-pi z / sqrt(1 - z^2)); solved for z.
    """
    if restitution <= 0:
        return 1.0
    x = log(restitution)
    return -x / sqrt(pi**2 + x**2)


def derive(scene: Scene, traits: Traits) -> Settings:
    """Choose what the author left open."""
    why: dict[str, str] = {}
    substeps = scene.substeps or _substeps(scene, traits, why)
    step = scene.dt / substeps
    solver = scene.solver.kind
    if solver is None:
        crowded = traits.loose > CROWD
        tangled = traits.loops > 12 or traits.chains > 40
        solver = "cg" if crowded or tangled else "newton"
        if crowded:
            why["solver"] = f"{traits.loose} loose bodies can touch each other; newton is 20 times slower on such piles"
        elif tangled:
            why["solver"] = f"{traits.chains} links and {traits.loops} closed loops: cg is faster and survives impacts better"
        else:
            why["solver"] = "few enough bodies for the exact solver"
    iterations = scene.solver.iterations
    if iterations is None:
        iterations = 60 if solver == "cg" and traits.loose > CROWD else 50
    timeconst = scene.contact.timeconst
    if timeconst is None:
        timeconst = _timeconst(step, traits, why)
    max_pairs = scene.contact.max_pairs
    if max_pairs is None:
        max_pairs = max(150, 16 * traits.geoms)
        why["max_pairs"] = f"16 for each of {traits.geoms} convex pieces"
    cone = scene.contact.friction_cone
    if cone is None:
        cone = "pyramidal"
        why["friction_cone"] = "survives hard impacts; elliptic does not creep on slopes"
    return Settings(
        substeps=substeps,
        solver=solver,
        iterations=iterations,
        tolerance=scene.solver.tolerance,
        cone=cone,
        timeconst=timeconst,
        max_pairs=max_pairs,
        noslip=scene.solver.noslip_iterations,
        hibernation=scene.solver.hibernation,
        welds=max(8, traits.attaches),
        why=why,
    )


def _substeps(scene: Scene, traits: Traits, why: dict[str, str]) -> int:
    wanted = {1: "nothing in the scene needs shorter steps"}

    def need(step: float, reason: str) -> None:
        wanted[max(1, ceil(scene.dt / step - 1e-9))] = reason

    if traits.loose > 1:
        need(0.005, "at 10 ms stacked and piled bodies sink into each other")
    if traits.loose > CROWD:
        need(0.0025, "at 5 ms and more the bodies of a dense pile sink into each other")
    if traits.chains or traits.loops:
        need(0.0025, "trees of ball joints and closed loops drift or explode at longer steps")
    if traits.fastest > 0:
        need(max(traits.thinnest / traits.fastest, 2e-4), f"at {traits.fastest:g} m/s a body may not cross the thinnest piece ({traits.thinnest:g} m) in one step")
    if traits.bounciest > 0:
        need(0.001, "restitution is made from contact damping, which wants steps of a millisecond")
    substeps = max(wanted)
    why["substeps"] = wanted[max(wanted)]
    return min(substeps, 50)


def _timeconst(step: float, traits: Traits, why: dict[str, str]) -> float:
    if traits.bounciest > 0:
        # The engine's bound for a contact that must not gain energy is step <= 0.95 timeconst dampratio.
        timeconst = max(2 * step, step / (0.85 * damping_ratio(traits.bounciest)))
        why["timeconst"] = f"shortest contact that bounces with {traits.bounciest:g} without gaining energy at this step"
        return timeconst
    why["timeconst"] = "two substeps: the stiffest contact that stays stable"
    return max(2 * step, 0.002)
