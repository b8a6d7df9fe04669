"""Solver settings that the author left open, derived from the scene, each with its reason."""

from dataclasses import dataclass
from math import acos, acosh, ceil, exp, sqrt

from text2sim.compiler.soft.setup import SoftSettings
from text2sim.spec_schema.models.scene import Scene

CROWD_BODIES = 100
"""With more loose bodies than this, the Newton solver is 20 to 60 times slower than CG."""
MAX_NEWTON_LOOPS, MAX_NEWTON_BALL_JOINTS = 12, 40
"""With more closed loops or links on ball joints, CG is faster and survives impacts better."""
CONTACT_PHASE = 0.25
"""Substep times angular frequency of a contact that bounces. Restitution then scatters by some hundredths with the
moment of touch within a step; at 0.85, near the end of what is stable, by 0.15, and contacts can gain energy."""
RIGID_SUBSTEPS = 50
"""Most substeps that are derived for rigid bodies."""
SPRING_STEP = 0.8
"""Substep times angular frequency of a rope's springs, which the engine integrates explicitly: at 2 they explode."""
TAUT_STEP = 1.0
"""Substep times angular frequency of a taut rope: 1.4 still holds, 1.5 does not."""
BOUNCE_STEP = 0.0005
"""Longest substep [s] for contacts that bounce; at this one they last 6 ms."""
MIN_INERTIA_SHARE = 1e-6
"""Least part of a link in the inertia of what hangs on it that numbers of 32 bits do not lose: 1.4e-7 and 4e-8 end in
nan at a touch, 2e-6 holds (50 kg on 20 links of 11 g)."""
MIN_TIMECONST = 0.002
"""Shortest time constant [s] of contacts that is derived; an author may give a shorter one."""


@dataclass(frozen=True)
class Traits:
    """What the settings depend on."""

    loose: int
    """Bodies that can touch each other freely."""
    geoms: int
    """Convex pieces in the scene."""
    chains: int
    """Links on ball joints."""
    loops: int
    """Equality constraints."""
    attaches: int
    """Run-time welds and bonds."""
    fastest: float
    """Largest known speed [m/s] at the start."""
    thinnest: float
    """Smallest thickness [m] of any piece."""
    bounciest: float
    """Largest restitution; 0 if none is given."""
    linked: bool
    """Whether any body is a tree of several links."""
    rolls: bool = False
    """Whether a material has rolling or torsional friction."""
    fragments: bool = False
    """Whether a body is cut into fragments."""
    slopes: bool = False
    """Whether something may rest on a slope, or lean."""
    carries: bool = False
    """Whether the surface of a static moves."""
    grips: bool = False
    """Whether motors close parts of mechanisms on each other, with a free body in the scene."""
    tautest: float = 0.0
    """Largest angular frequency [rad/s] of ropes and chains that sway sideways under what hangs on them."""
    swiftest: float = 0.0
    """Largest angular frequency [rad/s] of springs that keep ropes and beams straight."""
    wound: bool = False
    """Whether a rope goes round something."""
    slightest: float = 1.0
    """Least part of a link in the inertia, about its joint, of all that hangs on it."""


@dataclass(frozen=True)
class Settings:
    """Resolved solver settings. `why` holds a sentence for each that was derived."""

    substeps: int
    solver: str
    iterations: int
    tolerance: float | None
    cone: str
    timeconst: float
    bounce_time: float
    """Inverse [s] of the angular frequency of contacts that bounce; 0 if none does."""
    max_pairs: int
    noslip: int
    hibernation: bool
    welds: int
    why: dict[str, str]
    rolls: bool
    """Whether contacts resist rolling and spin."""
    precision: str
    """Bits of the engine's numbers."""
    soft: SoftSettings | None
    """None in a scene without deformable bodies."""

    def contact_damping(self, restitution: float, step: float) -> tuple[float, float]:
        """Return time constant [s] and damping ratio for the contacts of a body, in a scene in which something bounces.

        All contacts are equally stiff: their angular frequency is 1 / (time constant x damping ratio).
        """
        ratio = damping_ratio(restitution)
        return max(self.bounce_time, 2 * step) if restitution <= 0.0 else self.bounce_time / ratio, ratio

    def notes(self) -> list[str]:
        """Return the reasons as lines `name = value: reason`."""
        values = {
            "substeps": self.substeps,
            "solver": self.solver,
            "friction_cone": self.cone,
            "timeconst": f"{self.timeconst:g} s",
            "bounce_time": f"{self.bounce_time:.3g} s",
            "tolerance": f"{self.tolerance:g}" if self.tolerance else "",
            "max_pairs": self.max_pairs,
            "precision": self.precision,
        }
        reasons = dict(self.why)
        if self.soft is not None:
            values |= self.soft.values()
            reasons |= self.soft.why
        return [f"{name} = {values[name]}: {reason}" for name, reason in reasons.items() if name in values]


