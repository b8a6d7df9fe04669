"""The command `text2sim mcp`."""

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.output import say
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import MachineError, RunError


def mcp(
    root: Annotated[Path, typer.Option("--root", help="The folder that the tools may read and write.")] = Path(),
) -> None:
    """Serve the tools to a coding agent by the Model Context Protocol over standard input and output."""
    if not root.is_dir():
        raise RunError(f"{display_path(root)}: there is no such folder")
    # Pictures are drawn in threads, with which those of the matrix library would compete.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        from text2sim.mcp_server.server import serve
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("mcp", "mcp_types", "anyio"):
            raise
        raise MachineError("the protocol's SDK is not installed here: pip install 'text2sim[agents]'") from None
    if sys.stdin.isatty():
        say("text2sim mcp waits for an agent on its standard input; Ctrl-C ends it", to=sys.stderr)
    serve(root.resolve())
