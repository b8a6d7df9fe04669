"""Reader of untrusted XML that never accesses anything outside of the document."""

import re
from pathlib import Path
from xml.etree import ElementTree as ET
from xml.parsers import expat

from text2sim.spec_schema.errors import AssetError

MAX_BYTES = 2 * 1024 * 1024
MAX_ELEMENTS = 20_000
MAX_DEPTH, MAX_ATTRIBUTES = 100, 100

_NOT_A_NUMBER = re.compile(r"(?:^|[\s,])[+-]?(?:nan|inf|infinity)(?=$|[\s,])", re.IGNORECASE)
_NUMBERS = frozenset(
    "pos quat axisangle euler xyaxes zaxis fromto size range limit mass density friction inertia diaginertia "
    "fullinertia damping armature stiffness frictionloss ref springref springlength margin gap gear kp kv "
    "forcerange ctrlrange gainprm biasprm dynprm solref solimp solreflimit solimplimit solreffriction "
    "solimpfriction scale refpos refquat vertex "
    "normal texcoord rgba anchor relpose torquescale polycoef coef width actuatorfrcrange "
    "xyz rpy value ixx ixy ixz iyy iyz izz radius length lower upper effort velocity multiplier "
    "offset".split()
)
"""Attributes of MJCF and URDF with numbers; in the others, `nan` is a name like any other."""


def parse_markup(path: Path) -> ET.Element:
    """Return the root of a document, without comments and text; prefixes of names are kept.

    Raises:
        AssetError: if it is too large, not well-formed, in a strange encoding, declares a document type or entities,
            or has a number that is not finite.
    """
    size = path.stat().st_size
    if size > MAX_BYTES:
        raise AssetError(f"is too large ({size / 2**20:.1f} MiB; at most {MAX_BYTES // 2**20} MiB)")
    reader = _Reader()
    try:
        return reader.read(path.read_bytes())
    except expat.ExpatError as error:
        raise AssetError(f"is not well-formed XML: {expat.ErrorString(error.code)} in line {error.lineno}") from None
    except (LookupError, ValueError):  # an encoding that does not exist, or of which expat has no table
        raise AssetError("declares an encoding that cannot be read; save it as UTF-8") from None


class _Reader:
    """Builds the tree element by element, so that nothing is expanded before it is checked."""

    def __init__(self) -> None:
        self.builder = ET.TreeBuilder()
        self.depth = self.elements = 0
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._doctype

    def read(self, data: bytes) -> ET.Element:
        self.parser.Parse(data, True)
        return self.builder.close()

    def _doctype(self, *_: object) -> None:
        raise AssetError("declares a document type; remove `<!DOCTYPE …>` and its entities")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.depth += 1
        self.elements += 1
        line = self.parser.CurrentLineNumber
        if self.depth > MAX_DEPTH:
            raise AssetError(f"is nested more than {MAX_DEPTH} deep (line {line})")
        if self.elements > MAX_ELEMENTS:
            raise AssetError(f"has more than {MAX_ELEMENTS} elements")
        if len(attributes) > MAX_ATTRIBUTES:  # MuJoCo compares each with all others
            raise AssetError(f"has an element of more than {MAX_ATTRIBUTES} attributes (line {line})")
        for name, value in attributes.items():
            if name in _NUMBERS and _NOT_A_NUMBER.search(value):
                raise AssetError(f'has a number that is not finite: {name}="{value[:40]}" (line {line})')
        self.builder.start(tag, attributes)

    def _end(self, tag: str) -> None:
        self.depth -= 1
        self.builder.end(tag)


def write_markup(root: ET.Element) -> str:
    """Return the document as text, indented."""
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"
