"""A case with nothing left out: defaults, values of expressions, derived settings, and what came of it as comments.

What is written is a case of the language, and the same simulation.
"""

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel

from text2sim.compiler.build import Resolution
from text2sim.compiler.film_lights import STUDIOS
from text2sim.compiler.film_places import PLACE_AND_LIGHT_FIELDS, is_chosen
from text2sim.compiler.looks import finish_of_body
from text2sim.compiler.masses import masses
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.soft.explicit import add_soft
from text2sim.spec_schema.arithmetic.evaluation import evaluate
from text2sim.spec_schema.arithmetic.expressions import Expression
from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.resolution import COPY_VARIABLES
from text2sim.spec_schema.arithmetic.values import ExpressionError, Value
from text2sim.spec_schema.models.base import Pose
from text2sim.spec_schema.models.bodies import Articulated, Driven
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.regions import BodyPoint, BodyRegion
from text2sim.spec_schema.text.canonical import dump_layout
from text2sim.spec_schema.text.document import Path, value_at
from text2sim.spec_schema.text.layout import LayoutEntry, plain_layout
from text2sim.spec_schema.vocabulary.words import fields_of

AS_WRITTEN = (Place, BodyRegion, BodyPoint, Expect)
"""Models in which a default, written out, would mean something else or contradict the rest."""
APPLIED_SECTIONS = ("params", "prefabs", "variants", "sweeps")
"""Sections that are already applied."""
MOST_SUBSTEPS = 200
"""Most that a case may ask for; a very stiff body may get more, and the lint says what that costs."""


@dataclass
class Explicit:
    """A case with nothing left out."""

    data: dict[str, Any]
    """Plain data. Only what differs from copy to copy is still an expression."""
    comments: dict[Path, str] = field(default_factory=dict)
    """Comments behind values."""

    def text(self, head: list[str] | None = None) -> str:
        """Return it in canonical form, with its comments and the lines `head` above them."""
        root = plain_layout(self.data)
        for path, comment in self.comments.items():
            entry: LayoutEntry | None = root
            for step in path:
                entry = entry.child(step) if entry is not None else None
            if entry is not None:
                entry.trail = f"# {' '.join(comment.split())}"
        return dump_layout(root, [*(head or []), ""] if head else [], [])

    def only(self, name: str) -> "Explicit":
        """Return one body or static alone.

        Raises:
            KeyError: if there is none of that name.
        """
        path = ("bodies", name) if name in self.data["bodies"] else ("scene", "statics", name)
        inner = value_at(self.data, path)
        for step in reversed(path):
            inner = {step: inner}
        return Explicit(inner, {key: text for key, text in self.comments.items() if key[: len(path)] == path})


def explicit(resolution: Resolution) -> Explicit:
    """Return a case with everything that it left open written out."""
    loaded = resolution.loaded
    found = Explicit(_plain(loaded.case))
    for key in APPLIED_SECTIONS:
        found.data.pop(key, None)
    if not found.data.get("waive"):
        found.data.pop("waive", None)
    params = loaded.data.get("params") or {}
    for path, text in loaded.document.sites.items():
        if loaded.varies(path):
            _set_at(found.data, path, folded(text, params))
    _add_settings(found, resolution)
    add_soft(found.data, found.comments, resolution)
    _add_render(found, resolution)
    _add_copies(found, resolution)
    return found


def _plain(value: Any) -> Any:
    """Return a model as plain data, defaults included."""
    if isinstance(value, AS_WRITTEN):
        return _plain(value.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True))
    if isinstance(value, BaseModel):
        rows = {key: getattr(value, attribute) for key, (attribute, _) in fields_of(type(value)).items()}
        data = {key: _plain(item) for key, item in rows.items() if item is not None}
        if isinstance(value, Articulated) and value.file is not None:
            # The file has materials of its own: only what the case says overrides them.
            data["material"] = value.material.model_dump(mode="json", exclude_unset=True, exclude_none=True)
        return data
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return escaped(value) if isinstance(value, str) else value


