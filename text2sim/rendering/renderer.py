"""Renderer: Mitsuba in the fastest variant that works on this machine.

An incompatible LLVM aborts the process, so every variant is first tried in a child process; the result is stored in the
user's cache folder. A process uses one variant.
"""

import ctypes
import importlib.metadata
import json
import os
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from text2sim.runtime.machine import version_of
from text2sim.spec_schema.errors import MachineError
from text2sim.spec_schema.whole_files import user_cache

VARIANTS = {"cuda": "cuda_ad_rgb", "llvm": "llvm_ad_rgb", "scalar": "scalar_rgb"}
"""Mitsuba's variants by backend, the fastest first."""
PACKAGED_LLVM = "karellen-llvm-core"
"""Python package of LLVM's shared library, with wheels for Linux on x86-64 only."""
RUNTIME = ("libunwind.so.1", "libc++abi.so.1", "libc++.so.1")
"""Dependencies of the packaged LLVM, in loading order: the linker does not search the folder of the package."""
LLVM = ("/usr/lib/*/libLLVM*.so*", "/usr/lib/llvm*/lib/libLLVM*.so*", "/opt/homebrew/opt/llvm*/lib/libLLVM*.dylib")
OLDEST_LLVM = 16
"""Oldest version that works: the renderer does not find 14, and 15 aborts in its first kernel."""
LIMIT = 120.0
"""Time limit [s] of a child process, which compiles the first kernel on this machine."""
TRIAL = """
import ctypes, sys
for library in sys.argv[2:]:
    ctypes.CDLL(library)
import mitsuba as mi
mi.set_variant(sys.argv[1])
scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere", "center": [0, 0, 9]}, "sky": {"type": "constant"},
    "integrator": {"type": "path"},
    "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 8, "height": 8}}})
import numpy as np
value = float(np.array(mi.render(scene, spp=4)).mean())
sys.exit(0 if 0.1 < value < 10 else 1)
"""


@dataclass(frozen=True)
class Variant:
    """A variant of Mitsuba, and the library that it needs."""

    name: str
    """cuda, llvm or scalar."""
    library: str = ""
    """Path of LLVM's library if the renderer does not find it itself."""

    @property
    def hint(self) -> str:
        """Advice on how to get a faster variant; empty if there is none."""
        if self.name != "scalar":
            return ""
        return (
            "rendering without LLVM, several times slower than it could be: install LLVM 16 or newer "
            "(Linux on x86-64: pip install karellen-llvm-core; Debian, Ubuntu: sudo apt-get install libllvm19; "
            "macOS: brew install llvm)"
        )


def is_installed() -> bool:
    """Return whether the extra `render` is installed."""
    return all(version_of(name) for name in ("mitsuba", "mitsuba-oidn"))


def find_variant() -> Variant:
    """Return the fastest variant that works here; cached between processes.

    Raises:
        MachineError: If the renderer is not installed, or no variant works.
    """
    if not is_installed():
        raise MachineError("the path tracer is not installed here: pip install 'text2sim[render]'")
    libraries = _llvm_libraries()
    key = json.dumps([version_of("mitsuba"), version_of("drjit"), libraries, os.environ.get("DRJIT_LIBLLVM_PATH", "")])
    file = user_cache() / "text2sim" / "renderer.json"
    try:
        known = json.loads(file.read_text("utf-8"))
        if known["key"] == key and known["name"] in VARIANTS:
            return Variant(known["name"], known["library"])
    except (OSError, ValueError, KeyError, TypeError):
        pass
    variant = _try_all(libraries)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps({"key": key, "name": variant.name, "library": variant.library}), "utf-8")
    except OSError:
        pass  # the next process tries again
    return variant


@cache
def mitsuba() -> Any:
    """Return the module `mitsuba` with its variant set; always import it through this function."""
    variant = find_variant()
    if variant.library:
        os.environ["DRJIT_LIBLLVM_PATH"] = variant.library
        for library in _runtime(variant.library):
            ctypes.CDLL(library)
    import mitsuba as mi

    mi.set_variant(VARIANTS[variant.name])
    mi.set_log_level(mi.LogLevel.Error)
    return mi


def _try_all(libraries: list[str]) -> Variant:
    if any(Path(node).exists() for node in ("/dev/nvidiactl", "/dev/dxg")) and _works("cuda", ""):
        return Variant("cuda")
    for library in libraries:
        if _works("llvm", library):
            return Variant("llvm", library)
    if _works("scalar", ""):
        return Variant("scalar")
    raise MachineError(
        "the path tracer does not start on this machine; `pip install --force-reinstall mitsuba` may help"
    )


def _works(name: str, library: str) -> bool:
    environment = os.environ | ({"DRJIT_LIBLLVM_PATH": library} if library else {})
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", TRIAL, VARIANTS[name], *_runtime(library)],
            env=environment,
            capture_output=True,
            timeout=LIMIT,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def _llvm_libraries() -> list[str]:
    """Return the LLVM libraries to try: the user's choice, the Python package's, the system's, newest first."""
    named = os.environ.get("DRJIT_LIBLLVM_PATH")
    found = {Path(path).resolve() for pattern in LLVM for path in Path("/").glob(pattern[1:])}
    suited = sorted((path for path in found if _llvm_version(path) >= OLDEST_LLVM), key=_llvm_version, reverse=True)
    return [*([named] if named else []), *_packaged_llvm(), *map(str, suited)]


def _packaged_llvm() -> list[str]:
    """Return the library of the Python package, or nothing."""
    try:
        files = importlib.metadata.files(PACKAGED_LLVM) or []
    except importlib.metadata.PackageNotFoundError:
        return []
    # A name without version is a link to the same file.
    found = sorted(Path(str(file.locate())).resolve() for file in files if file.name.startswith("libLLVM.so."))
    return [str(path) for path in found if path.is_file()]


def _runtime(library: str) -> list[str]:
    """Return the libraries that must be loaded before an LLVM library; a system's LLVM finds its own."""
    return (
        [str(path) for name in RUNTIME for path in Path(library).parent.glob(f"*-linux-gnu/{name}") if path.is_file()]
        if library
        else []
    )


def _llvm_version(path: Path) -> int:
    digits = "".join(c if c.isdigit() else " " for c in path.name).split()
    return int(digits[0]) if digits else 0
