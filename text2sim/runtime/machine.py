"""This machine: its device, its system libraries, and the versions of installed packages.

`scripts/bootstrap` runs this file with a bare Python, before anything is installed: only the standard library
may be imported here, and nothing else of ours.
"""

import ctypes
import glob
import importlib.metadata
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
from dataclasses import dataclass
from typing import Literal

DISTRIBUTIONS = (
    "text2sim",
    "genesis-world",
    "quadrants",
    "torch",
    "numpy",
    "mujoco",
    "trimesh",
    "av",
    "pyuipc",
)
"""Packages whose versions can change the results of a run."""
IPC_INSTALL = "pip install -c constraints.txt '.[ipc]'"


@dataclass(frozen=True)
class SystemLibrary:
    """A shared library that no Python package contains."""

    soname: str
    package: str
    """Name of its package in Debian and Ubuntu."""
    reason: str
    essential: bool = False
    """Whether nothing runs without it, not even a simulation without a film."""


SYSTEM_LIBRARIES = (
    SystemLibrary("libGL.so.1", "libgl1", "genesis does not import without it (pygel3d links against it)", True),
    SystemLibrary("libXrender.so.1", "libxrender1", "genesis does not import without it (pyglet looks it up)", True),
    SystemLibrary("libEGL.so.1", "libegl1", "genesis makes an offscreen OpenGL context for every scene"),
    SystemLibrary("libOpenGL.so.0", "libopengl0", "pymeshlab cannot remesh for soft bodies without it"),
    SystemLibrary("libgomp.so.1", "libgomp1", "the sampler that fills meshes with particles needs it"),
    SystemLibrary("libglib-2.0.so.0", "libglib2.0-0", "OpenCV does not import without it"),
    SystemLibrary("libatomic.so.1", "libatomic1", "the path tracer does not import without it"),
)
"""Libraries that a minimal Debian lacks, each found by running without it. libgl1 and libegl1 bring Mesa."""


def missing_libraries() -> list[SystemLibrary]:
    """Return the libraries that the dynamic linker does not find; only Linux lacks any."""
    return [library for library in SYSTEM_LIBRARIES if sys.platform == "linux" and not _loads(library.soname)]


def device_kind() -> Literal["cpu", "cuda"]:
    """Return what Genesis can compute on here, without importing torch.

    Returns:
        "cuda" if this process may see an NVIDIA device and torch is not the CPU build, else "cpu".
    """
    if os.environ.get("CUDA_VISIBLE_DEVICES", "0") in ("", "-1"):
        return "cpu"
    if version_of("torch").endswith("+cpu"):
        return "cpu"
    # The device files answer at once. Where there are none (WSL, Windows), the driver's own tool does.
    return "cuda" if glob.glob("/dev/nvidia[0-9]*") or nvidia_names() else "cpu"


def crowding() -> float:
    """Return how many processes want each core, on average over the last five minutes; 1 at least.

    By this factor a computation takes longer than on an idle machine.
    """
    try:
        return max(1.0, os.getloadavg()[1] / (os.cpu_count() or 1))
    except (AttributeError, OSError):  # Windows has none
        return 1.0


def ipc_obstacle() -> str:
    """Return why contact model ipc cannot run here, without importing what it needs; empty if it can."""
    if device_kind() != "cuda":
        return "there is no CUDA device here that torch could use"
    if importlib.util.find_spec("uipc") is None:
        return f"the package pyuipc is not installed here: {IPC_INSTALL}"
    return ""


def versions() -> dict[str, str]:
    """Return the versions of Python and of installed packages that can change the results of a run."""
    found = {name: version_of(name) for name in DISTRIBUTIONS}
    return {"python": platform.python_version(), **{name: version for name, version in found.items() if version}}


def _loads(soname: str) -> bool:
    try:
        ctypes.CDLL(soname)
    except OSError:
        return False
    return True


def nvidia_names() -> list[str]:
    """Return the names of the NVIDIA devices that the driver's tool lists."""
    tool = shutil.which("nvidia-smi")
    if not tool:
        return []
    query = [tool, "--query-gpu=name", "--format=csv,noheader"]
    try:
        answer = subprocess.run(query, capture_output=True, text=True, timeout=20, check=True).stdout
    except (OSError, subprocess.SubprocessError):
        return []
    return [line.strip() for line in answer.splitlines() if line.strip()]


def version_of(distribution: str) -> str:
    """Return the version of an installed package; empty if it is not installed."""
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return ""
