"""The command `python -m text2sim`."""

import sys
from pathlib import Path

# Python looks for modules in the working directory first, whose files may be anyone's: a case's `mcp.py` is not ours.
if not sys.flags.safe_path and Path(sys.path[0]).resolve() != Path(__file__).resolve().parents[1]:
    del sys.path[0]

from text2sim.cli.main import run

if __name__ == "__main__":
    run()
