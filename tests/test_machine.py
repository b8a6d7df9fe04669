"""What `text2sim doctor` learns of this machine, and that learning it is safe and cheap."""

import subprocess
import sys
from pathlib import Path

import pytest

from text2sim.runtime import machine
from text2sim.runtime.inspection import ask_child, inspect_machine
from text2sim.runtime.machine import device_kind, missing_libraries, versions

ROOT = Path(__file__).resolve().parents[1]


def test_child_merges_what_it_is_told() -> None:
    learned, failure = ask_child('print("noise"); print(\'{"a": 1}\'); print(\'{"b": [2]}\')')
    assert learned == {"a": 1, "b": [2]}
    assert failure == ""


def test_crash_of_a_child_is_an_answer() -> None:
    learned, failure = ask_child("import os; print('{\"a\": 1}', flush=True); os.abort()")
    assert learned == {"a": 1}
    assert failure == "crashed (SIGABRT)"


def test_hang_of_a_child_is_an_answer() -> None:
    learned, failure = ask_child("import time; print('{\"a\": 1}', flush=True); time.sleep(60)", timeout=1)
    assert learned == {"a": 1}
    assert failure == "no answer in 1 s"


def test_exception_in_a_child_is_named() -> None:
    _, failure = ask_child("import no_such_module")
    assert failure == "ModuleNotFoundError: No module named 'no_such_module'"


@pytest.mark.parametrize("hidden", ["", "-1"])
def test_hidden_devices_do_not_count(hidden: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", hidden)
    assert device_kind() == "cpu"


def test_cpu_build_of_torch_computes_on_the_cpu() -> None:
    if versions()["torch"].endswith("+cpu"):
        assert device_kind() == "cpu"


def test_versions_are_of_this_process() -> None:
    found = versions()
    assert found["python"].startswith(f"{sys.version_info.major}.{sys.version_info.minor}.")
    assert found["genesis-world"] == "1.4.5"
    assert {"torch", "numpy", "quadrants"} <= set(found)
    assert all(found.values())


def test_no_engine_is_imported_to_answer_cheap_questions() -> None:
    code = (
        "import sys; from text2sim.runtime.machine import device_kind, missing_libraries, versions\n"
        "device_kind(), missing_libraries(), versions()\n"
        "sys.exit(bool({'genesis', 'torch', 'numpy', 'quadrants'} & set(sys.modules)))"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_bootstrap_can_run_the_file_before_anything_is_installed() -> None:
    # -S: no site-packages, as on a bare machine; -E -P: nothing of this checkout either
    code = f"import runpy; print(runpy.run_path({str(Path(machine.__file__))!r})['missing_libraries']())"
    command = [sys.executable, "-S", "-E", "-P", "-c", code]
    output = subprocess.run(command, check=True, timeout=60, capture_output=True, text=True, cwd="/").stdout
    assert len(missing_libraries()) == output.count("SystemLibrary(")


def test_a_library_that_is_not_there_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    made_up = machine.SystemLibrary("libtext2sim-none.so.7", "libtext2sim-none7", "it is made up")
    monkeypatch.setattr(machine, "SYSTEM_LIBRARIES", (made_up,))
    monkeypatch.setattr(machine.sys, "platform", "linux")
    assert missing_libraries() == [made_up]


@pytest.mark.usefixtures("engine", "tracer")
def test_inspection_is_complete_and_keeps_secrets(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", "sk-do-not-show")
    monkeypatch.setenv("QD_OFFLINE_CACHE_FILE_PATH", str(tmp_path / "kernels"))
    findings = {finding.name: finding for finding in inspect_machine()}
    assert list(findings) == [
        *("python", "processor", "memory", "system libraries", "genesis", "opengl", "path tracer", "torch", "cuda"),
        *("ipc", "video encoder", "formatter", "kernel cache", "api keys"),
    ]
    assert not any("sk-do-not-show" in repr(finding) for finding in findings.values())
    assert findings["api keys"].value == "OPENAI_API_KEY"
    assert findings["kernel cache"].value.startswith("cold")
    assert findings["torch"].ok
    assert findings["video encoder"].ok
    for finding in findings.values():
        assert finding.value
        assert bool(finding.fix) != finding.ok, f"{finding.name}: a way to mend it, if and only if it is amiss"
        assert "\n" not in finding.value + finding.fix