def restitution_of(ratio: float) -> float:
    """Return the restitution of a linear spring and damper that pushes but never pulls, for its damping ratio.

    The contact ends when its force is zero, which is before the spring is relaxed (Schwager and Pöschel 2007,
    "Coefficient of restitution and linear-dashpot model revisited").
    """
    if ratio < 1.0:
        return exp(-2.0 * ratio / sqrt(1.0 - ratio**2) * acos(ratio))
    if ratio > 1.0:
        return exp(-2.0 * ratio / sqrt(ratio**2 - 1.0) * acosh(ratio))
    return exp(-2.0)


def damping_ratio(restitution: float) -> float:
    """Return the damping ratio of a contact that returns `restitution` of the speed; 1 if it returns none.

    At most 2, a restitution of 0.05: with more, the damping would reverse the speed within a step.
    """
    if restitution <= 0.0:
        return 1.0
    low, high = 0.0, 2.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if restitution_of(middle) > restitution else (low, middle)
    return high


def derive(scene: Scene, traits: Traits, soft: SoftSettings | None) -> Settings:
    """Choose what the author left open.

    Args:
        scene: The section.
        traits: What is in it.
        soft: Settings of the solvers of deformable bodies, if there are any.
    """
    why: dict[str, str] = {}
    substeps = scene.substeps or _substeps(scene, traits, soft, why)
    step = scene.dt / substeps
    solver = scene.solver.kind or _solver(traits, why)
    iterations = scene.solver.iterations
    if iterations is None:
        iterations = 60 if solver == "cg" and traits.loose > CROWD_BODIES else 50
    timeconst = scene.contact.timeconst or _timeconst(step, traits, why)
    bounce_time = _bounce_time(scene, step, traits, why)
    max_pairs = scene.contact.max_pairs
    if max_pairs is None:
        max_pairs = max(150, 16 * traits.geoms)
        why["max_pairs"] = f"16 for each of {traits.geoms} convex pieces"
    cone = scene.contact.friction_cone or _cone(scene, solver, traits, soft, why)
    precision = "32" if soft is None else soft.precision
    if soft is None and traits.slightest < MIN_INERTIA_SHARE:
        precision, why["precision"] = "64", "32 bits lose light links beside what hangs on them"
    return Settings(
        substeps=substeps,
        solver=solver,
        iterations=iterations,
        tolerance=_tolerance(scene, solver, why),
        cone=cone,
        timeconst=timeconst,
        bounce_time=bounce_time,
        max_pairs=max_pairs,
        noslip=scene.solver.noslip_iterations,
        hibernation=scene.solver.hibernation,
        welds=max(8, traits.attaches),
        why=why,
        rolls=traits.rolls,
        precision=precision,
        soft=soft,
    )


def _solver(traits: Traits, why: dict[str, str]) -> str:
    if traits.loose > CROWD_BODIES:
        why["solver"] = f"{traits.loose} loose bodies can touch each other; newton is 20 times slower on such piles"
    elif traits.loops > MAX_NEWTON_LOOPS or traits.chains > MAX_NEWTON_BALL_JOINTS:
        why["solver"] = (
            f"{traits.chains} links and {traits.loops} closed loops: cg is faster and survives impacts better"
        )
    elif traits.wound:
        why["solver"] = "with the elliptic cone, newton ends in nan where links are hit hard"
    else:
        why["solver"] = "few enough bodies for the exact solver"
        return "newton"
    return "cg"


def _timeconst(step: float, traits: Traits, why: dict[str, str]) -> float:
    timeconst = max(2 * step, MIN_TIMECONST)
    if traits.wound and 4 * step < timeconst:
        why["timeconst"] = "four substeps: in longer contacts a light rope sinks into what it goes round"
        return 4 * step
    why["timeconst"] = (
        "two substeps: the stiffest contact that stays stable"
        if 2 * step >= MIN_TIMECONST
        else "the shortest that is derived: two substeps are less, and may be given"
    )
    return timeconst


