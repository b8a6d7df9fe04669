"""All rules, in the order in which they are listed."""

from text2sim.lint.contact import bounce, creep, driven_through, nets, sliding, tunnelling
from text2sim.lint.film import hanging, leaving, unseen_subjects, viewpoints
from text2sim.lint.joints import angles, following, holding, ranges_and_anchors, ropes, stiff_beams
from text2sim.lint.numbers import counted_twice, densities, magnitudes, masses, meshes, springs, steps, stiffness
from text2sim.lint.rule import EXAMPLE_BASE, Rule
from text2sim.lint.script import (
    at_rest,
    contradictions,
    dead_entries,
    events_at_start,
    outcomes,
    pushes,
    too_early,
    unused_names,
)
from text2sim.lint.soft import (
    cloths,
    cost,
    elements,
    families,
    feet,
    folds,
    grid,
    ipc,
    loaded_cloth,
    proportions,
    sap,
    solver_domain,
    starts,
    tearing,
    unheeded,
    walls,
)
from text2sim.lint.start import edges, floor, overlap, selfcontact, unsupported

__all__ = ["EARLIER_RULES", "EXAMPLE_BASE", "RETIRED_RULES", "RULES", "Rule", "find_rule"]

RULES: tuple[Rule, ...] = (
    *overlap.RULES,
    *selfcontact.RULES,
    *floor.RULES,
    *unsupported.RULES,
    *edges.RULES,
    *tunnelling.RULES,
    *driven_through.RULES,
    *sliding.RULES,
    *creep.RULES,
    *nets.RULES,
    *magnitudes.RULES,
    *densities.RULES,
    *counted_twice.RULES,
    *meshes.RULES,
    *stiffness.RULES,
    *springs.RULES,
    *bounce.RULES,
    *steps.RULES,
    *pushes.RULES,
    *holding.RULES,
    *following.RULES,
    *ranges_and_anchors.RULES,
    *ropes.RULES,
    *stiff_beams.RULES,
    *angles.RULES,
    *masses.RULES,
    *unused_names.RULES,
    *dead_entries.RULES,
    *events_at_start.RULES,
    *outcomes.RULES,
    *contradictions.RULES,
    *too_early.RULES,
    *at_rest.RULES,
    *unseen_subjects.RULES,
    *leaving.RULES,
    *hanging.RULES,
    *viewpoints.RULES,
    *families.RULES,
    *starts.RULES,
    *walls.RULES,
    *feet.RULES,
    *folds.RULES,
    *grid.RULES,
    *solver_domain.RULES,
    *cloths.RULES,
    *loaded_cloth.RULES,
    *elements.RULES,
    *proportions.RULES,
    *sap.RULES,
    *unheeded.RULES,
    *ipc.RULES,
    *tearing.RULES,
    *cost.RULES,
)

EARLIER_RULES = ("after-end", "driven-subject", "no-final")
"""Warnings of earlier stages, which a case can waive too."""


RETIRED_RULES = (
    "contact-timeconst",
    "empty-camera",
    "falls-along-slider",
    "few-pairs",
    "heavy-armature",
    "late-drive",
    "outside-domain",
    "restitution-unused",
    "rough-bounce",
    "soft-contact",
    "too-little-energy",
    "unfelt-push",
    "weak-press",
)
"""Rules of earlier versions, which cases may still waive."""


def find_rule(name: str) -> Rule | None:
    """Return the rule with that id, or None."""
    return next((rule for rule in RULES if rule.id == name), None)
