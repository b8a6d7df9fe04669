"""From a traceback of a program back to the line of the case."""

from pathlib import Path

import pytest

from text2sim.compiler.provenance import provenance

BODIES = '''\
"""Bodies."""

# case.yaml:3
LIMITS = [1.0]


def add_ball(scene):
    """Add it."""
    return {
        # case.yaml:12
        "ball": scene.add_entity(
            Box(
                size=-1,
            ),
        )
    }


# case.yaml:20
def add_box(scene):
    return scene.add_entity(Box())


def add_bodies(scene):
    add_ball(scene)


DRIVES = [
    ("ball", 1.0),  # case.yaml:31 push
]
'''


@pytest.fixture
def program(tmp_path: Path) -> Path:
    folder = tmp_path / "program"
    folder.mkdir()
    (folder / "bodies.py").write_text(BODIES)
    (folder / "main.py").write_text("# case.yaml:99\nimport bodies\n")
    return folder


def traceback(program: Path, *frames: tuple[str, int], engine: bool = True) -> str:
    rows = [f'  File "{program / name}", line {line}, in f\n    code()' for name, line in frames]
    rows += ['  File "/lib/genesis/entity.py", line 5, in add_entity\n    raise'] * engine
    return "\n".join(["Traceback (most recent call last):", *rows, "GenesisException: no"])


@pytest.mark.parametrize(
    ("frames", "line"),
    [
        ([("main.py", 2), ("bodies.py", 25), ("bodies.py", 11)], 12),
        ([("main.py", 2), ("bodies.py", 25), ("bodies.py", 12)], 12),
        ([("main.py", 2), ("bodies.py", 21)], 20),
        ([("main.py", 2), ("bodies.py", 4)], 3),
        ([("main.py", 2), ("bodies.py", 29)], 31),
    ],
)
def test_a_frame_leads_to_the_comment_above_it(program: Path, frames: list[tuple[str, int]], line: int):
    found = provenance(program, traceback(program, *frames))
    assert found is not None
    assert found[0] == line


def test_the_code_is_shown_too(program: Path):
    found = provenance(program, traceback(program, ("bodies.py", 11)))
    assert found == (12, '"ball": scene.add_entity(')


def test_a_function_without_a_mark_blames_no_other(program: Path):
    assert provenance(program, traceback(program, ("main.py", 2), ("bodies.py", 25))) is None


def test_only_modules_of_the_program_are_looked_at(program: Path, tmp_path: Path):
    (tmp_path / "bodies.py").write_text("# case.yaml:1\nx\n")
    text = f'Traceback (most recent call last):\n  File "{tmp_path / "bodies.py"}", line 2, in f\nError'
    assert provenance(program, text) is None


def test_a_crash_of_native_code_is_read_from_its_other_end(program: Path):
    rows = [("bodies.py", 11), ("bodies.py", 21), ("main.py", 2)]
    frames = "\n".join(f'  File "{program / name}", line {line} in f' for name, line in rows)
    text = f"Fatal Python error: Segmentation fault\n\nCurrent thread 0x01 (most recent call first):\n{frames}"
    found = provenance(program, text)
    assert found is not None
    assert found[0] == 12


@pytest.mark.parametrize("text", ["", "no traceback", 'File "", line 99999999999999999999, in f', "\0" * 10])
def test_other_text_leads_nowhere(program: Path, text: str):
    assert provenance(program, text) is None
