"""The command `text2sim render --suggest`."""

import sys
from typing import TYPE_CHECKING, Any

from text2sim.cli.output import say, say_json
from text2sim.cli.recorded import Chosen
from text2sim.revision.files import rewrite
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.plain import plain
from text2sim.spec_schema.text.source import read_source

if TYPE_CHECKING:
    from text2sim.rendering.suggest import RenderProposal


def propose(chosen: Chosen, *, write: bool, as_json: bool) -> None:
    """Propose a camera and light for a run, and with `write` add them to its case.

    Args:
        chosen: The run, and its case if that is known.
        write: Whether to change the case.
        as_json: Print one JSON document.

    Raises:
        RunError: if there is no case to write to.
        SpecError: if the case would be invalid with them.
    """
    from text2sim.rendering.suggest import suggest
    from text2sim.revision.revise import revise
    from text2sim.spec_schema.load import load_case
    from text2sim.spec_schema.text.canonical import dump_case

    if write and chosen.case is None:
        raise RunError("a run does not know its case: name the case instead of the run to write to it")
    loaded = chosen.loaded or load_case(chosen.recording.folder / "expanded.yaml")
    quiet = (lambda text: None) if as_json else (lambda text: print(plain(text), file=sys.stderr, flush=True))
    proposal = suggest(chosen.recording, loaded, quiet)
    if write and chosen.case is not None:
        source = read_source(chosen.case)
        rewrite(chosen.case, source, revise(source, chosen.case, proposal.operations, "render").text)
    if as_json:
        say_json(_document(proposal, written=write))
        return
    say(dump_case({"render": proposal.render}).rstrip())
    say()
    for line in _reasons(proposal):
        say(line)
    if write and chosen.case is not None:
        say(f"{display_path(chosen.case)}: written")
    elif chosen.case is not None:
        say("--write writes it to the case")


def _document(proposal: "RenderProposal", *, written: bool) -> dict[str, Any]:
    return {
        "ok": True,
        "render": proposal.render,
        "patch": proposal.operations,
        "written": written,
        "score": proposal.score,
        "before": proposal.before,
        "lights": proposal.lights,
        "legibility": proposal.legibility,
        "tried": proposal.tried,
    }


def _reasons(proposal: "RenderProposal") -> list[str]:
    """Describe the legibility of bodies, as lines."""
    lines = [
        f"{proposal.tried} cameras tried: this one scores {proposal.score:.2f}, the current one {proposal.before:.2f}"
    ]
    if proposal.score <= proposal.before:
        lines.append("none of them shows more than the current one")
    if proposal.lights:
        lines.append(
            "contrast by light: " + ", ".join(f"{name} {value:.2f}" for name, value in proposal.lights.items())
        )
    for name, row in proposal.legibility["films"]["video"]["bodies"].items():
        hidden = "" if row["hidden"] is None else f", at most {row['hidden']:.0%} hidden"
        lines.append(f"{name}: {100 * row['share']['median']:.2g} % of the picture{hidden}")
    return lines + proposal.legibility["remarks"]
