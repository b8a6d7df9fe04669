"""Reads hostile documents in a process of its own and watches what that process does.

    python tests/fuzz/trial.py --count 10000 --seed 1

Each is loaded, checked, worked out and linted, as `text2sim check` does; then it is formatted, written out, and
patched. Wrong is: an exception that is not for the user, a check that takes longer than `SECONDS` of a processor,
memory beyond `GIGABYTES`, a file opened outside the case's folder and the installation, a process other than the one
in which MuJoCo reads, a socket, code that is compiled from a document, and a round trip that does not lead back.
"""

import argparse
import contextlib
import json
import os
import re
import resource
import shutil
import signal
import sys
import sysconfig
import tempfile
import traceback
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a checkout that nobody installed

from draft import Draft  # noqa: E402
from hostile import OBJ, URDF  # noqa: E402
from mutate import SOFT, mutations, originals_of  # noqa: E402

SECONDS = 4.0
"""Of the processor; cutting two vases into fragments takes half of it."""
GIGABYTES = 1.0
WAIT = 40.0
"""Seconds on the clock after which a document is given up."""
MANY = 400
"""A case with as many copies is not written out: it takes as long as to check it, again."""
ROOT = Path(__file__).resolve().parents[2]

FORBIDDEN = ("subprocess.", "os.system", "os.exec", "os.spawn", "os.posix_spawn", "os.fork", "socket.", "ctypes.dlopen",
             "os.remove", "os.rename", "os.mkdir", "os.rmdir", "shutil.", "os.symlink", "os.link", "os.chmod", "urllib")  # fmt: skip


class Watch:
    """An audit hook that takes notes while it is armed."""

    def __init__(self) -> None:
        self.armed = False
        self.notes: list[str] = []
        self.folder = ""
        self.own: tuple[str, ...] = ()
        """Beginnings of the paths to which text2sim itself may write."""
        sys.addaudithook(self._hook)

    def _hook(self, event: str, args: tuple[Any, ...]) -> None:
        if not self.armed:
            return
        if event == "open" and isinstance(args[0], str | bytes):
            path, mode = os.path.realpath(os.fsdecode(args[0])), args[1]
            inside = path.startswith(self.folder)
            writes = isinstance(mode, str) and any(c in mode for c in "wax+")
            known = path.startswith((sys.prefix, sys.base_prefix, sysconfig.get_path("stdlib"), str(ROOT / "text2sim")))
            system = path.startswith(
                ("/proc/self/st", "/sys/", "/usr/", "/lib", "/etc/ld.so", "/etc/localtime", "/dev/null")
            )
            # `files` is how the folder for MuJoCo is opened when it is taken away, from within its parent.
            if not path.startswith(self.own) and args[0] != "files" and (writes or not (inside or known or system)):
                self.notes.append(f"opened {path}")
        elif event == "exec" and "case" in repr(args[0])[:80]:
            self.notes.append(f"ran {args[0]!r}")
        elif (
            event.startswith(FORBIDDEN) and not event.startswith("ctypes.dlopen") and not self._is_reading(event, args)
        ):
            self.notes.append(f"{event}{args!r:.200}")

    def _is_reading(self, event: str, args: tuple[Any, ...]) -> bool:
        """Whether this is part of handing a model to MuJoCo."""
        if event == "subprocess.Popen":
            return any(str(word).endswith(("inspection_child.py", "assets.confined")) for word in args[1])
        below = isinstance(args[-1], int) and args[-1] >= 0  # of a folder that is open
        return below or (isinstance(args[0], str) and args[0].startswith(self.own))


class SlowError(BaseException):
    """It took too long."""


def _too_slow(*_: Any) -> None:
    raise SlowError


