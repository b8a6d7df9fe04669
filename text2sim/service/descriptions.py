"""Descriptions of lint rules and prefabs, for people and agents."""

import textwrap

from text2sim.lint.rules import Rule
from text2sim.spec_schema.reuse.catalogue import param_rows, parts_of, usage
from text2sim.spec_schema.reuse.library import Definition


def describe_rule(rule: Rule) -> str:
    """Return the meaning of a rule, its reason, the remedy, and an example."""
    text = f"{rule.id} ({rule.severity}): {rule.title}\n\n{rule.reason}\n\nRemedy: {rule.remedy}\n\nFor example:\n\n"
    text += f"{_indented(rule.example)}\n\nThis merge patch fixes it (`null` removes a key):\n\n{_indented(rule.fix)}"
    return f"{text}\n\nIf it is intended:\n\n    waive: {{{rule.id}: why it is intended}}"


def describe_prefab(found: Definition) -> str:
    """Return the purpose of a prefab, its bodies and parameters, and an example."""
    lines = [f"{found.name} ({found.place})", "", *textwrap.wrap(" ".join(found.model.doc.split()), 100)]
    if parts := parts_of(found):
        lines += ["", f"Bodies: {', '.join(f'NAME_{part}' for part in parts)}"]
    rows = param_rows(found)
    wide = max((len(row.name) for row in rows), default=0)
    lines += ["", "Parameters:", ""] if rows else []
    for row in rows:
        default = f"; {row.default} if left out" if row.default else ", required"
        lines += [f"  {row.name:{wide}}  {row.doc}", f"  {'':{wide}}  {row.takes}{default}"]
    return "\n".join([*lines, "", "For example:", "", _indented(usage(found))])


def _indented(text: str) -> str:
    return "\n".join(f"    {line}" for line in text.rstrip("\n").split("\n"))
