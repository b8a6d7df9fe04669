"""All rules, in the order in which they are listed."""

from text2sim.lint.contact import bounce, creep, nets, sliding, tunnelling
from text2sim.lint.contact import driven_through as ploughing
from text2sim.lint.film import cameras, empty, leaving, viewpoints
from text2sim.lint.joints import angles, following, holding, idle, joints, ropes
from text2sim.lint.numbers import counted_twice as twice
from text2sim.lint.numbers import densities, limits, magnitudes, masses, meshes, steps, stiffness
from text2sim.lint.rule import EXAMPLE_BASE, Rule
from text2sim.lint.script import at_rest, contradictions, energy, names, outcomes, pushes, script
from text2sim.lint.script import events_at_start as beginnings
from text2sim.lint.script import too_early as soon
from text2sim.lint.soft import (
    acting,
    cloths,
    cost,
    elements,
    families,
    grid,
    ipc,
    proportions,
    records,
    sap,
    starts,
    walls,
)
from text2sim.lint.soft import solver_domain as room
from text2sim.lint.start import edges, floor, overlap, selfcontact
from text2sim.lint.start import unsupported as nowhere

__all__ = ["EARLIER", "EXAMPLE_BASE", "RULES", "Rule", "find_rule"]

RULES: tuple[Rule, ...] = (
    *overlap.RULES,
    *selfcontact.RULES,
    *floor.RULES,
    *nowhere.RULES,
    *edges.RULES,
    *tunnelling.RULES,
    *ploughing.RULES,
    *sliding.RULES,
    *creep.RULES,
    *nets.RULES,
    *magnitudes.RULES,
    *densities.RULES,
    *twice.RULES,
    *meshes.RULES,
    *stiffness.RULES,
    *bounce.RULES,
    *steps.RULES,
    *pushes.RULES,
    *holding.RULES,
    *idle.RULES,
    *following.RULES,
    *joints.RULES,
    *ropes.RULES,
    *angles.RULES,
    *masses.RULES,
    *limits.RULES,
    *names.RULES,
    *script.RULES,
    *beginnings.RULES,
    *outcomes.RULES,
    *contradictions.RULES,
    *soon.RULES,
    *energy.RULES,
    *at_rest.RULES,
    *cameras.RULES,
    *empty.RULES,
    *leaving.RULES,
    *viewpoints.RULES,
    *families.RULES,
    *starts.RULES,
    *walls.RULES,
    *grid.RULES,
    *room.RULES,
    *cloths.RULES,
    *elements.RULES,
    *proportions.RULES,
    *sap.RULES,
    *records.RULES,
    *ipc.RULES,
    *acting.RULES,
    *cost.RULES,
)

EARLIER = ("after-end", "driven-subject", "no-final")
"""Warnings that are given before the lint, and that can be waived too."""


def find_rule(name: str) -> Rule | None:
    """Return the rule with that id, if there is one."""
    return next((rule for rule in RULES if rule.id == name), None)
