"""Revision of the text of a case; comments and order are kept."""

import json
import re
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, TypeVar

from text2sim.agents.assembly import FROZEN_PARTS
from text2sim.agents.contract import Contract
from text2sim.agents.replies import Fragments
from text2sim.revision.revise import Revision, apply_owned, revise
from text2sim.spec_schema.changes.diff import difference, operations
from text2sim.spec_schema.changes.diff_words import change_line
from text2sim.spec_schema.changes.edit import edit_source
from text2sim.spec_schema.changes.operation import Operation, split_pointer
from text2sim.spec_schema.changes.patch import PatchError, apply_operations
from text2sim.spec_schema.errors import SpecError, there_are
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.document import parse_document, pointer
from text2sim.spec_schema.text.source import Source, check_source

Data = dict[str, Any]
K = TypeVar("K", bound=Hashable)
T = TypeVar("T")
_EXPRESSION = re.compile(r"\$\{[^}]*\}")
_GRID_PARAM = re.compile(r"^params\.(\w+)", re.ASCII)
_WORD = re.compile(r"(?<![\w.'\"])[A-Za-z_]\w*", re.ASCII)


def data_of(text: str) -> Data:
    """Return the plain data of a case, with `${…}` left in."""
    return parse_document(check_source(Source(text, "case.yaml"))).data


def mapping(data: Mapping[str, Any], key: str) -> Data:
    """Return the mapping under a key, or an empty one if it is invalid."""
    value = data.get(key)
    return dict(value) if isinstance(value, dict) else {}


def with_sections(text: str, sections: Mapping[str, Data]) -> str:
    """Replace sections of a case."""
    before = data_of(text)
    after = before | {name: dict(data) for name, data in sections.items()}
    return _with_edits(text, operations(before, after))


def with_patches(
    text: str, patches: Sequence[Mapping[str, Any]], path: Path, contract: Contract | None
) -> tuple[str, list[str]]:
    """Apply as many patches as possible together (see `most_that_hold`), and then each that is valid on top of them.

    Args:
        text: Text of the case.
        patches: Each with `section`, `operations` and `why`.
        path: Path of the case file.
        contract: The contract; None allows everything.

    Returns:
        The text, and for each patch why it was skipped; empty if it was not.
    """
    held = most_that_hold(
        range(len(patches)), lambda few: with_patches_together(text, [patches[k] for k in few], path, contract)
    )
    kept, text = held if held is not None else ((), text)
    reasons = [""] * len(patches)
    for k, patch in enumerate(patches):
        if k in kept:
            continue
        try:
            made = revised(text, path, patch["operations"], patch["section"]).text
            breaches = contract.breaches(load_text(made, path)) if contract is not None else []
            reason = breaches[0][1] if breaches else ""
        except (PatchError, SpecError) as error:
            made, reason = text, str(error).splitlines()[0]
        text = text if reason else made
        reasons[k] = f"a patch on {patch['section']} was left out: {reason}" if reason else ""
    return text, reasons


def revised(text: str, path: Path, changes: Sequence[Operation], section: str) -> Revision:
    """Apply a patch of the Critic to one section, or to parameters.

    Args:
        text: Text of the case.
        path: Path of the case file.
        changes: The patch.
        section: The section that it may change; `plan` for values of parameters.

    Raises:
        PatchError: If it cannot be applied, or changes anything else.
        SpecError: If the result is not a valid case.
    """
    _owned(data_of(text), changes, section)
    return revise(Source(text, str(path)), path, changes)


def _owned(data: Any, changes: Sequence[Operation], section: str) -> Any:
    """Return a document with a patch applied that may change one section, or values of parameters."""
    if section != "plan":
        return apply_owned(data, changes, section)
    for number, change in enumerate(changes):
        try:
            steps = split_pointer(change.get("path"))
        except ValueError as error:
            raise PatchError(number, str(error)) from None
        known = mapping(data, "params")
        if change.get("op") not in ("add", "replace", "test") or len(steps) < 2 or steps[0] != "params":
            raise PatchError(number, "a patch on plan sets /params/NAME, and nothing else")
        if steps[1] not in known:
            raise PatchError(number, f"there is no parameter `{steps[1]}`{there_are(known)}")
    return apply_operations(data, changes)


def most_that_hold(items: Iterable[K], attempt: Callable[[Sequence[K]], T | None]) -> tuple[Sequence[K], T] | None:
    """Return the items that can be applied together, and the result: all, all but one, or those that can one by one.

    Args:
        items: Items that may need each other, or be wrong.
        attempt: Applies items; returns None if that is not possible.
    """
    items = tuple(items)
    for few in dict.fromkeys([items, *combinations(items, len(items) - 1)] if len(items) > 1 else [items]):
        if few and (made := attempt(few)) is not None:
            return few, made
    found: tuple[Sequence[K], T] | None = None
    for item in (*items, *items) if len(items) > 2 else ():  # twice: one may need a later one
        few = found[0] if found is not None else ()
        if item not in few and (made := attempt((*few, item))) is not None:
            found = (*few, item), made
    return found


