"""Reads hostile documents in a process of its own and watches what that process does.

    python tests/fuzz/trial.py --count 10000 --seed 1

Each is loaded, checked, worked out and linted, as `text2sim check` does. Wrong is: an exception that is not
for the user, a document that takes longer than `SECONDS`, memory beyond `GIGABYTES`, a file opened outside the
case's folder and the installation, a process, a socket, or code that is compiled from a document.
"""

import argparse
import json
import os
import resource
import signal
import sys
import sysconfig
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a checkout that nobody installed

from mutate import mutations  # noqa: E402

SECONDS = 2.0
GIGABYTES = 1.0
ROOT = Path(__file__).resolve().parents[2]

FORBIDDEN = ("subprocess.", "os.system", "os.exec", "os.spawn", "os.posix_spawn", "os.fork", "socket.", "ctypes.dlopen",
             "os.remove", "os.rename", "os.mkdir", "os.rmdir", "shutil.", "os.symlink", "os.link", "os.chmod", "urllib")  # fmt: skip


class Watch:
    """An audit hook that takes notes while it is armed."""

    def __init__(self) -> None:
        self.armed = False
        self.notes: list[str] = []
        self.folder = ""
        sys.addaudithook(self._hook)

    def _hook(self, event: str, args: tuple[Any, ...]) -> None:
        if not self.armed:
            return
        if event == "open" and isinstance(args[0], str | bytes):
            path, mode = os.path.realpath(os.fsdecode(args[0])), args[1]
            inside = path.startswith(self.folder)
            writes = isinstance(mode, str) and any(c in mode for c in "wax+")
            known = path.startswith((sys.prefix, sys.base_prefix, sysconfig.get_path("stdlib"), str(ROOT / "text2sim")))
            system = path.startswith(("/proc/self", "/sys/", "/usr/", "/lib", "/etc/ld.so", "/etc/localtime", "/dev/"))
            if writes or not (inside or known or system):
                self.notes.append(f"opened {path}")
        elif event == "exec" and "case" in repr(args[0])[:80]:
            self.notes.append(f"ran {args[0]!r}")
        elif event.startswith(FORBIDDEN) and not event.startswith("ctypes.dlopen"):
            self.notes.append(f"{event}{args!r:.200}")


class SlowError(BaseException):
    """It took too long."""


def _too_slow(*_: Any) -> None:
    raise SlowError


def examine(folder: Path) -> str:
    """Check one case; return the kind of answer."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case
    from text2sim.spec_schema.errors import SpecError, Text2SimError
    from text2sim.spec_schema.load import load_case

    try:
        report = lint_case(resolve_case(load_case(folder)))
    except SpecError as error:
        for problem in error.problems:
            if not problem.message or "\n" in problem.message or problem.line < 1 or "Traceback" in problem.message:
                raise AssertionError(f"a poor message: {problem!r}") from None
        return "refused"
    except Text2SimError as error:
        return f"refused: {str(error)[:0]}"
    return "warned" if report.problems else "fine"


def trial(cases: Path, count: int, seed: int) -> dict[str, Any]:
    """Examine `count` documents; return what was seen and everything that was wrong."""
    documents = mutations(cases, count, seed)
    watch, seen, wrong, slowest = Watch(), {}, [], 0.0
    signal.signal(signal.SIGALRM, _too_slow)
    with tempfile.TemporaryDirectory() as scratch:
        folders = {}
        for path in sorted(cases.glob("*/case.yaml")):
            folder = Path(scratch) / path.parent.name
            folder.mkdir()
            for asset in ("assets", "prefabs"):
                if (path.parent / asset).is_dir():
                    (folder / asset).symlink_to(path.parent / asset)
            folders[path.parent.name] = folder
            (folder / "case.yaml").write_bytes(path.read_bytes())
            examine(folder)  # everything is imported before the clock runs
        for number, (name, data) in enumerate(documents):
            folder = folders[name]
            (folder / "case.yaml").write_bytes(data)
            watch.folder, watch.notes, watch.armed = os.path.realpath(scratch), [], True
            start = time.perf_counter()
            complaint = ""
            signal.setitimer(signal.ITIMER_REAL, 4 * SECONDS)
            try:
                kind = examine(folder)
            except SlowError:
                kind, complaint = "slow", "it took longer than four times what it may"
            except Exception:
                kind, complaint = "exception", traceback.format_exc(limit=-6)
            signal.setitimer(signal.ITIMER_REAL, 0)
            watch.armed = False
            took = time.perf_counter() - start
            slowest = max(slowest, took)
            seen[kind] = seen.get(kind, 0) + 1
            if took > SECONDS and not complaint:
                complaint = f"it took {took:.1f} s"
            if complaint or watch.notes:
                wrong.append({"number": number, "case": name, "why": complaint, "notes": watch.notes[:5],
                              "text": data.decode("utf-8", "replace")})  # fmt: skip
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
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
            (options.keep / f"{row['number']}.yaml").write_text(row["text"])
    sys.exit(bool(found["wrong"]))


if __name__ == "__main__":
    main()
