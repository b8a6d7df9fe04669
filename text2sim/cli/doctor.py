"""The command `text2sim doctor`."""

from dataclasses import asdict

import typer

from text2sim.cli.options import AsJson
from text2sim.cli.output import say, say_json
from text2sim.service import exits


def doctor(as_json: AsJson = False) -> None:
    """Report what this machine has and lacks, and how to fix that. Takes about ten seconds."""
    from text2sim.runtime.inspection import inspect_machine

    findings = inspect_machine()
    ready = all(finding.ok for finding in findings if finding.severity == "required")
    if as_json:
        say_json({"ok": ready, "findings": [asdict(finding) for finding in findings]})
        raise typer.Exit(exits.OK if ready else exits.MACHINE)
    width = max(len(finding.name) for finding in findings)
    for finding in findings:
        mark = "ok" if finding.ok else "MISSING" if finding.severity == "required" else "none"
        say(f"{mark:<8}{finding.name:<{width}}  {finding.value}")
        if finding.fix:
            say(f"{'':<8}{'':<{width}}  -> {finding.fix}")
    say("ready to run cases" if ready else "not ready: fix what is MISSING")
    raise typer.Exit(exits.OK if ready else exits.MACHINE)
