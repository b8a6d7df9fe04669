"""Controls that the solver of a deformable body cannot apply, and what to do instead."""

from text2sim.compiler.soft.controls import ANY_FIELD
from text2sim.compiler.soft.solvers import is_soft, solver_of, solvers_of
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.controls import Attach
from text2sim.spec_schema.names.selectors import body_of

MOVED_BY_FIELDS = ("mpm", "pbd")


def check_soft_controls(loaded: LoadedCase) -> list[Problem]:
    """Return what is wrong with the controls of deformable bodies, given their solvers."""
    found = []
    case = loaded.case
    solvers = solvers_of(case.bodies.values(), case.scene)
    for name, control in case.actions.controls.items():
        where = ("actions", "controls", name)
        if isinstance(control, ANY_FIELD):
            if not solvers & set(MOVED_BY_FIELDS):
                message = _nothing_moved(control.kind, solvers)
                found.append(loaded.problem((*where, "kind"), message, rule="field-on-nothing"))
        elif isinstance(control, Attach) and is_soft(body := case.bodies.get(body_of(control.body))):
            solver = solver_of(body, case.scene)
            if solver == "pbd" and control.stiffness is not None:
                message = "stiffness does not apply to solver pbd, which holds particles exactly; leave it out"
                found.append(loaded.problem((*where, "stiffness"), message, key=True, rule="firm-only"))
            if solver == "ipc" and control.strength is not None:
                message = "strength is for cloth of solver pbd, and this one is simulated by ipc; leave it out"
                found.append(loaded.problem((*where, "strength"), message, key=True, rule="no-strength"))
            holder = case.bodies.get(body_of(control.to))
            if solver == "ipc" and is_soft(holder):
                message = "cloth of solver pbd is sewn to cloth, and this one is simulated by ipc; leave it out"
                found.append(loaded.problem((*where, "to"), message, rule="soft-holder"))
    return found


def _nothing_moved(kind: str, solvers: set[str]) -> str:
    if not solvers:
        return f"{kind} moves bodies with solver mpm or pbd (soft, cloth, grains, liquids), and there is none"
    instead = "use force" if "fem" in solvers else "let rigid bodies push them"
    return f"{kind} moves bodies with solver mpm or pbd, and those here have {', '.join(sorted(solvers))}; {instead}"
