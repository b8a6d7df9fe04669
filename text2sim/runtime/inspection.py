"""Inspection of this machine: what it has, what it lacks, and how to fix that.

Genesis, torch and others are tried in child processes.
"""

import json
import os
import platform
import shutil
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from text2sim.runtime import kernel_cache
from text2sim.runtime.machine import (
    IPC_INSTALL,
    SYSTEM_LIBRARIES,
    SystemLibrary,
    device_kind,
    ipc_obstacle,
    missing_libraries,
    nvidia_names,
    version_of,
)

SUPPORTED_PYTHON = ((3, 11), (3, 13))
API_KEYS = (
    "ANTHROPIC_API_KEY",
    "AZURE_API_KEY",
    "DEEPSEEK_API_KEY",
    "GEMINI_API_KEY",
    "GROQ_API_KEY",
    "MISTRAL_API_KEY",
    "OPENAI_API_KEY",
    "OPENROUTER_API_KEY",
    "XAI_API_KEY",
)
MIN_MEMORY = 4 * 2**30
"""Recommended memory [bytes]: a small rigid scene takes 1 GB, compiling its kernels up to 3 GB."""

_REINSTALL = "scripts/bootstrap (or: pip install -c constraints.txt .)"
_RENDER_INSTALL = "pip install -c constraints.txt '.[render]'"
_DRIVERS = "sudo apt-get install -y libegl-mesa0 libgl1-mesa-dri; NVIDIA containers: NVIDIA_DRIVER_CAPABILITIES=all"
_CHILD_LIMIT = 120.0
"""Wall time [s] after which a child is killed; `import genesis` from a cold disk takes half a minute."""


@dataclass(frozen=True)
class MachineFinding:
    """Result of one check."""

    name: str
    ok: bool
    severity: Literal["required", "optional"]
    """Whether a case can be run without it."""
    value: str
    """What was found, or what is wrong."""
    fix: str
    """One line that fixes it; empty if nothing is wrong."""


def inspect_machine() -> list[MachineFinding]:
    """Check everything that a run depends on, in about ten seconds.

    Returns:
        The results in a fixed order, without values of secrets.
    """
    # The first child loads gigabytes of libraries, so it starts first and the others run beside it.
    slow = (_genesis_and_opengl, _path_tracer, _torch, _ipc, _encoder, _formatter)
    with ThreadPoolExecutor(max_workers=2) as pool:
        answers = [pool.submit(look) for look in slow]
        quick = [look() for look in (_python, _processor, _memory, _libraries)]
        genesis, *rest = (answer.result() for answer in answers)
    return [
        *quick,
        *genesis,
        *(finding for findings in rest for finding in findings),
        _kernel_cache(),
        _api_keys(),
    ]


def ask_child(code: str, *, timeout: float = _CHILD_LIMIT) -> tuple[dict[str, Any], str]:
    """Run Python code in a child process, so that a crash or a hang in it can be reported.

    Args:
        code: Statements that print JSON objects, one per line.
        timeout: Limit on wall time [s].

    Returns:
        All that was printed, merged, and why the child failed (empty if it did not).
    """
    # -P: links in the root of the repository would shadow real packages (`templates`) if it is the working directory.
    try:
        child = subprocess.run(
            [sys.executable, "-P", "-c", code],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=timeout,
            check=False,
        )
        output, failure = child.stdout, _failure(child.returncode, child.stderr + child.stdout)
    except subprocess.TimeoutExpired as late:
        output = late.stdout.decode(errors="replace") if isinstance(late.stdout, bytes) else late.stdout or ""
        failure = f"no answer in {timeout:.0f} s"
    except OSError as error:
        output, failure = "", str(error)
    learned: dict[str, Any] = {}
    for line in output.splitlines():
        if line.startswith("{"):
            learned |= _parse(line)
    return learned, failure


def _python() -> MachineFinding:
    lowest, highest = SUPPORTED_PYTHON
    ok = lowest <= sys.version_info[:2] <= highest
    wanted = f"{lowest[0]}.{lowest[1]}-{highest[0]}.{highest[1]}"
    fix = "" if ok else f"PYTHON=python{highest[0]}.{highest[1]} scripts/bootstrap, with a Python {wanted}"
    return MachineFinding("python", ok, "required", f"{platform.python_version()} at {sys.executable}", fix)


def _processor() -> MachineFinding:
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return MachineFinding("processor", True, "optional", f"{usable} cores, {platform.machine()}", "")


def _memory() -> MachineFinding:
    size = _memory_bytes()
    ok = size is None or size >= MIN_MEMORY
    fix = "" if ok else "give the machine (or its container) 4 GB: compiling physics kernels takes up to 3 GB"
    return MachineFinding("memory", ok, "optional", "unknown" if size is None else f"{size / 2**30:.1f} GiB", fix)


