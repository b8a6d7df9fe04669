"""No control character reaches a terminal, a report or a letter."""

import json
import unicodedata

import pytest

from text2sim.spec_schema.errors import AssetError, MachineError, Problem, RunError, SpecError, format_problems
from text2sim.spec_schema.plain import MARK, escaped, plain, plain_line

NAME = "a\x1b[2K\rfake: ok\n\x9b31m\u202egnp.\x00\ud800"
SAFE = f"a{MARK}[2K{MARK}fake: ok{MARK}{MARK}31m{MARK}gnp.{MARK}{MARK}"


def test_every_control_character_is_marked_and_nothing_else():
    for code in range(0x110000):
        kind = unicodedata.category(chr(code))
        if kind in ("Cc", "Cs", "Zl", "Zp") or (kind == "Cf" and unicodedata.bidirectional(chr(code)) != "AN"):
            known = code in (9, 10) or code < 0x10000 or 0xE0000 <= code <= 0xE007F
            if known and code not in (9, 10) and code != 0x70F:
                assert plain(chr(code)) == MARK, hex(code)
        elif kind not in ("Cf", "Cn", "Co"):
            assert plain(chr(code)) == chr(code), hex(code)
    assert plain("a\tb\nc") == "a\tb\nc"
    assert plain_line("a\tb\nc") == f"a{MARK}b{MARK}c"


def test_problems_and_errors_stay_on_their_line():
    problem = Problem("/bodies/x", f"`{NAME}` is no mesh", file=f"{NAME}.yaml")
    assert problem.message == f"`{SAFE}` is no mesh"
    assert str(problem) == f"{SAFE}.yaml:1:1: error: `{SAFE}` is no mesh [invalid]"
    assert format_problems([problem], f"x: {NAME}").count("\n") == 2
    for error in (AssetError(NAME), RunError(NAME), MachineError(NAME)):
        assert str(error) == SAFE
    assert str(SpecError([problem, Problem("", "b")])).count("\n") == 1


@pytest.mark.parametrize("text", [NAME, "\U000e0041", "é €"])
def test_json_says_the_same_without_control_characters(text: str):
    written = escaped(json.dumps([text], ensure_ascii=False))
    assert json.loads(written) == [text]
    assert plain_line(written) == written
