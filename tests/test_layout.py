"""The repository around the package: root links, packaging, the files that set a machine up."""

import os
import re
import shutil
import stat
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
LINKS = ("agents", "card_library", "compiler", "spec_schema", "templates")


def normal(distribution: str) -> str:
    """The name of a distribution as PyPI compares it."""
    return re.sub(r"[-_.]+", "-", re.split(r"[\[<>=;~! ]", distribution)[0]).lower()


@pytest.fixture(scope="module")
def project() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def pins() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    return dict(line.split("==") for line in lines if line and not line.startswith("#"))


@pytest.mark.parametrize("name", LINKS)
def test_root_link_points_into_the_package(name: str) -> None:
    link = ROOT / name
    if link.is_file() and not link.is_symlink():
        # git writes a link as a text file where the file system has none; nothing depends on the links to run
        assert link.read_text(encoding="utf-8") == f"text2sim/{name}"
        return
    assert os.readlink(link) == f"text2sim/{name}", "relative, so that it holds in every clone"
    assert link.resolve() == ROOT / "text2sim" / name
    assert link.is_dir()


@pytest.mark.parametrize("folder", ["text2sim", "tests", "benchmarks"])
def test_no_file_is_longer_than_one_reads_at_once(folder: str) -> None:
    lengths = {path: len(path.read_bytes().splitlines()) for path in (ROOT / folder).rglob("*.py")}
    long = [f"{path.relative_to(ROOT)}: {length} lines" for path, length in lengths.items() if length > 400]
    assert long == [], "split it: contributing.md, Style"


def test_root_links_cannot_be_imported_by_mistake(project: dict) -> None:
    assert set(project["tool"]["ruff"]["lint"]["flake8-tidy-imports"]["banned-api"]) == set(LINKS)
    pytest_options = project["tool"]["pytest"]["ini_options"]
    assert pytest_options["testpaths"] == ["tests"], "pytest must not walk the package through the links"
    assert not set(LINKS) & set(pytest_options["norecursedirs"]), "tests/ has folders of these names"


def test_every_direct_dependency_is_pinned(project: dict, pins: dict[str, str]) -> None:
    extras = project["project"]["optional-dependencies"].values()
    direct = [*project["project"]["dependencies"], *(name for extra in extras for name in extra)]
    assert {normal(name) for name in direct} <= set(pins)


def test_pins_name_versions_and_nothing_of_one_machine(pins: dict[str, str]) -> None:
    assert all(name == normal(name) for name in pins)
    assert all(re.fullmatch(r"[0-9][0-9a-z.]*", version) for version in pins.values())


def test_torch_is_pinned_without_a_local_tag(pins: dict[str, str]) -> None:
    assert pins["torch"] == "2.13.0", "2.13.0+cpu would refuse the CUDA build, and PyPI has no +cpu"


@pytest.mark.parametrize("script", ["scripts/bootstrap", ".ci/run"])
def test_script_is_executable_and_parses(script: str) -> None:
    path = ROOT / script
    assert path.stat().st_mode & stat.S_IXUSR
    shell = "bash" if "bash" in path.read_text(encoding="utf-8").splitlines()[0] else "sh"
    subprocess.run([shell, "-n", path], check=True, timeout=30)


@pytest.fixture
def bare_tools(tmp_path: Path) -> Path:
    """A folder with the few programs that bootstrap needs, and no Python, apt-get or sudo."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for tool in ("sh", "dirname", "cat", "cksum", "sed", "touch", "rm", "id", "uname"):
        found = shutil.which(tool)
        assert found, tool
        (folder / tool).symlink_to(found)
    return folder


def bootstrap(tools: Path, **env: str) -> subprocess.CompletedProcess[str]:
    """Run scripts/bootstrap with no other programs than those in `tools`."""
    return subprocess.run(
        [ROOT / "scripts/bootstrap"],
        env={"PATH": str(tools), "VENV": str(tools.parent / "venv"), **env},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_bootstrap_without_a_python_says_what_to_install(bare_tools: Path) -> None:
    done = bootstrap(bare_tools)
    assert done.returncode == 3
    assert "no Python 3.11, 3.12 or 3.13" in done.stderr
    assert "python3-venv" in done.stderr
    assert not (bare_tools.parent / "venv").exists()


def test_bootstrap_refuses_an_unsupported_python(bare_tools: Path) -> None:
    old = bare_tools / "python3"
    old.write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")  # as `sys.exit(not 3.11 <= version <= 3.13)` would
    old.chmod(0o755)
    done = bootstrap(bare_tools, PYTHON="python3")
    assert done.returncode == 3
    assert "(PYTHON=python3)" in done.stderr


def test_bootstrap_leaves_a_folder_that_is_no_environment_alone(bare_tools: Path) -> None:
    (bare_tools / "python3").symlink_to(Path(sys.base_prefix) / "bin" / "python3")
    folder = bare_tools.parent / "venv"
    folder.mkdir()
    (folder / "thesis.tex").write_text("precious", encoding="utf-8")
    done = bootstrap(bare_tools, NO_SYSTEM="1")
    assert done.returncode == 3
    assert "is not a Python environment" in done.stderr
    assert (folder / "thesis.tex").read_text(encoding="utf-8") == "precious"