def _libraries() -> MachineFinding:
    if sys.platform != "linux":
        return MachineFinding("system libraries", True, "required", f"{platform.system()} brings its own", "")
    missing = missing_libraries()
    if not missing:
        return MachineFinding("system libraries", True, "required", f"all {len(SYSTEM_LIBRARIES)} found", "")
    value = "missing " + "; ".join(f"{library.soname}: {library.reason}" for library in missing)
    return MachineFinding("system libraries", False, "required", value, _install_line(missing))


# Genesis chooses the OpenGL platform when it is imported, so its own renderer is tried. That comes last: making a
# context crashes where drivers are broken, and the rest is known by then.
_ASK_GENESIS = """
import json
import genesis
print(json.dumps({"version": genesis.__version__}), flush=True)
genesis.init(backend=genesis.cpu, logging_level="error")
from genesis.ext.pyrender.offscreen import OffscreenRenderer
from OpenGL.GL import GL_RENDERER, GL_VERSION, glGetString
renderer = OffscreenRenderer()
renderer.make_current()
print(json.dumps({
    "platform": type(renderer._platform).__name__.removesuffix("Platform"),
    "software": renderer._is_software,
    "renderer": glGetString(GL_RENDERER).decode(),
    "opengl": glGetString(GL_VERSION).decode(),
}), flush=True)
"""


def _genesis_and_opengl() -> list[MachineFinding]:
    learned, failure = ask_child(_ASK_GENESIS)
    lacking = _install_line(missing_libraries())
    if "version" not in learned:
        fix = lacking or _REINSTALL
        return [
            MachineFinding("genesis", False, "required", f"does not import: {failure}", fix),
            MachineFinding("opengl", False, "required", "not known while genesis does not import", fix),
        ]
    genesis = MachineFinding("genesis", True, "required", learned["version"], "")
    if "platform" not in learned:
        return [genesis, MachineFinding("opengl", False, "required", failure, lacking or _DRIVERS)]
    kind = "software: Genesis draws no shadows" if learned["software"] else "hardware"
    value = f"{learned['platform']}, {learned['renderer']}, OpenGL {learned['opengl']} ({kind})"
    return [genesis, MachineFinding("opengl", True, "required", value, "")]


_ASK_TORCH = """
import json
import torch
count = torch.cuda.device_count() if torch.cuda.is_available() else 0
devices = [torch.cuda.get_device_name(i) for i in range(count)]
print(json.dumps({"version": torch.__version__, "cuda": torch.version.cuda, "devices": devices}))
"""


def _torch() -> list[MachineFinding]:
    learned, failure = ask_child(_ASK_TORCH)
    if "version" not in learned:
        torch = MachineFinding("torch", False, "required", f"does not import: {failure}", _REINSTALL)
        return [torch, MachineFinding("cuda", False, "optional", "not known without torch", _REINSTALL)]
    torch = MachineFinding("torch", True, "required", learned["version"], "")
    devices, hardware = learned["devices"], nvidia_names()
    if devices:
        return [torch, MachineFinding("cuda", True, "optional", f"{', '.join(devices)}, CUDA {learned['cuda']}", "")]
    if not hardware:
        cuda = MachineFinding("cuda", False, "optional", "no NVIDIA device: runs use the CPU", "a machine with one")
        return [torch, cuda]
    if learned["cuda"] is None:
        value = "torch is the CPU build"
        fix = f"pip install --force-reinstall torch=={learned['version'].split('+')[0]}"
    else:
        value, fix = f"torch (CUDA {learned['cuda']}) does not see it", "update the NVIDIA driver; see nvidia-smi"
    return [torch, MachineFinding("cuda", False, "optional", f"{', '.join(hardware)}, but {value}", fix)]


# An import says little: libuipc opens the device when it makes its engine.
_ASK_IPC = """
import json, tempfile, uipc
print(json.dumps({"uipc": True}), flush=True)
uipc.Logger.set_level(uipc.Logger.Level.Error)
uipc.core.Engine("cuda", tempfile.mkdtemp())
print(json.dumps({"engine": True}))
"""


def _ipc() -> list[MachineFinding]:
    """Check whether cases with contact model ipc run here; no others need it."""
    need = "only cases with contact model ipc need it"
    if obstacle := ipc_obstacle():
        fix = IPC_INSTALL if device_kind() == "cuda" else "a machine with an NVIDIA device and torch for CUDA"
        return [MachineFinding("ipc", False, "optional", f"{obstacle.split(':')[0]}; {need}", fix)]
    learned, failure = ask_child(_ASK_IPC)
    if "engine" in learned:
        return [MachineFinding("ipc", True, "optional", f"pyuipc {version_of('pyuipc')}", "")]
    fix = "update the NVIDIA driver: pyuipc is built for CUDA 12.8" if learned else IPC_INSTALL
    value = f"pyuipc {version_of('pyuipc')} does not start: {failure}; {need}"
    return [MachineFinding("ipc", False, "optional", value, fix)]


