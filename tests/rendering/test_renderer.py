"""Which variant of the renderer is taken."""

import platform
import sys
from pathlib import Path

import pytest

from text2sim.rendering import renderer
from text2sim.rendering.renderer import Variant, find_variant
from text2sim.spec_schema.errors import MachineError


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[tuple[str, str]]:
    """A machine with two LLVMs; only what is asked of its children is kept."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(renderer, "_llvm_libraries", lambda: ["/lib/new", "/lib/old"])
    asked: list[tuple[str, str]] = []

    def works(name: str, library: str) -> bool:
        asked.append((name, library))
        return (name, library) in {("llvm", "/lib/old"), ("scalar", "")}

    monkeypatch.setattr(renderer, "_works", works)
    return asked


def test_the_first_that_works_is_taken_and_remembered(tried: list[tuple[str, str]]) -> None:
    assert find_variant() == Variant("llvm", "/lib/old")
    assert find_variant() == Variant("llvm", "/lib/old")
    assert [ask for ask in tried if ask[0] == "llvm"] == [("llvm", "/lib/new"), ("llvm", "/lib/old")]


def test_without_llvm_it_says_how_to_be_faster(monkeypatch: pytest.MonkeyPatch, tried: list[tuple[str, str]]) -> None:
    monkeypatch.setattr(renderer, "_llvm_libraries", list)
    variant = find_variant()
    assert variant.name == "scalar"
    assert "libllvm19" in variant.hint


def test_a_child_that_dies_is_no_variant(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(renderer, "TRIAL", "import os; os.abort()")
    assert not renderer._works("scalar", "")


def test_without_the_extra_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(renderer, "is_installed", lambda: False)
    with pytest.raises(MachineError, match=r"text2sim\[render\]"):
        find_variant()


@pytest.mark.skipif(
    (sys.platform, platform.machine()) != ("linux", "x86_64"), reason="no wheel of LLVM for this machine"
)
def test_llvm_of_the_environment_comes_before_that_of_the_system(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "libLLVM.so.99").touch()
    monkeypatch.setattr(renderer, "LLVM", (f"{tmp_path}/libLLVM*.so*",))
    monkeypatch.delenv("DRJIT_LIBLLVM_PATH", raising=False)
    packaged, systems = renderer._llvm_libraries()
    assert systems == str(tmp_path / "libLLVM.so.99")
    assert [Path(library).name for library in renderer._runtime(packaged)] == list(renderer.RUNTIME)
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", "/lib/chosen")
    assert renderer._llvm_libraries() == ["/lib/chosen", packaged, systems]


@pytest.mark.usefixtures("tracer")
@pytest.mark.skipif(
    (sys.platform, platform.machine()) != ("linux", "x86_64"), reason="no wheel of LLVM for this machine"
)
def test_llvm_of_the_environment_renders() -> None:
    (packaged,) = renderer._packaged_llvm()
    assert renderer._works("llvm", packaged)
