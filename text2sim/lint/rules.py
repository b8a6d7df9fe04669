"""All rules, in the order in which they are listed."""

from text2sim.lint import (
    angles,
    at_rest,
    bounce,
    cameras,
    contradictions,
    energy,
    floor,
    following,
    holding,
    idle,
    joints,
    leaving,
    limits,
    magnitudes,
    masses,
    meshes,
    names,
    nets,
    nowhere,
    outcomes,
    overlap,
    pushes,
    script,
    selfcontact,
    sliding,
    soon,
    steps,
    stiffness,
    tunnelling,
    viewpoints,
)
from text2sim.lint.rule import EXAMPLE_BASE, Rule

__all__ = ["EARLIER", "EXAMPLE_BASE", "RULES", "Rule", "find_rule"]

RULES: tuple[Rule, ...] = (
    *overlap.RULES,
    *selfcontact.RULES,
    *floor.RULES,
    *nowhere.RULES,
    *tunnelling.RULES,
    *sliding.RULES,
    *nets.RULES,
    *magnitudes.RULES,
    *meshes.RULES,
    *stiffness.RULES,
    *bounce.RULES,
    *steps.RULES,
    *pushes.RULES,
    *holding.RULES,
    *idle.RULES,
    *following.RULES,
    *joints.RULES,
    *angles.RULES,
    *masses.RULES,
    *limits.RULES,
    *names.RULES,
    *script.RULES,
    *outcomes.RULES,
    *contradictions.RULES,
    *soon.RULES,
    *energy.RULES,
    *at_rest.RULES,
    *cameras.RULES,
    *leaving.RULES,
    *viewpoints.RULES,
)

EARLIER = ("after-end", "driven-subject", "no-final")
"""Warnings that are given before the lint, and that can be waived too."""


def find_rule(name: str) -> Rule | None:
    """Return the rule with that id, if there is one."""
    return next((rule for rule in RULES if rule.id == name), None)