def _cone(scene: Scene, solver: str, traits: Traits, soft: SoftSettings | None, why: dict[str, str]) -> str:
    """Choose the exact cone where something rests on a slope, leans or is gripped, and where it is known to be stable.

    With cg its friction does not converge within 60 iterations (a wall of 115 bricks shifts by 20 mm in 0.1 s). With
    newton, ball joints and closed loops that are hit hard end in nan; free bodies do not, up to 30 m/s and 250 kg, nor
    do hinges and sliders with links of 10 g, which get it only where a grip needs it.
    """
    # With deformable bodies it is known to be stable only in contact model `particle`, for what rolls.
    beside = soft is None or (soft.model == "particle" and traits.rolls)
    sound = beside and traits.bounciest == 0 and not scene.solver.noslip_iterations
    single = solver == "newton" and not (traits.linked or traits.loops)
    if sound and single and (traits.slopes or traits.rolls):
        why["friction_cone"] = (
            "the pyramidal one lets what rests on a slope or leans creep, and what rolls roll too far"
            if traits.rolls
            else "what rests on a slope or leans creeps with the pyramidal one"
        )
        return "elliptic"
    if sound and single and traits.carries:
        why["friction_cone"] = "the pyramidal one throws up what a moving surface carries off"
        return "elliptic"
    if sound and solver == "newton" and traits.grips and not (traits.chains or traits.loops):
        why["friction_cone"] = "what motors grip creeps out of the grip with the pyramidal one"
        return "elliptic"
    if sound and solver == "cg" and traits.wound:
        why["friction_cone"] = "light ropes round something fly apart with the pyramidal one"
        return "elliptic"
    why["friction_cone"] = "survives hard impacts; elliptic does not creep on slopes"
    return "pyramidal"


def _substeps(scene: Scene, traits: Traits, soft: SoftSettings | None, why: dict[str, str]) -> int:
    wanted = {1: "nothing in the scene needs shorter steps"}

    def need(step: float, reason: str) -> None:
        wanted[max(1, ceil(scene.dt / step - 1e-9))] = reason

    if traits.loose > 1:
        need(0.005, "at 10 ms stacked and piled bodies sink into each other")
    if traits.loose > CROWD_BODIES:
        need(0.0025, "at 5 ms and more the bodies of a dense pile sink into each other")
    if traits.fragments:
        need(0.002, "thin fragments that carry a falling body sink into the ground at longer steps")
    if traits.chains or traits.loops:
        need(0.0025, "trees of ball joints and closed loops drift or explode at longer steps")
    if traits.tautest > 0:
        need(TAUT_STEP / traits.tautest, "ropes and chains shake themselves apart under their loads at longer steps")
    if traits.swiftest > 0:
        need(SPRING_STEP / traits.swiftest, "the springs that keep ropes and beams straight shake at longer steps")
    if traits.fastest > 0:
        need(
            max(traits.thinnest / traits.fastest, 2e-4),
            f"at {traits.fastest:g} m/s a body may not cross the thinnest piece ({traits.thinnest:g} m) in one step",
        )
    if traits.bounciest > 0:
        need(BOUNCE_STEP, "restitution is made from contact damping, which wants steps of half a millisecond")
    wanted = {min(substeps, RIGID_SUBSTEPS): reason for substeps, reason in wanted.items()}
    for step, reason in soft.substeps if soft is not None else ():
        need(step, reason)
    substeps = max(wanted)
    why["substeps"] = wanted[substeps]
    return substeps


def _tolerance(scene: Scene, solver: str, why: dict[str, str]) -> float | None:
    if scene.solver.tolerance is not None or solver != "newton":
        return scene.solver.tolerance
    why["tolerance"] = "the engine's own, 1e-5 of the mean inertia, leaves light bodies among heavy ones unsolved"
    return 1e-8


def _bounce_time(scene: Scene, step: float, traits: Traits, why: dict[str, str]) -> float:
    if traits.bounciest <= 0:
        return 0.0
    if scene.contact.timeconst is not None:
        return scene.contact.timeconst * damping_ratio(traits.bounciest)
    why["bounce_time"] = "contacts that bounce last pi times this; shorter ones would scatter at this substep"
    return step / CONTACT_PHASE
