"""Restitution, made from contact damping, against the time step.

A bouncing contact is a spring and damper with the angular frequency w = 1 / (time constant x damping ratio). It lasts
pi / w. The explicit step h is stable up to h w = 0.95 (measured: above, each bounce gains energy). Up to 0.4 the
restitution is accurate to 0.05, so messages ask for that. See `compiler.settings`.
"""

from collections.abc import Iterator
from math import ceil, pi

from text2sim.compiler.contact_materials import restitutions
from text2sim.compiler.settings import CONTACT_PHASE
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.text.document import Path

ENERGY_BOUND = 0.95
"""Largest substep times angular frequency of a bouncing contact at which the engine stays stable."""
SCATTER_BOUND = 0.4
"""The same for a restitution that is accurate to 0.05."""
MAX_BOUNCE_TIME = 0.02
"""Longest time [s] that a bouncing contact may last without a warning."""


def _bounciest(facts: Facts) -> tuple[float, Path]:
    """Return the largest restitution of a case with bouncing bodies, and its path."""
    rows = [row for group in facts.placed.values() for row in restitutions(group[:1]).items()]
    name, largest = max(rows, key=lambda row: (row[1], row[0]))
    body, _, link = name.partition(".")
    inside = () if not link else (link,) if link == "payload" else ("links", link)
    return largest, facts.where(body_of(body), *inside, "material", "restitution")


def _gains_energy(facts: Facts) -> bool:
    """Return whether bouncing contacts are unstable at the substep."""
    return facts.substep > ENERGY_BOUND * facts.settings.bounce_time * (1 + 1e-9)


def _unstable(facts: Facts) -> Iterator[Problem]:
    time = facts.settings.bounce_time
    if time and _gains_energy(facts):
        largest, where = _bounciest(facts)
        needed = ceil(facts.case.scene.dt / (SCATTER_BOUND * time))
        text = (
            f"restitution {largest:g} with contact timeconst {facts.settings.timeconst:g} s gains energy at a substep "
            f"of {facts.substep:g} s; use scene.substeps of at least {needed}, or a longer timeconst"
        )
        yield facts.problem("restitution-step", where, text)


def _soft(facts: Facts) -> Iterator[Problem]:
    time = facts.settings.bounce_time
    if pi * time > MAX_BOUNCE_TIME and not _gains_energy(facts):
        needed = ceil(facts.case.scene.dt * pi / (MAX_BOUNCE_TIME * CONTACT_PHASE))
        text = f"bouncing contacts last {pi * time:.2g} s and look soft; use scene.substeps of {needed} or more"
        yield facts.problem("soft-bounce", _bounciest(facts)[1], text)


_BALL = """\
scene: {%s}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {restitution: 0.8}, pose: {pos: [0, 0, 1]}}
"""

RULES = (
    Rule(
        id="restitution-step",
        severity="error",
        title="Bouncing contacts are too fast for the time step and gain energy.",
        reason="""\
The engine has no restitution. The compiler makes it from the stiffness and damping of the contact, a spring that the
solver integrates explicitly. At a substep above 0.95 times `timeconst x damping ratio` every bounce gains energy, and
bodies shoot away.""",
        remedy="Use more substeps, or leave `scene.contact.timeconst` to the compiler.",
        example=_BALL % "substeps: 1, contact: {timeconst: 0.02}",
        fix="scene: {substeps: null, contact: null, dt: 0.01}",
        run=_unstable,
        own_contact=True,
    ),
    Rule(
        id="soft-bounce",
        title="Bouncing contacts are soft: they last long enough to be visible.",
        reason="""\
At long substeps the compiler softens bouncing contacts to keep them stable. Above 20 ms a contact shows as a dent, and
bodies in a row no longer collide one after the other.""",
        remedy="Use more substeps; the message says how many.",
        example=_BALL % "dt: 0.01, substeps: 2",
        fix="scene: {substeps: null}",
        run=_soft,
        own_contact=True,
    ),
)
