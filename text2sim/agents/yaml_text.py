"""Data as YAML for a prompt: short and deterministic."""

from collections.abc import Mapping
from typing import Any

from text2sim.spec_schema.text.writing import flow_text, key, scalar

WIDTH = 110


def yaml_text(data: Mapping[str, Any], indent: int = 0) -> str:
    """Return a mapping as YAML; a value goes on one line if it fits."""
    pad = " " * indent
    rows = []
    for name, value in data.items():
        flow = flow_text(value) if isinstance(value, dict | list | tuple) else scalar(value, flow=False)
        head = f"{pad}{key(str(name))}:"
        if len(head) + len(flow) < WIDTH or not isinstance(value, dict | list) or not value:
            rows.append(f"{head} {flow}")
        elif isinstance(value, dict):
            rows += [head, yaml_text(value, indent + 2)]
        else:
            rows += [head, *(f"{pad}  - {flow_text(item)}" for item in value)]
    return "\n".join(rows)