def _set_at(data: Any, path: Path, value: Any) -> None:
    value_at(data, path[:-1])[path[-1]] = value


# --- what was derived -----------------------------------------------------------------------------------------


def _add_settings(found: Explicit, resolution: Resolution) -> None:
    settings, scene = resolution.settings, found.data["scene"]
    places: dict[str, tuple[Path, Any]] = {
        "substeps": (("substeps",), settings.substeps),
        "solver": (("solver", "kind"), settings.solver),
        "iterations": (("solver", "iterations"), settings.iterations),
        "tolerance": (("solver", "tolerance"), settings.tolerance),
        "friction_cone": (("contact", "friction_cone"), settings.cone),
        "max_pairs": (("contact", "max_pairs"), settings.max_pairs),
        "timeconst": (("contact", "timeconst"), settings.timeconst),
        "max_speed": (("max_speed",), resolution.plan.max_speed),
    }
    for name, (path, value) in places.items():
        why = settings.why.get(name)
        if name == "timeconst" and settings.bounce_time and why is not None:
            # Written out, it would also decide how bodies bounce.
            text = f"timeconst, left out, is {value:g} s, and of contacts that bounce {settings.bounce_time:.3g} s"
            found.comments["scene", "contact"] = f"{text}: {settings.why.get('bounce_time', why)}"
            continue
        if name == "substeps" and settings.substeps > MOST_SUBSTEPS:
            found.comments["scene", "dt"] = f"substeps, left out, are {settings.substeps:,}: {why}"
            continue
        if value is not None:
            _set_at(scene, path, value)
        if why is not None:
            found.comments["scene", *path] = f"derived: {why}"
    case = resolution.loaded.case
    if case.scene.record.rate is None:
        scene["record"] = {"rate": case.record_rate, **scene["record"]}
        many = (
            "frames of deformable bodies are large" if settings.soft is not None else "frames of rigid bodies are small"
        )
        found.comments["scene", "record", "rate"] = f"derived: {many}"
    if case.scene.solver.iterations is None:
        found.comments["scene", "solver", "iterations"] = "derived: goes with the solver"


def _add_render(found: Explicit, resolution: Resolution) -> None:
    plan, render = resolution.plan.render, found.data["render"]
    auto = plan["auto"]
    if auto is None and "during" not in render:
        render["during"] = [plan["start"], plan["end"]]
        found.comments["render", "during"] = "the whole run"
    if auto is not None:
        left = ("cameras", *(("during", "speed", "shots") if auto["times"] else ()))
        for key in left:
            render.pop(key, None)
        found.comments["render",] = f"{', '.join(left)} follow from what is recorded"
    given = resolution.loaded.case.render
    if is_chosen(given):
        for key in sorted(PLACE_AND_LIGHT_FIELDS):
            render.pop(key, None)
        found.comments["render", "supports"] = "place and light are chosen from the case"
    elif given.setting is not None and "lighting" not in given.model_fields_set:
        render.pop("lighting", None)
    elif not render["lights"]:
        studio = STUDIOS[given.lighting]
        found.comments["render", "lighting"] = f"means {', '.join(studio.lights)}, on: {studio.backdrop}"


# --- what it became -------------------------------------------------------------------------------------------


def _add_copies(found: Explicit, resolution: Resolution) -> None:
    weights = masses(resolution)
    case = resolution.loaded.case
    for section, models in ((("scene", "statics"), case.scene.statics), (("bodies",), case.bodies)):
        for name, model in models.items():
            copies = resolution.placed[name]
            root: Path = (*section, name)
            data = value_at(found.data, root)
            if model.place is None and model.pose is None:
                data["pose"] = _plain(Pose())
            place = "place" if model.place is not None else "pose" if model.repeat is None else "repeat"
            if model.place is not None or model.repeat is not None:
                found.comments[*root, place] = _positions(copies)
            _add_look(found, root, model, copies)
            if section == ("bodies",) and not isinstance(model, Driven):
                found.comments[root] = _weight(copies, weights)


