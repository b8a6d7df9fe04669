"""Any name that the language allows may be given to a body."""

import ast

from text2sim.compiler.build import plan_case
from text2sim.compiler.emit import emit
from text2sim.spec_schema.load import load_text

CASE = """\
text2sim: 2
name: namesakes
prompt: Two balls lie on a floor.
scene: {duration: 0.1, statics: {statics: {shape: {kind: plane}}}}
bodies:
  bodies: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}
  configure: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [1, 0, 1]}}
"""


def test_a_body_named_like_a_part_of_the_program_does_not_hide_it():
    program = emit(plan_case(load_text(CASE)))
    for module in ("bodies.py", "scene.py"):
        functions = [node.name for node in ast.parse(program[module]).body if isinstance(node, ast.FunctionDef)]
        assert len(functions) == len(set(functions)), functions
    assert "**add__bodies(scene)" in program["bodies.py"].decode()
    assert "**add__statics(scene)" in program["scene.py"].decode()