def _encoder() -> list[MachineFinding]:
    code = 'import av, json; av.codec.Codec("libx264", "w"); print(json.dumps({"av": av.__version__}))'
    learned, failure = ask_child(code)
    value = f"libx264 in PyAV {learned['av']}" if learned else f"no libx264: {failure}"
    return [MachineFinding("video encoder", bool(learned), "optional", value, "" if learned else _REINSTALL)]


# The variants of the path tracer are tried in children of this child, since an unsuitable one may abort.
_ASK_RENDERER = """
import json
from text2sim.rendering.renderer import find_variant, is_installed
print(json.dumps({"installed": is_installed()}), flush=True)
variant = find_variant()
print(json.dumps({"variant": variant.name, "library": variant.library, "hint": variant.hint}))
"""
_VARIANTS = {"cuda": "on the NVIDIA device", "llvm": "compiled by LLVM", "scalar": "without LLVM, the slowest"}


def _path_tracer() -> list[MachineFinding]:
    """Check what `text2sim render` traces with; no simulation needs it."""
    name = "path tracer"
    learned, failure = ask_child(_ASK_RENDERER, timeout=3 * _CHILD_LIMIT)
    if "variant" in learned:
        variant, hint = learned["variant"], str(learned.get("hint") or "")
        value = f"mitsuba {version_of('mitsuba')}, {variant}: {_VARIANTS.get(variant, variant)}"
        return [MachineFinding(name, True, "optional", value, hint)]
    if learned.get("installed") is False:
        return [MachineFinding(name, False, "optional", "not installed: no path-traced films", _RENDER_INSTALL)]
    return [MachineFinding(name, False, "optional", f"does not start: {failure}", _RENDER_INSTALL)]


def _formatter() -> list[MachineFinding]:
    code = 'import runpy, sys; sys.argv[1:] = ["--version"]; runpy.run_module("ruff", run_name="__main__")'
    _, failure = ask_child(code)
    value = f"ruff {version_of('ruff')}" if not failure else f"ruff does not run: {failure}"
    return [MachineFinding("formatter", not failure, "required", value, _REINSTALL if failure else "")]


def _kernel_cache() -> MachineFinding:
    name = "kernel cache"
    if os.environ.get("QD_OFFLINE_CACHE") == "0":
        return MachineFinding(name, False, "optional", "switched off: each run compiles anew", "unset QD_OFFLINE_CACHE")
    folder = kernel_cache.cache_folder()
    sizes = [path.stat().st_size for path in folder.rglob("*") if path.is_file()] if folder.is_dir() else []
    if sizes:
        return MachineFinding(name, True, "optional", f"warm, {sum(sizes) / 2**20:.0f} MiB at {folder}", "")
    standing = next(path for path in (folder, *folder.parents) if path.exists())
    if not os.access(standing, os.W_OK):
        fix = "export QD_OFFLINE_CACHE_FILE_PATH=<a folder that can be written>"
        return MachineFinding(name, False, "optional", f"{folder} cannot be written: each run compiles anew", fix)
    value = f"cold: the first run compiles kernels, a minute or two, into {folder}"
    return MachineFinding(name, True, "optional", value, "")


def _api_keys() -> MachineFinding:
    present = [name for name in API_KEYS if os.environ.get(name)]
    if present:
        return MachineFinding("api keys", True, "optional", ", ".join(present), "")
    fix = "export OPENAI_API_KEY=... (or another provider's); only the agents need one"
    return MachineFinding("api keys", False, "optional", "none", fix)


def _memory_bytes() -> int | None:
    try:
        size = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):  # Windows has no sysconf
        return None
    try:  # a container often has less than the machine
        return min(size, int(Path("/sys/fs/cgroup/memory.max").read_text()))
    except (OSError, ValueError):
        return size


def _install_line(libraries: list[SystemLibrary]) -> str:
    if not libraries:
        return ""
    if shutil.which("apt-get"):
        packages = " ".join(library.package for library in libraries)
        return f"sudo apt-get install -y --no-install-recommends {packages}"
    return "install what provides " + " ".join(library.soname for library in libraries)


def _failure(returncode: int, output: str) -> str:
    if returncode == 0:
        return ""
    if returncode < 0:
        return f"crashed ({signal.Signals(-returncode).name})"
    # Genesis logs its errors in colour and below the traceback; the line with the error's class says most.
    lines = [line.strip() for line in output.splitlines() if line.strip() and "\x1b" not in line]
    return lines[-1][:300] if lines else f"exit status {returncode}"


def _parse(line: str) -> dict[str, Any]:
    try:
        value = json.loads(line)
    except ValueError:
        return {}
    return value if isinstance(value, dict) else {}