def _add_look(found: Explicit, root: Path, model: Any, copies: list[Copy]) -> None:
    """Write out the finish, and the colour if the case gives none and no file may have one."""
    look = value_at(found.data, root)["look"]
    look["finish"] = finish_of_body(model)
    parts = getattr(copies[0].shape, "parts", {}).values() if copies else ()
    kinds = {getattr(part, "shape", part).kind for part in parts}
    kinds.add(getattr(copies[0].shape, "kind", "") if copies else "")
    if isinstance(model, Articulated):
        kinds |= {link.shape.kind for link in (model.links or {}).values()}
    if not copies or model.look.color is not None or "mesh" in kinds or getattr(model, "file", None) is not None:
        return
    look["color"] = copies[0].color
    found.comments[*root, "look"] = "derived: by its name" if root[0] == "bodies" else "derived: what never moves"


def _positions(copies: list[Copy]) -> str:
    """Say where copies start."""

    def at(copy: Copy) -> str:
        return "[" + ", ".join(f"{round(value, 5) + 0.0:.5g}" for value in copy.pos) + "]"

    if len(copies) == 1 and copies[0].index is None:
        return f"at {at(copies[0])}"
    if len(copies) <= 4:
        return f"at {', '.join(map(at, copies))}"
    low, high = (
        ", ".join(f"{round(pick(axis), 5) + 0.0:.5g}" for axis in zip(*(copy.pos for copy in copies), strict=True))
        for pick in (min, max)
    )
    return f"{len(copies)} copies, from [{low}] to [{high}]"


def _weight(copies: list[Copy], weights: dict[str, float]) -> str:
    own = [weights[copy.name] for copy in copies if copy.name in weights]
    if not own:
        return f"{len(copies)} copies" if len(copies) > 1 else "its mass is left to the engine"
    if len(copies) == 1:
        return f"{own[0]:.4g} kg"
    low, high = min(own), max(own)
    each = f"{low:.4g} kg" if high - low < 1e-6 * high else f"{low:.4g} to {high:.4g} kg"
    return f"{len(copies)} copies of {each}, {sum(own):.4g} kg in all"


def folded(text: str, params: Mapping[str, Value]) -> str:
    """Return a scalar with its parameters filled in: its `${…}` keep only what differs from copy to copy."""
    parts = parse_interpolation(text, True).parts
    return "".join(_folded(part, params) if isinstance(part, Expression) else escaped(part) for part in parts)


def escaped(text: str) -> str:
    """Return text with each `${` escaped, so that it begins no expression."""
    return text.replace("${", "$${")


def _folded(expression: Expression, params: Mapping[str, Value]) -> str:
    tree = ast.parse(" ".join(expression.text.split()), mode="eval").body
    return "${" + ast.unparse(_fold(tree, params)) + "}"


def _fold(node: ast.expr, params: Mapping[str, Value]) -> ast.expr:
    if not any(isinstance(inner, ast.Name) and inner.id in COPY_VARIABLES for inner in ast.walk(node)):
        try:
            return _literal(evaluate(node, params))
        except (ExpressionError, OverflowError):
            pass  # in a branch that is never taken, perhaps
    for name, inner in ast.iter_fields(node):
        if isinstance(inner, ast.expr) and not (isinstance(node, ast.Call) and name == "func"):
            setattr(node, name, _fold(inner, params))
        elif isinstance(inner, list):
            setattr(node, name, [_fold(item, params) if isinstance(item, ast.expr) else item for item in inner])
    return node


def _literal(value: Value) -> ast.expr:
    if isinstance(value, bool):
        return ast.Name("true" if value else "false", ast.Load())
    if isinstance(value, list):
        return ast.List([_literal(item) for item in value], ast.Load())
    if isinstance(value, int | float) and value < 0:
        return ast.UnaryOp(ast.USub(), ast.Constant(-value))
    return ast.Constant(value)
