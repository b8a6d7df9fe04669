"""Controls that the solver of a deformable body cannot apply, and what to do instead."""

from text2sim.compiler.soft.controls import ANY_FIELD
from text2sim.compiler.soft.solvers import is_soft, solver_of, solvers_of
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.controls import Attach, Force, Impulse, InitialVelocity
from text2sim.spec_schema.names.selectors import body_of

MOVED_BY_FIELDS = ("mpm", "pbd")


def check_solvers(loaded: LoadedCase) -> list[Problem]:
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
            continue
        if not isinstance(control, Attach | Force | Impulse | InitialVelocity):
            continue
        body = case.bodies.get(body_of(control.body))
        if not is_soft(body):
            continue
        solver = solver_of(body, case.scene)
        if case.scene.contact.model == "ipc" or solver == "ipc":
            message = (
                f"{_control_in_words(control.kind)} does not reach bodies of contact model ipc: its solver holds and "
                "moves their points itself; let rigid bodies push and clamp them"
            )
            found.append(loaded.problem((*where, "kind"), message, rule="not-in-ipc"))
        elif isinstance(control, Attach) and control.stiffness is not None and solver == "pbd":
            message = "the particles of pbd are held exactly, or not at all: leave out stiffness"
            found.append(loaded.problem((*where, "stiffness"), message, key=True, rule="firm-only"))
    return found


def _control_in_words(kind: str) -> str:
    return {"initial_velocity": "a start velocity", "attach": "an attachment", "impulse": "an impulse"}.get(
        kind, f"a {kind}"
    )


def _nothing_moved(kind: str, solvers: set[str]) -> str:
    if not solvers:
        return f"{kind} moves bodies with solver mpm or pbd (soft, cloth, grains, liquids), and there is none"
    return f"{kind} moves bodies with solver mpm or pbd, and those here have {', '.join(sorted(solvers))}; use force"
