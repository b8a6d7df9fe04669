"""Documentation of the installed Genesis for a coding agent: signatures, and docstrings on demand.

Read from the package's sources without importing it, so that it is neither outdated nor guessed.
"""

import ast
import importlib.util
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from text2sim.spec_schema.errors import MachineError, nearest

OPTION_SOURCES = {
    "gs.options": ("options/solvers.py", "options/vis.py"),
    "gs.renderers": ("options/renderers.py",),
    "gs.morphs": ("options/morphs.py",),
    "gs.surfaces": ("options/surfaces.py",),
    "gs.textures": ("options/textures.py",),
    "gs.materials": ("engine/materials/rigid.py", "engine/materials/kinematic.py"),
    "gs.materials.MPM": ("engine/materials/MPM",),
    "gs.materials.FEM": ("engine/materials/FEM",),
    "gs.materials.PBD": ("engine/materials/PBD",),
    "gs.materials.SPH": ("engine/materials/SPH",),
    "gs.force_fields": ("engine/force_fields.py",),
}
"""Sources of option classes, which are configured by their fields, by the prefix of their names."""
CLASS_SOURCES = {
    "Scene": ("engine/scene.py",),
    "Camera": ("vis/camera.py",),
    "RigidEntity": ("engine/entities/rigid_entity/rigid_entity.py", "engine/entities/base_entity.py"),
    "scene.rigid_solver": ("engine/solvers/rigid/rigid_solver.py",),
    "RigidLink": ("engine/entities/rigid_entity/rigid_link.py",),
    "MPMEntity": ("engine/entities/mpm_entity.py", "engine/entities/particle_entity.py"),
    "PBDEntity": ("engine/entities/pbd_entity.py", "engine/entities/particle_entity.py"),
    "FEMEntity": ("engine/entities/fem_entity.py", "engine/entities/base_entity.py"),
}
"""Sources of the classes whose methods are documented."""
HELPERS = (
    "FEMVisGeom",
    "EntityDescription",
    "SceneDescription",
    "EnvironmentLayout",
    "SceneCheckpoint",
    "TrajectorySource",
)
"""Classes in these sources that are something else."""
SKIPPED = (
    "GravityMixin",
    "TimeBasedMixin",
    "FoamOptions",
    "BatchRenderer",
    "Drone",
    "USD",
    "MeshSet",
    "SFOptions",
    "ToolOptions",
    "ViewerOptions",
)
UNDOCUMENTED = (
    "__init__",
    "get_state",
    "add_weld_constraint",
    "delete_weld_constraint",
    "fix_particles_to_link",
    "set_dofs_armature",
    "set_dofs_damping",
    "set_dofs_stiffness",
)
"""Methods that programs need and that have no docstring, at least in one class."""
_BOOKKEEPING = re.compile(r"init_.*|.*_grads?|.*_ckpt|process_input|sample|instantiate")
"""Methods with docstrings that the engine calls itself."""
MAX_DEFAULT_LENGTH = 40
"""Longest default value that is shown [characters]."""
MAX_DOCSTRING_LENGTH = 6_000
"""Longest docstring that is shown [characters]."""


class ApiEntry(NamedTuple):
    """A class or method."""

    line: str
    """Its signature, with the beginning of its docstring."""
    doc: str
    """Its docstring."""


@cache
def documentation() -> dict[str, ApiEntry]:
    """Return all documented classes and methods, by name, in the order of the digest.

    Raises:
        MachineError: If Genesis is not installed.
    """
    spec = importlib.util.find_spec("genesis")
    if spec is None or spec.origin is None:
        raise MachineError("Genesis is not installed")
    root, found = Path(spec.origin).parent, dict[str, ApiEntry]()
    init = next(node for node in ast.parse((root / "__init__.py").read_text("utf-8")).body if _defines(node, "init"))
    found["gs.init"] = _method("gs.init", init)  # type: ignore[arg-type]
    for prefix, places in OPTION_SOURCES.items():
        for node in _classes(root, places):
            if node.name[0] != "_" and node.name not in SKIPPED:
                name = f"{prefix}.{node.name}"
                if prefix == "gs.options" and node.name.endswith("Light"):
                    name = f"gs.options.vis.{node.name}"  # not re-exported by the package
                made = next((part for part in node.body if _defines(part, "__init__")), None)
                options = _options(name, node)
                bare = made is None or "()" not in options.line  # a class with fields accepts them as arguments
                found[name] = options if bare else _method(name, made)  # type: ignore[arg-type]
    for owner, places in CLASS_SOURCES.items():
        for node in _classes(root, places):
            for part in () if node.name in HELPERS else node.body:
                if isinstance(part, ast.FunctionDef) and _is_public(part):
                    name = owner if part.name == "__init__" else f"{owner}.{part.name}"
                    if name == "Scene" or name != owner:  # a scene makes all others
                        found.setdefault(name, _method(name, part))
    return found


