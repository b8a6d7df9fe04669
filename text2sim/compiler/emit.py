"""Plan to program text: templates, a check that each module is Python, and formatting."""

import json
import subprocess
import sys
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, TemplateError

from text2sim import __version__
from text2sim.compiler.emit_actions import TEMPLATES, action_context, copied_actions
from text2sim.compiler.literal import Code, comment, identifier, literal
from text2sim.compiler.plan import EntityPlan, Group, Plan, Surface
from text2sim.compiler.settings import Settings
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.compiler.soft.setup import SoftSettings
from text2sim.compiler.soft.solvers import holds_up
from text2sim.spec_schema.errors import MachineError
from text2sim.spec_schema.models.soft_bodies import FLOWING
from text2sim.spec_schema.whole_files import naming

FILM_MODULES = (
    "ambience.py", "cadence.py", "cameras.py", "directing.py", "overlays.py", "pacing.py", "playback.py",
    "standpoints.py", "viewpoints.py", "video.py", "film.py",
)  # fmt: skip
"""Modules that draw the film, and those they import."""
FILM_TEMPLATES = (*FILM_MODULES, "soft_film.py", "soft_states.py", "shading.py", "render.py.j2")
"""Templates that no simulation depends on."""
COPIED_MODULES = ("engine.py", "files.py", "contacts.py", "recorder.py", "solids.py", *FILM_MODULES)
COPIED_SOFT = ("filling.py", "soft.py", "skins.py", "soft_states.py", "soft_film.py", "shading.py", "streams.py")
"""Also copied into programs with deformable bodies."""
MODULES = ("scene.py", "bodies.py", "actions.py", "render.py", "main.py")

UNRECORDED = ("mass", "bending", "elastic", "gas", "damping", "stream", "adhesion")
"""Facts of deformable bodies that the recorder does not need."""
FROM_FILE = ("MJCF", "URDF", "Mesh")
"""Morphs that read a file of the program."""
OWN_MATERIALS: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "TearingSolid": (("tearing_solid.py",), {"tear_stretch": Code("float('inf')")}),
    "Corotated": (("corotated.py",), {}),
    "DampSand": (("damp_sand.py",), {"cohesion": 0.0}),
    "HardeningSnow": (("hardening_snow.py",), {}),
    "Viscoplastic": (("viscoplastic.py",), {"viscosity": 0.0}),
    "ViscousLiquid": (("viscous_liquid.py", "corotated.py"), {"viscosity": 0.0}),
}
"""Materials of our own: their modules, and what their own properties are in a copy without. If copies of a body differ,
all are of the first of their materials."""
KEPT_OUT_EVERY = 1.25e-3
"""Time [s] after which what flows is moved out of walls again, and compared with the room that it has; or a quarter of
a step, if that is longer."""
RATE_DEPENDENT = {"HardeningSnow", "Viscoplastic", "ViscousLiquid"}
"""Those of them that need to know the substep."""

# Roughness and metallic of the engine's surfaces; its rasteriser shows little of the difference.
ENGINE_FINISHES = {
    "rough": (0.9, 0.0),
    "painted": (0.5, 0.0),
    "plastic": (0.4, 0.0),
    "smooth": (0.2, 0.0),
    "rubber": (0.9, 0.0),
    "metal": (0.3, 0.8),
    "brushed_metal": (0.45, 0.8),
    "polished_metal": (0.1, 0.9),
    "wood": (0.7, 0.0),
    "concrete": (1.0, 0.0),
    "brick": (1.0, 0.0),
    "ceramic": (0.15, 0.0),
    "glass": (0.05, 0.0),
    "frosted_glass": (0.4, 0.0),
    "cloth": (1.0, 0.0),
    "silicone": (0.5, 0.0),
    "paper": (0.95, 0.0),
    "sand": (1.0, 0.0),
    "cardboard": (0.95, 0.0),
    "leather": (0.6, 0.0),
    "felt": (1.0, 0.0),
    "plaster": (0.95, 0.0),
    "marble": (0.2, 0.0),
    "jelly": (0.1, 0.0),
    "peel": (0.4, 0.0),
    "foliage": (0.9, 0.0),
    "bark": (1.0, 0.0),
    "fur": (1.0, 0.0),
    "crust": (0.6, 0.0),
    "stone": (0.95, 0.0),
}


