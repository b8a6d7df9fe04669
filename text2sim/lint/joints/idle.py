"""Motors without a drive: the engine's motors give no force until they have a target (see `motors`)."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import spans_of
from text2sim.lint.joints.loaded_joint import LoadedJoint
from text2sim.lint.joints.mechanics import mechanics_of
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem


def _idle(facts: Facts) -> Iterator[Problem]:
    mechanics = mechanics_of(facts)
    driven = {(facts.copies[entity].body, joint) for entity, joint in spans_of(facts)}
    bodies: dict[str, list[LoadedJoint]] = {}
    for joint in mechanics.joints():
        where = mechanics.where(joint, "actuator")
        if joint.motor is None or (joint.copy.body, joint.name) in driven or facts.value_at(where) is None:
            continue
        # The motor of a prefab may stay idle, as long as its joint does not sag.
        if facts.loaded.document.origin(where) is None or _sags(joint):
            bodies.setdefault(joint.copy.body, []).append(joint)
    for joints in bodies.values():
        names = list(dict.fromkeys(f"`{mechanics.label(joint)}`" for joint in joints))
        listed = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
        then = "their joints move" if len(names) > 1 else "its joint moves"
        text = (
            f"no control drives {listed}: a motor without a drive gives no force, and {then} freely; add a control "
            "of kind `drive` (a constant `position` holds it), or leave the actuator out"
        )
        yield facts.problem("idle-motor", mechanics.where(joints[0], "actuator"), text, key=True)


def _sags(joint: LoadedJoint) -> bool:
    """Return whether gravity moves a joint that nothing holds."""
    scale = joint.mass * 9.81 * (joint.size if joint.hinge else 1.0)
    return max(map(abs, joint.pull)) > max(joint.spec.friction, 0.01 * scale) or joint.mass <= 0.0


RULES = (
    Rule(
        id="idle-motor",
        severity="warning",
        title="A joint has a motor that no control drives.",
        reason="""\
An actuator does nothing until a control of kind `drive` gives it a target: it does not hold the start pose. The joint
moves as freely as without an actuator.""",
        remedy="Drive it (`position: 0` holds the pose of the case), or leave the actuator out.",
        example="""\
bodies:
  gate:
    kind: rigid
    shape: {kind: box, size: [0.5, 0.05, 0.3]}
    pose: {pos: [0, 0, 0.5]}
    mount: {kind: hinge, axis: y, anchor: [-0.25, 0, 0], actuator: {stiffness: 500, damping: 50}}
""",
        fix="""\
bodies: {gate: {mount: {actuator: {stiffness: 5000, damping: 500}}}}
actions: {controls: {hold: {kind: drive, joint: gate, position: 0}}}
""",
        run=_idle,
    ),
)