def params_used(text: str, pointers: Iterable[str]) -> list[str]:
    """Return the parameters on which entries of a case depend, also through other parameters.

    Args:
        text: Text of the case.
        pointers: JSON Pointers to the entries.
    """
    data = data_of(text)
    params, found = mapping(data, "params"), dict[str, None]()
    entries: list[Any] = []
    for place in pointers:
        entry: Any = data
        for step in split_pointer(place):
            name = re.sub(r"_\d+$", "", step)  # copies made by `repeat` stand once in the text
            entry = entry.get(step, entry.get(name)) if isinstance(entry, dict) else None
        entries.append(entry)
    while entries:
        words = {word for row in _EXPRESSION.findall(json.dumps(entries.pop())) for word in _WORD.findall(row)}
        fresh = words & set(params) - set(found)
        found |= dict.fromkeys(fresh)
        entries += [params[name] for name in fresh]
    return [name for name in params if name in found]


def with_renamed(text: str, renames: Mapping[str, str]) -> str:
    """Rename parameters, also in expressions."""
    moves: list[Operation] = [
        {"op": "move", "from": pointer(("params", old)), "path": pointer(("params", new))}
        for old, new in renames.items()
    ]
    before = data_of(text := _with_edits(text, moves))
    case = {key: value for key, value in before.items() if key != "prefabs"}  # prefabs do not see the case's parameters
    return _with_edits(text, operations(before, before | _params_renamed(words_renamed(case, renames), renames)))


def _params_renamed(data: Any, renames: Mapping[str, str]) -> Any:
    """Return data in which parameters have other names, in their definition, variants and sweeps."""
    if not isinstance(data, dict):
        return data
    fresh = {}
    for key, value in data.items():
        name = _GRID_PARAM.sub(lambda found: f"params.{renames.get(found[1], found[1])}", key)
        if key == "params" and isinstance(value, dict):
            fresh[name] = {renames.get(param, param): inner for param, inner in value.items()}
        else:
            fresh[name] = _params_renamed(value, renames)
    return fresh


def words_renamed(data: Any, renames: Mapping[str, str]) -> Any:
    """Return data of a plan with parameters renamed in `${…}`."""
    if isinstance(data, str):
        return _EXPRESSION.sub(lambda found: _WORD.sub(lambda word: renames.get(word[0], word[0]), found[0]), data)
    if isinstance(data, dict):
        return {key: words_renamed(value, renames) for key, value in data.items()}
    return [words_renamed(value, renames) for value in data] if isinstance(data, list) else data


def with_operations(text: str, changes: Sequence[Operation]) -> str:
    """Apply a patch to the parts that no Writer owns.

    Raises:
        PatchError: If it cannot be applied.
    """
    before = data_of(text)
    return _with_edits(text, operations(before, apply_operations(before, changes))) if changes else text


def with_patches_together(
    text: str, patches: Sequence[Mapping[str, Any]], path: Path, contract: Contract | None
) -> str | None:
    """Apply patches as one, so that each may need what another one changes; None if that is not possible.

    Args:
        text: Text of the case.
        patches: Each with `section` and `operations`.
        path: Path of the case file.
        contract: The contract; None allows everything.
    """
    try:
        data = parse_document(Source(text, str(path))).data
        for patch in patches:
            data = _owned(data, patch["operations"], patch["section"])
        combined = [operation for patch in patches for operation in patch["operations"]]
        made = revise(Source(text, str(path)), path, combined).text
        broken = contract is not None and contract.breaches(load_text(made, path))
    except (PatchError, SpecError):
        return None
    return None if broken else made


def with_params(text: str, params: Mapping[str, Any]) -> str:
    """Set values of parameters."""
    return _laid_over(text, "params", params)


def with_waivers(text: str, waive: Mapping[str, str]) -> str:
    """Add waivers of lint findings."""
    return _laid_over(text, "waive", waive)


def with_checks(text: str, checks: Fragments, drop: Sequence[str] = ()) -> str:
    """Put measures, events and expectations into a case; they replace those with the same names.

    Args:
        text: Text of the case.
        checks: Measures, events and expectations to put in.
        drop: Names of expectations to remove.
    """
    before = data_of(text)
    actions = mapping(before, "actions")
    for part in FROZEN_PARTS:
        rows = mapping(actions, part) | getattr(checks, part)
        rows = {name: row for name, row in rows.items() if part != "expect" or name not in drop}
        if rows:
            actions[part] = rows
        else:
            actions.pop(part, None)
    return _with_edits(text, operations(before, before | {"actions": actions}))


def _with_edits(text: str, changes: Sequence[Operation]) -> str:
    """Apply operations that are known to be valid."""
    return edit_source(Source(text, "case.yaml"), changes) if changes else text


def change_lines(before: str, after: str) -> list[str]:
    """Describe the differences between two texts of a case."""
    return [change_line(change) for change in difference(data_of(before), data_of(after))]


def _laid_over(text: str, key: str, values: Mapping[str, Any]) -> str:
    before = data_of(text)
    merged = mapping(before, key) | json.loads(json.dumps(dict(values)))
    return _with_edits(text, operations(before, before | {key: merged})) if values else text