class TemplateBug(Exception):
    """A template made something that is not a program: our fault, never the author's."""


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        undefined=StrictUndefined,
        finalize=literal,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    environment.filters["comment"] = comment
    return environment


def emit(plan: Plan) -> dict[str, bytes]:
    """Return the program: file contents by path inside its folder. Same plan, same bytes.

    Raises:
        TemplateBug: if a template fails or makes no Python.
    """
    context = _context(plan)
    texts = {}
    for module in MODULES:
        try:
            texts[module] = _environment().get_template(f"{module}.j2").render(context)
        except (TemplateError, TypeError, ValueError) as error:
            raise TemplateBug(f"{module}.j2: {error}") from error
    files = {name: text.encode() for name, text in _format(texts).items()}
    copied = [*COPIED_MODULES, *(COPIED_SOFT if plan.deformables else ()), *copied_actions(plan)]
    copied += ["ipc_coupler.py"] if plan.settings.soft and plan.settings.soft.ipc else []
    copied += ["friction.py"] if plan.frictions else []
    copied += ["coils.py", "spring_film.py"] if plan.springs else []
    copied += ["bounce.py"] if context["uneven"] else []
    copied += ["cloth_friction.py"] if context["cloth"] else []
    copied += ["cloth_on_grid.py"] if context["cloth_on_grid"] else []
    copied += sorted({file for name in context["own_materials"] for file in OWN_MATERIALS[name][0]})
    copied += ["internal_damping.py"] if context["dampings"] else []
    copied += ["gas.py"] if context["gases"] else []
    copied += ["flows.py"] if context["streams"] else []
    copied += ["grid_step.py", "singular_values.py", "threads.py", "transfers.py"] if context["masses"] else []
    copied += ["solid_walls.py"] if context["flowing"] or context["adhesions"] else []
    copied += ["liquid_volume.py"] if context["liquids"] else []
    copied += ["adhesion.py"] if context["adhesions"] else []
    copied += ["bending.py"] if context["bending"] else []
    copied += ["elastic_sheets.py"] if context["elastic"] else []
    files |= {name: (TEMPLATES / name).read_bytes() for name in copied} | dict(plan.files)
    return files | {"looks.json": _looks(plan)}


def _looks(plan: Plan) -> bytes:
    """Return colour and finish of every copy, to draw states that were recorded with other looks.

    A copy with several looks lists them, and for each of its links the number of the look of every part that is drawn.
    """
    looks: dict[str, Any] = {}
    for entity in plan.entities:
        if entity.part_surfaces:
            looks[entity.name] = _part_looks(entity)
        elif entity.surface:
            looks[entity.name] = _look(entity, entity.surface)
    rows = [f"  {json.dumps(name)}: {json.dumps(look)}" for name, look in looks.items()]
    return ("{\n" + ",\n".join(rows) + "\n}\n").encode()


def _part_looks(entity: EntityPlan) -> dict[str, Any]:
    looks: list[dict[str, Any] | None] = []
    links: dict[str, list[int]] = {}
    for name, surfaces in entity.part_surfaces.items():
        links[name] = []
        for surface in surfaces:
            look = surface and _look(entity, surface)
            if look not in looks:
                looks.append(look)
            links[name].append(looks.index(look))
    return {"looks": looks, "links": links}


def _look(entity: EntityPlan, surface: Surface) -> dict[str, Any]:
    look = {
        "color": list(surface.rgba[:3]),
        "opacity": surface.rgba[3],
        "finish": surface.finish,
        "visible": bool(entity.options.get("visualization", True)),
        "picture": surface.picture,
        **surface.decoration,
    }
    if surface.regions is None:
        return look
    return look | {"regions": surface.regions, "parts": [part and _look(entity, part) for part in surface.parts]}


