"""Whether everything that a case names is there, and fits."""

from collections.abc import Mapping

from text2sim.spec_schema.bodies import Articulated, Rigid
from text2sim.spec_schema.cast import Cast, Parts
from text2sim.spec_schema.circles import find_circles
from text2sim.spec_schema.control_references import check_controls
from text2sim.spec_schema.document import Path
from text2sim.spec_schema.errors import Problem, sort_problems
from text2sim.spec_schema.event_references import check_events
from text2sim.spec_schema.expect_references import check_expectations
from text2sim.spec_schema.load import LoadedCase
from text2sim.spec_schema.measure_references import check_measures
from text2sim.spec_schema.render import Follow
from text2sim.spec_schema.time_references import check_time
from text2sim.spec_schema.tree_references import check_mount, check_tree


def check_references(loaded: LoadedCase, parts: Mapping[str, Parts] | None = None) -> list[Problem]:
    """Check every name and selector of a case.

    Args:
        loaded: The case.
        parts: Links and joints of files, chains, nets and ragdolls by name of the body, which only the
            compiler knows; those of bodies that are not in it are taken for granted.

    Returns:
        What is wrong, in the order of the file. Whatever needs geometry is left to the compiler.
    """
    cast = Cast(loaded, parts or {})
    _check_names(cast)
    _check_places(cast)
    check_time(cast)
    for name, body in cast.bodies.items():
        if isinstance(body, Articulated):
            check_tree(cast, name, body)
        elif isinstance(body, Rigid):
            check_mount(cast, name, body)
    check_controls(cast)
    check_measures(cast)
    check_events(cast)
    check_expectations(cast)
    _check_cameras(cast)
    return sort_problems(cast.problems)


def _check_names(cast: Cast) -> None:
    for name in cast.bodies:
        if name in cast.statics:
            line = cast.loaded.line(("scene", "statics", name))
            message = f"`{name}` is the name of a static, too (line {line}); a name stands for one thing"
            cast.report(("bodies", name), message, "duplicate-name", key=True)


def _check_places(cast: Cast) -> None:
    targets: dict[str, str] = {}
    roots: dict[str, Path] = {}
    for section, models in ((("scene", "statics"), cast.statics), (("bodies",), cast.bodies)):
        for name, model in models.items():
            roots[name] = (*section, name)
            if model.place is None:
                continue
            found = cast.find(model.place.target, (*section, name, "place", model.place.relation), parts=False)
            if found is not None:
                targets[name] = found.name
    for circle in find_circles(targets):
        message = f"is placed in relation to itself: {' -> '.join([*circle, circle[0]])}"
        cast.report((*roots[circle[0]], "place"), message, "circular-place", key=True)


def _check_cameras(cast: Cast) -> None:
    for name, camera in cast.loaded.case.render.cameras.items():
        field = "body" if isinstance(camera, Follow) else "look_at"
        target = getattr(camera, field)
        if isinstance(target, str):
            cast.find(target, ("render", "cameras", name, field))