def digest() -> str:
    """Return one line for each class and method."""
    return "\n".join(entry.line for entry in documentation().values())


def docstrings_of(names: list[str]) -> str:
    """Return the docstrings of classes and methods; for an unknown name, the nearest known one."""
    rows, known = [], documentation()
    for name in names:
        method = name.rpartition(".")[2]
        match = next((entry for entry in known if entry == name or entry.endswith(f".{name}")), None)
        match = match or next((entry for entry in known if entry.endswith(f".{method}")), None)
        if match is None:
            hint = nearest(method, [entry.rpartition(".")[2] for entry in known])
            rows.append(f"There is nothing called `{name}`" + (f"; there is `{hint}`." if hint else "."))
        else:
            rows.append(f"{known[match].line}\n\n{known[match].doc[:MAX_DOCSTRING_LENGTH]}".strip())
    return "\n\n---\n\n".join(rows)


def _classes(root: Path, places: tuple[str, ...]) -> Iterator[ast.ClassDef]:
    for place in places:
        path = root / place
        for file in sorted(path.glob("*.py")) if path.is_dir() else [path]:
            if file.is_file():
                yield from (node for node in ast.parse(file.read_text("utf-8")).body if isinstance(node, ast.ClassDef))


def _options(name: str, node: ast.ClassDef) -> ApiEntry:
    """Fields of an options class with their defaults, without those of its bases."""
    fields = [
        f"{part.target.id}={_shortened(part.value) if part.value is not None else 'REQUIRED'}"
        for part in node.body
        if isinstance(part, ast.AnnAssign) and isinstance(part.target, ast.Name) and part.target.id[0] != "_"
    ]
    bases = [ast.unparse(base) for base in node.bases]
    more = f" + {', '.join(bases)}" if bases and bases != ["Options"] else ""
    return ApiEntry(f"{name}({', '.join(fields)}){more}", ast.get_docstring(node) or "")


def _method(name: str, node: ast.FunctionDef) -> ApiEntry:
    doc = ast.get_docstring(node) or ""
    arguments = node.args
    defaults = [*[None] * (len(arguments.args) - len(arguments.defaults)), *arguments.defaults, *arguments.kw_defaults]
    words = [
        parameter.arg if default is None else f"{parameter.arg}={_shortened(default)}"
        for parameter, default in zip([*arguments.args, *arguments.kwonlyargs], defaults, strict=True)
        if parameter.arg != "self"
    ]
    about = " ".join(doc.split("\n\n")[0].split())[:110]
    return ApiEntry(f"{name}({', '.join(words)})" + (f"  # {about}" if about else ""), doc)


def _is_public(node: ast.FunctionDef) -> bool:
    """Whether a program may call a method: no kernel or property, nothing that the engine calls itself."""
    marks = [ast.unparse(mark) for mark in node.decorator_list]
    if any("qd." in mark or "setter" in mark or "property" in mark for mark in marks):
        return False
    if node.name in UNDOCUMENTED:
        return True
    return node.name[0] != "_" and bool(ast.get_docstring(node)) and not _BOOKKEEPING.fullmatch(node.name)


def _defines(node: ast.stmt, name: str) -> bool:
    return isinstance(node, ast.FunctionDef) and node.name == name


def _shortened(node: ast.expr) -> str:
    text = ast.unparse(node)
    return text if len(text) <= MAX_DEFAULT_LENGTH else "…"
