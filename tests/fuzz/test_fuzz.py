"""Hostile and broken documents: a short trial in the suite, `make fuzz` for a long one."""

import json
import subprocess
import sys
from pathlib import Path

TRIAL = Path(__file__).with_name("trial.py")
COUNT = 120


def test_no_document_gets_through_the_guards(cases):
    done = subprocess.run(
        [sys.executable, TRIAL, "--count", str(COUNT), "--seed", "3", "--cases", cases, "--json"],
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert done.stdout, done.stderr[-3000:]
    found = json.loads(done.stdout)
    assert found["wrong"] == []
    # A trial whose documents are all refused, or all fine, would try little.
    assert sum(found["seen"].values()) == COUNT
    assert found["seen"]["refused"] > COUNT // 4
    assert found["seen"].get("fine", 0) + found["seen"].get("warned", 0) > COUNT // 20