def _format(texts: dict[str, str]) -> dict[str, str]:
    """Format every module; ruff rejects what is not Python."""
    with tempfile.TemporaryDirectory(prefix="text2sim-") as folder:
        paths = {name: Path(folder) / name for name in texts}
        for name, path in paths.items():
            with naming(path):
                path.write_text(texts[name], "utf-8")
        # -P: a `ruff.py` in the working directory, which may be anyone's, is not ruff.
        command = [sys.executable, *"-P -m ruff format --isolated --no-cache --line-length=120".split()]
        done = subprocess.run([*command, *map(str, paths.values())], capture_output=True, check=False)
        if done.returncode:
            complaint = done.stderr.decode().replace(folder, "").strip()
            # An error of the operating system, such as a full disk, is not a bug of ours.
            raise MachineError(f"{folder}: {complaint}") if "(os error" in complaint else TemplateBug(complaint)
        return {name: path.read_text("utf-8") for name, path in paths.items()}


def _context(plan: Plan) -> dict[str, Any]:
    settings = plan.settings
    names = ("substeps", "solver", "iterations", "friction_cone", "timeconst", "max_pairs")
    why = {name: Code(f"  # {comment(settings.why[name])}" if name in settings.why else "") for name in names}
    soft = settings.soft
    own_materials = {name for group in (*plan.statics, *plan.bodies) if (name := _own_material(group))}
    touching = soft is not None and soft.model == "particle"
    flowing = [name for name, facts in plan.deformables.items() if touching and facts.kind in FLOWING]
    return {
        **vars(plan),
        "version": comment(__version__),
        "case": comment(plan.case),
        "duration": round(plan.steps * plan.dt, 9),
        "gravity": tuple(plan.gravity),
        "solver": Code({"newton": "Newton", "cg": "CG"}[settings.solver]),
        "cone": Code(settings.cone),
        "why": why,
        "precision": Code(settings.precision),
        "soft": soft,
        "soft_why": _reasons(soft),
        "masses": {name: facts.mass for name, facts in plan.deformables.items() if facts.solver == "mpm"},
        "deformables": {
            name: {key: value for key, value in vars(facts).items() if key not in UNRECORDED}
            | ({} if facts.stream is None else {"stream": Code(f"STREAMS[{literal(name)}]")})
            for name, facts in plan.deformables.items()
        },
        "statics": [_group(group, settings) for group in plan.statics],
        "bodies": [_group(group, settings) for group in plan.bodies],
        "uses_models": any(entity.morph in FROM_FILE for entity in plan.entities),
        "statics_use_models": any(e.morph in FROM_FILE for g in plan.statics for e in g.entities),
        "unpowered": list(plan.unpowered),
        "contact": {name: damping for name, damping in plan.contact.items() if "." not in name},
        "uneven": len({damping for name, damping in plan.contact.items() if name not in plan.silent}) > 1,
        "link_contact": {tuple(name.split(".")): damping for name, damping in plan.contact.items() if "." in name},
        "cloth_on_grid": soft is not None and bool(soft.mpm and soft.pbd) and soft.model == "particle",
        "on_grid": _on_grid(plan),
        "cloth": next((name for name, facts in plan.deformables.items() if facts.solver == "pbd"), None),
        "own_materials": own_materials,
        "rate_dependent": own_materials & RATE_DEPENDENT,
        "dampings": {name: facts.damping for name, facts in plan.deformables.items() if facts.damping},
        "adhesions": {name: facts.adhesion for name, facts in plan.deformables.items() if facts.adhesion},
        "gases": {name: facts.gas for name, facts in plan.deformables.items() if facts.gas},
        "streams": {name: facts.stream for name, facts in plan.deformables.items() if facts.stream},
        "flowing": flowing,
        "held_up": holds_up(facts.kind for facts in plan.deformables.values() if facts.solver == "mpm"),
        "liquids": [name for name in flowing if plan.deformables[name].kind == "liquid"],
        "mpm_densities": {
            entity.name: entity.material_options["rho"]
            for entity in plan.entities
            if entity.soft is not None and entity.soft.solver == "mpm"
        },
        "kept_out_every": max(1, settings.substeps // 4, round(KEPT_OUT_EVERY * settings.substeps / plan.dt)),
        "bending": {name: facts.bending for name, facts in plan.deformables.items() if facts.bending},
        "elastic": {name: facts.elastic for name, facts in plan.deformables.items() if facts.elastic},
        **action_context(plan),
    }


def _on_grid(plan: Plan) -> str | None:
    """Return one of the bodies that move on a grid; None under contact models that leave the grid still."""
    if plan.settings.soft is None or plan.settings.soft.model not in ("particle", "rigid"):
        return None
    return next((name for name, facts in plan.deformables.items() if facts.solver == "mpm"), None)


def _reasons(soft: SoftSettings | None) -> dict[str, Code]:
    """Return the reasons of settings of deformable bodies as comments; empty for what the author decided."""
    if soft is None:
        return {}
    reasons = {name: comment(soft.why[name]) if name in soft.why else "" for name in soft.values()}
    if soft.mpm is not None:
        cell = f"cells of {soft.mpm.cell:g} m"
        reasons["mpm_cell"] = f"{cell}: {reasons['mpm_cell']}" if reasons["mpm_cell"] else cell
    # Bounds are long, so their comment has a line of its own.
    return {
        name: Code(reason and (f"# {reason}\n" if name.endswith("bounds") else f"  # {reason}"))
        for name, reason in reasons.items()
    }


def _group(group: Group, settings: Settings) -> dict[str, Any]:
    """Return what a group's template prints: constant cells as they are, varying cells as columns of a table."""
    own = _own_material(group)
    if own is not None:
        without = dict(OWN_MATERIALS[own][1])
        if own in RATE_DEPENDENT:
            without["substep"] = Code(f"DT / {settings.substeps}")
        if own == "HardeningSnow" and settings.soft and settings.soft.mpm:
            without["cell"] = settings.soft.mpm.cell
        alike = (replace(one, material=own, material_options=without | one.material_options) for one in group.entities)
        group = replace(group, entities=tuple(alike))
    first = group.entities[0]
    turned = any(tuple(entity.quat) != IDENTITY for entity in group.entities)
    rows = [_cells(entity, turned=turned) for entity in group.entities]
    single = len(rows) == 1 and "[" not in first.name
    varying = [] if single else [key for key in rows[0] if any(row[key] != rows[0][key] for row in rows)]
    if not single and not varying:
        varying = ["pos"]
    cells = {key: Code(key) if key in varying else value for key, value in rows[0].items()}
    rough, metallic = ENGINE_FINISHES[first.surface.finish] if first.surface else (None, None)
    count = len(rows)
    return {
        "ident": identifier(group.name),
        # A body `bodies` must not hide the program's own `add_bodies`; no name begins with an underscore.
        "adder": identifier(f"add_{'_' if group.name in ('bodies', 'statics') else ''}{group.name}"),
        "first": first.name,
        "line": group.line,
        "doc": Code(group.name if single else f"{count} {'copies' if count > 1 else 'copy'} of {group.name}"),
        "morph": Code(first.morph),
        "cells": cells,
        "rows": [] if single else [tuple(row[key] for key in varying) for row in rows],
        "columns": Code(", ".join(varying)),
        "target": Code("(" + ", ".join(varying) + ("," if len(varying) == 1 else "") + ")"),
        "material": Code(own or f"gs.materials.{first.material}"),
        "material_keys": [identifier(key) for key in _material_keys(first)],
        "mode": first.surface.mode if first.surface else None,
        "flat": first.surface is not None and first.surface.flat,
        "roughness": rough,
        "metallic": metallic,
    }


def _own_material(group: Group) -> str | None:
    materials = {entity.material for entity in group.entities}
    return next((name for name in OWN_MATERIALS if name in materials), None)


def _material_keys(entity: EntityPlan) -> list[str]:
    """Keyword arguments of an entity's material, by the names of its cells."""
    own = [key for key in ("rho", "friction") if getattr(entity, key) is not None]
    return own + list(entity.material_options)


def _cells(entity: EntityPlan, *, turned: bool) -> dict[str, Any]:
    flags: dict[str, Any] = {"fixed": False, "visualization": True, "contact": None, "keep": ()}
    flags |= {"collision": True, "maxvolume": None, "nobisect": True}
    return {
        **flags,
        **{key: tuple(v) if isinstance(v, list) else v for key, v in entity.options.items()},
        "pos": tuple(entity.pos),
        "quat": tuple(entity.quat) if turned else None,
        "rho": entity.rho,
        "friction": entity.friction,
        "color": entity.surface.rgba if entity.surface else None,
        "picture": entity.surface.picture if entity.surface else None,
        **entity.material_options,
    }
