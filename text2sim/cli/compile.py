"""The command `text2sim compile`."""

from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.options import AsJson, Sets, Variants, overlay_of
from text2sim.cli.output import say, say_json
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import Text2SimError


def compile_cases(
    case: Annotated[Path, typer.Argument(help="A case folder or case.yaml file.")],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Folder of the program; CASE_FOLDER/program if left out."),
    ] = None,
    variants: Variants = None,
    sets: Sets = None,
    as_json: AsJson = False,
) -> None:
    """Write the Genesis program of a case, to read or to run by hand."""
    from text2sim.cli.cases import say_examined
    from text2sim.compiler.build import compile_case
    from text2sim.harness.folder import install_program, staging
    from text2sim.service.examined import examine

    examined = examine(case, to="loaded", overlay=overlay_of(variants, sets))
    program = (out if out is not None else examined.path.parent / "program").absolute()
    files: list[str] = []
    if examined.loaded is not None:
        with staging(program.parent) as stage:
            try:
                examined.plan = compile_case(examined.loaded, stage / program.name)
            except Text2SimError as error:
                examined.blame(error)
            else:
                examined.problems = list(examined.plan.warnings)
                examined.collect_sources()
                install_program(stage / program.name, program)
                files = sorted(str(p.relative_to(program)) for p in program.rglob("*") if p.is_file())
    if as_json:
        written = {"program": str(program), "files": files} if files else {}
        say_json(examined.as_dict() | written)
        raise typer.Exit(examined.exit)
    say_examined(examined)
    for file in files:
        say(display_path(program / file))
    raise typer.Exit(examined.exit)
