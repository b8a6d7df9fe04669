"""The page `docs/lint.md`: made from the rules.

Write it with `python -m text2sim.lint.reference > docs/lint.md`.
"""

from text2sim.lint.rules import EARLIER, EXAMPLE_BASE, RULES, Rule

_INTRODUCTION = """\
<!-- Made by `python -m text2sim.lint.reference`: change the rules in text2sim/lint, not this page. -->
# The physics lint

`text2sim check CASE` finds what would go wrong in a simulation before it runs, without the engine. A finding stands at
the line of the case that is to blame, and says the way out:

```
case.yaml:7:3: warning: … [overlap]
```

`text2sim check --rules` lists the rules; `text2sim check --explain overlap` says of one what this page says of it. An
`error` keeps a case from running, a `warning` does not. Where a rule is wrong about a case, because what it warns of is
what the case is about, the case says so, with the reason:

```yaml
waive:
  overlap: the ball starts inside the net, which opens at once
```

What is waived is counted by `check` and listed by `check --json`. A waiver that finds nothing to waive is reported as
`unused-waiver`. The warnings @EARLIER@ of earlier stages can be waived in the same way.

Examples show parts of a case; what they leave out is

```yaml
@BASE@```

"""


def lint_reference() -> str:
    """Return the text of the page."""
    intro = _INTRODUCTION.replace("@BASE@", EXAMPLE_BASE)
    intro = intro.replace("@EARLIER@", ", ".join(f"`{name}`" for name in EARLIER))
    rows = [f"| [`{rule.id}`](#{rule.id}) | {rule.severity} | {rule.title} |" for rule in RULES]
    table = ["| rule | | finds |", "|---|---|---|", *rows, ""]
    return intro + "\n".join(table) + "\n" + "\n".join(_section(rule) for rule in RULES)


def _section(rule: Rule) -> str:
    lines = [
        f"## {rule.id}",
        "",
        f"{rule.title} ({rule.severity})",
        "",
        rule.reason,
        "",
        f"**Remedy.** {rule.remedy}",
    ]
    lines += ["", "```yaml", rule.example.rstrip("\n"), "```", ""]
    if rule.fix:
        lines += [
            "Laid over it, this mends it (`null` takes a key away):",
            "",
            "```yaml",
            rule.fix.rstrip("\n"),
            "```",
            "",
        ]
    return "\n".join(lines)


if __name__ == "__main__":
    print(lint_reference(), end="")
