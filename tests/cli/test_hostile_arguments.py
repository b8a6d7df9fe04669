"""What strangers write behind commands: an exit code that says whose fault it is, and words that any terminal bears."""

import os
import re
from pathlib import Path

import pytest
from handmade import Cli, subcommands

from text2sim.cli.main import COMMANDS
from text2sim.service import exits

CALLS = (
    "check X",
    "show X",
    "compare X X",
    "run X --runs file",
    "run cases/fall --runs X --variant X",
    "run cases/fall --runs file --set X",
    "run cases/fall --runs file --set bodies.ball.shape.radius=X",
    "run cases/fall --runs file --grid X",
    "run cases/fall --runs file --sweep X",
    "test X --runs file",
    "test cases/fall --runs file --set bodies.X=1",
    "cards list X",
    "cards show X",
    "cards find brick --role X",
    "cards find brick --mode X",
    "cards ledger nowhere/X",
    "cards ledger folder --runs nowhere/X",
    "--X",
    "check --X",
    "cards verify X",
    "cards distill X --model X",
    "cards distill --suite X --model mailbox:x --out X",
    "evaluate check X",
    "evaluate draft X --model X --out d.yaml",
    "evaluate run X --method X --out e",
    "evaluate judge demonstrations X --out e",
    "evaluate report demonstrations X",
    "study build X folder --anchor folder --suite demonstrations",
    "study build s X folder --anchor X --suite X",
    "study serve X",
    "study analyse X",
    "dataset build X -o d",
    "dataset build list.yaml -o X",
    "dataset check X",
    "dataset questions X",
    "dataset review X",
    "benchmark export X --runs file --out file",
    "benchmark export cases/fall --runs file --out file --set X",
    "benchmark run X",
    "X",
)
APART = frozenset(
    "new render replay export generate repair edit watch compile fmt diff patch migrate git prefabs asset schema doctor "
    "mcp".split()
)
"""Commands that write beside what they read, so that it must not be a file of this machine, that do not end, or that
read nothing."""
WORDS = (
    "a\0b",
    "\x1b[2J\x1b]0;x\a",
    "\r\nfake: ok",
    "\x9b31m",
    "\ud800",
    os.fsdecode(b"\xff\xfe"),
    "\u202efdp",
    "a" * 100_000,
    "../" * 300 + "etc/passwd",
    "folder",
    "file",
    "list.yaml",
    "/dev/zero",
    "/proc/self/mem",
    "pipe.yaml",
    "loop",
    "esc\x1b[31m.yaml",
    "[" * 3000,
    "${9**9**9}",
    "1e-320",
)
RAW = re.compile("[\0-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\u202a-\u202e\u2066-\u2069]")


def test_every_command_is_called_or_set_apart() -> None:
    called = {" ".join(call.split()[:2]) for call in CALLS}
    named = {call.split()[0] for call in called} - {"X", "--X"} | APART
    assert named ^ set(COMMANDS) == set(), "each command belongs into CALLS or APART"
    missing = {words for words in subcommands() if words.split()[0] not in APART} - called
    assert missing == set(), "each subcommand belongs into CALLS"


@pytest.mark.parametrize("words", CALLS)
def test_no_argument_is_a_bug_of_ours_or_moves_the_cursor(
    cli: Cli, case: Path, monkeypatch: pytest.MonkeyPatch, words: str
) -> None:
    monkeypatch.delenv("TEXT2SIM_MODEL", raising=False)
    Path("folder").mkdir()
    Path("file").write_text("x")
    Path("list.yaml").write_text("- 1\n")
    Path("esc\x1b[31m.yaml").write_bytes(b"\x1b[31m: 1\n")
    Path("loop").symlink_to("loop")
    os.mkfifo("pipe.yaml")
    for word in WORDS:
        answer = cli(*(part.replace("X", word) for part in words.split()))
        said = answer.out + answer.err
        assert answer.code in (exits.INPUT, exits.MACHINE), (word[:40], answer.code, said[:400])
        assert said.strip()
        assert "Traceback" not in said, (word[:40], said[:400])
        assert not RAW.search(said), (word[:40], RAW.search(said))
