"""Output of `text2sim check` about the rules of the lint."""

import sys
from dataclasses import fields
from typing import Any

from text2sim.cli.output import say, say_json
from text2sim.lint.rules import RULES, Rule, find_rule
from text2sim.service import exits
from text2sim.service.descriptions import describe_rule
from text2sim.spec_schema.errors import nearest


def say_rules(as_json: bool) -> int:
    """Print one line for each rule, and return the exit code."""
    if as_json:
        say_json({"rules": [_plain(rule) for rule in RULES]})
        return exits.OK
    wide = max(len(rule.id) for rule in RULES)
    for rule in RULES:
        say(f"{rule.id:{wide}}  {rule.severity:7}  {rule.title}")
    return exits.OK


def say_rule(name: str, as_json: bool) -> int:
    """Print the full description of a rule, and return the exit code."""
    rule = find_rule(name)
    if rule is None:
        hint = nearest(name, [rule.id for rule in RULES])
        end = f"; did you mean `{hint}`?" if hint else "; --rules lists them"
        aside = " (--settings says which settings were derived)" if "/" in name or "." in name else ""
        say(f"there is no rule `{name}`{end}{aside}", to=sys.stderr)
        return exits.INPUT
    if as_json:
        say_json(_plain(rule))
        return exits.OK
    say(describe_rule(rule))
    return exits.OK


def _plain(rule: Rule) -> dict[str, Any]:
    return {field.name: getattr(rule, field.name) for field in fields(rule) if field.name != "run"}
