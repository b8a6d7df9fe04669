"""Cases that need CUDA stop before the engine starts, and say which of their variants does not."""

import json
from pathlib import Path

import pytest

from text2sim.harness.run import run_case
from text2sim.runtime import machine, machine_check
from text2sim.runtime.machine_check import check_ability, needs_cuda
from text2sim.service import exits
from text2sim.spec_schema.errors import MachineError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.reuse.overlay import CaseOverlay

TOWEL = {
    "text2sim": 2,
    "name": "towel",
    "scene": {"duration": 0.5, "statics": {"floor": {"shape": {"kind": "plane"}}}},
    "bodies": {
        "towel": {
            "kind": "cloth",
            "solver": "ipc",
            "shape": {"kind": "sheet", "size": [0.4, 0.3]},
            "pose": {"pos": [0, 0, 0.5]},
        }
    },
}
VARIANTS = {
    "cpu": {"bodies": {"towel": {"solver": "pbd"}}},
    "long": {"scene": {"duration": 2.0}},
    "stiff": {"bodies": {"towel": {"solver": "pbd", "cell": 0.02}}},
}


def towel(variants: dict | None = None, overlay: CaseOverlay | None = None) -> LoadedCase:
    data = TOWEL | ({"variants": variants} if variants else {})
    return load_text(json.dumps(data, indent=1), overlay=overlay or CaseOverlay())


@pytest.fixture
def no_cuda(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_check, "ipc_obstacle", lambda: "there is no CUDA device here")


@pytest.mark.usefixtures("no_cuda")
def test_the_variants_that_run_here_are_named() -> None:
    with pytest.raises(MachineError) as caught:
        check_ability(towel(VARIANTS))
    message = str(caught.value)
    assert "there is no CUDA device here" in message
    assert "`--variant cpu`" in message
    assert "`--variant stiff`" in message
    assert "long" not in message
    check_ability(towel(VARIANTS, CaseOverlay(variants=("cpu",))))


@pytest.mark.usefixtures("no_cuda")
def test_a_case_without_such_a_variant_says_what_would_help() -> None:
    with pytest.raises(MachineError, match="it has no variant that does without"):
        check_ability(towel({"long": VARIANTS["long"]}))


@pytest.mark.usefixtures("no_cuda")
def test_nothing_is_left_behind(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match="contact model ipc"):
        run_case(towel(), runs=tmp_path / "runs")
    assert not (tmp_path / "runs").exists()


def test_with_a_device_it_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_check, "ipc_obstacle", lambda: "")
    check_ability(towel())
    assert needs_cuda(towel())
    assert not needs_cuda(towel(VARIANTS, CaseOverlay(variants=("cpu",))))


@pytest.mark.parametrize(
    ("kind", "spec", "says"),
    [("cpu", None, "no CUDA device"), ("cuda", None, "pyuipc is not installed"), ("cuda", object(), "")],
)
def test_what_stands_in_the_way(monkeypatch: pytest.MonkeyPatch, kind: str, spec: object, says: str) -> None:
    monkeypatch.setattr(machine, "device_kind", lambda: kind)
    monkeypatch.setattr(machine.importlib.util, "find_spec", lambda name: spec)
    obstacle = machine.ipc_obstacle()
    assert says in obstacle
    assert bool(obstacle) == bool(says)


def test_the_command_ends_with_the_exit_code_of_the_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from text2sim.cli.main import run

    monkeypatch.setattr(machine_check, "ipc_obstacle", lambda: "there is no CUDA device here")
    path = tmp_path / "case.yaml"
    path.write_text(json.dumps(TOWEL | {"variants": VARIANTS}))
    monkeypatch.setattr("sys.argv", ["text2sim", "run", str(path), "--runs", str(tmp_path / "runs")])
    with pytest.raises(SystemExit) as caught:
        run()
    assert caught.value.code == exits.MACHINE
    assert "--variant cpu" in capsys.readouterr().err