def examine(folder: Path, draft: Draft) -> tuple[str, Any]:
    """Check one case; return the kind of answer, and the resolved case if it came to that."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case
    from text2sim.spec_schema.errors import SpecError, Text2SimError
    from text2sim.spec_schema.load import load_case
    from text2sim.spec_schema.reuse.sweeps import runs_of

    try:
        loaded = load_case(folder, draft.overlay)
        for name in loaded.written.data.get("sweeps") or ():
            runs_of(loaded.written, name)
        case = resolve_case(loaded)
        report = lint_case(case)
    except SpecError as error:
        for problem in error.problems:
            if not problem.message or "\n" in problem.message or problem.line < 1 or "Traceback" in problem.message:
                raise AssertionError(f"a poor message: {problem!r}") from None
        return "refused", None
    except Text2SimError:
        return "refused", None
    return "warned" if report.problems else "fine", case


def go_round(draft: Draft, case: Any) -> None:
    """Take the ways that lead back to where they began."""
    from text2sim.compiler.build import resolve_case
    from text2sim.compiler.explicit import explicit
    from text2sim.spec_schema.changes.amendment import identical
    from text2sim.spec_schema.changes.edit import edit_source
    from text2sim.spec_schema.changes.patch import PatchError, apply_operations, inverse
    from text2sim.spec_schema.errors import SpecError
    from text2sim.spec_schema.load import load_text
    from text2sim.spec_schema.text.canonical import dump_case, format_source
    from text2sim.spec_schema.text.document import parse_document
    from text2sim.spec_schema.text.source import decode_source

    try:
        source = decode_source(draft.text)
        data = parse_document(source).data
    except SpecError:
        return
    text = format_source(source)
    formatted = decode_source(text.encode())
    assert identical(parse_document(formatted).data, data), "fmt changes the data"
    assert format_source(formatted) == text, "fmt twice is not fmt once"
    if isinstance(data, dict):
        assert identical(parse_document(decode_source(dump_case(data).encode())).data, data), (
            "a dump says something else"
        )
    if draft.operations:
        with contextlib.suppress(PatchError, SpecError):
            patched, back = apply_operations(data, draft.operations), inverse(data, draft.operations)
            assert identical(apply_operations(patched, back), data), "the inverse of a patch does not lead back"
            edited = edit_source(source, draft.operations)
            assert identical(parse_document(decode_source(edited.encode())).data, patched), (
                "the edited text says something else"
            )
    if case is not None and sum(map(len, case.placed.values())) < MANY:
        again = resolve_case(load_text(explicit(case).text(), case.loaded.path))
        assert again.plan.sim_digest == case.plan.sim_digest, "what `show` says is another simulation"
        assert again.plan.render_digest == case.plan.render_digest, "what `show` says is another film"


FILES = ("model.urdf", "genesis:urdf/panda_bullet/panda.urdf")
WARM = """\
text2sim: 2
name: warm
scene: {{duration: 1, statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies:
  arm: {{kind: articulated, file: "{file}", base: fixed}}
  cup: {{use: cup, place: {{on: floor, at: [2, 0]}}}}
  lump: {{kind: rigid, shape: {{kind: mesh, file: mesh.obj}}, place: {{beside: cup}}}}
"""


def _write(folder: Path, draft: Draft, cases: Path) -> None:
    """Make the case's folder, with nothing else in it."""
    if folder.exists():
        shutil.rmtree(folder)
    folder.mkdir()
    for asset in ("assets", "prefabs"):
        for home in (cases, SOFT):
            if (home / draft.case / asset).is_dir():
                shutil.copytree(home / draft.case / asset, folder / asset)
    for name, content in draft.files.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        if isinstance(content, bytes):
            path.write_bytes(content)
        else:
            path.symlink_to(content)
    (folder / "case.yaml").write_bytes(draft.text)


def _processor_seconds() -> float:
    """Of this process and of those that it ran: another one may keep the machine busy."""
    mine, theirs = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return mine.ru_utime + mine.ru_stime + theirs.ru_utime + theirs.ru_stime


def _peak_gigabytes() -> float:
    """Most memory that this process has had [GB]."""
    status = Path("/proc/self/status")
    if status.is_file():
        # What getrusage says counts what the parent had when it forked.
        return int(re.search(r"VmHWM:\s*(\d+) kB", status.read_text())[1]) / 1e6
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def trial(cases: Path, count: int, seed: int) -> dict[str, Any]:
    """Examine `count` documents; return what was seen and everything that was wrong."""
    documents = mutations(cases, count, seed)
    watch, seen, wrong, slowest = Watch(), {}, [], 0.0
    signal.signal(signal.SIGALRM, _too_slow)
    with tempfile.TemporaryDirectory(prefix="fuzz-") as scratch:
        cache = os.environ["XDG_CACHE_HOME"] = os.path.realpath(os.path.join(scratch, "cache"))
        watch.own = (cache, os.path.join(tempfile.gettempdir(), "text2sim-"))
        folder = Path(scratch) / "case"
        warm = [Draft(path.parent.name, path.read_bytes()) for path in originals_of(cases)]
        # Everything is imported before the clock runs.
        warm += [
            Draft("", WARM.format(file=file).encode(), files={"model.urdf": URDF[1], "mesh.obj": OBJ[0]})
            for file in FILES
        ]
        for draft in warm:
            _write(folder, draft, cases)
            go_round(draft, examine(folder, draft)[1])
        for number, draft in enumerate(documents):
            _write(folder, draft, cases)
            watch.folder, watch.notes, watch.armed = os.path.realpath(folder), [], True
            start, took, complaint, kind = _processor_seconds(), None, "", ""
            signal.setitimer(signal.ITIMER_REAL, WAIT)
            try:
                kind, case = examine(folder, draft)
                took = _processor_seconds() - start
                go_round(draft, case)
            except SlowError:
                kind, complaint = "slow", f"it took longer than {WAIT:g} s on the clock"
            except Exception:
                kind, complaint = kind or "exception", traceback.format_exc(limit=-6)
            signal.setitimer(signal.ITIMER_REAL, 0)
            watch.armed = False
            took = _processor_seconds() - start if took is None else took
            slowest = max(slowest, took)
            seen[kind] = seen.get(kind, 0) + 1
            if took > SECONDS and not complaint:
                complaint = f"it took {took:.1f} s"
            if complaint or watch.notes:
                wrong.append({"number": number, "case": draft.case, "why": complaint, "notes": watch.notes[:5],
                              "overlay": repr(draft.overlay), "operations": repr(draft.operations),
                              "files": {name: repr(content)[:2000] for name, content in draft.files.items()},
                              "text": draft.text.decode("utf-8", "replace")})  # fmt: skip
    peak = _peak_gigabytes()
    if peak > GIGABYTES:
        wrong.append({"number": -1, "case": "", "why": f"memory rose to {peak:.2f} GB", "notes": [], "text": ""})
    return {"count": count, "seen": seen, "slowest": round(slowest, 2), "peak_gb": round(peak, 2), "wrong": wrong}


def main() -> None:
    """Run a trial, print what came of it, exit with 1 if anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cases", type=Path, default=ROOT / "cases")
    parser.add_argument("--keep", type=Path, help="folder for the documents that were read wrongly")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    found = trial(options.cases, options.count, options.seed)
    if options.json:
        print(json.dumps(found))
    else:
        print({key: value for key, value in found.items() if key != "wrong"})
        for row in found["wrong"][:20]:
            print(f"--- document {row['number']} (from {row['case']}): {row['why']}\n{row['notes']}")
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
        for row in found["wrong"]:
            folder = options.keep / f"{options.seed}-{row['number']}"
            folder.mkdir(exist_ok=True)
            (folder / "case.yaml").write_text(row.pop("text"))
            (folder / "why.json").write_text(json.dumps(row, indent=1))
    sys.exit(bool(found["wrong"]))


if __name__ == "__main__":
    main()
