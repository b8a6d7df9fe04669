"""Reader of MJCF documents, which reduces them to what the engine supports."""

from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

from text2sim.assets.bundle import Bundle
from text2sim.assets.markup import write_markup
from text2sim.spec_schema.errors import AssetError

MESHES = (".obj", ".stl")
TEXTURES = (".png",)
MAX_TEXTURE = 4096
MAX_PIXELS = 120_000_000
"""Total size of generated textures: MuJoCo stores them at three bytes a pixel."""
MAX_LINKS = 500
MAX_RATIO = 1000.0
"""Gear ratio of two coupled joints; a harmonic drive has at most 320."""

SECTIONS = frozenset("compiler default asset worldbody contact equality tendon actuator".split())
IGNORED_ELEMENTS = frozenset("option size statistic visual sensor keyframe custom camera light".split())
"""Sections and elements that the engine ignores; the program does not contain them."""
KNOWN_ELEMENTS = {
    "compiler": frozenset(),
    "default": frozenset(
        "default mesh material joint geom site pair equality tendon general motor position velocity".split()
    ),
    "asset": frozenset("mesh texture material layer".split()),
    "worldbody": frozenset("body frame geom joint freejoint inertial site".split()),
    "contact": frozenset("pair exclude".split()),
    "equality": frozenset("connect weld joint".split()),
    "tendon": frozenset("fixed spatial joint site geom pulley".split()),
    "actuator": frozenset("general motor position velocity".split()),
}
"""Allowed elements of each section, at any depth."""
ADVICE = {
    "include": "insert the content of the other file",
    "plugin": "the engine has no plugins",
    "extension": "the engine has no plugins",
    "hfield": "a height field cannot be part of a body",
    "replicate": "list the copies, or use `repeat` in the case",
    "composite": "list its bodies",
    "attach": "insert the bodies of the other model",
    "model": "insert the bodies of the other model",
}
GEOMS = frozenset("plane sphere capsule ellipsoid cylinder box mesh".split())
TRANSMISSIONS = ("joint", "jointinparent", "tendon")
DIRECTORIES = ("assetdir", "meshdir", "texturedir")


@dataclass
class MechanismDraft:
    """A model before its inspection by MuJoCo."""

    text: str
    notes: list[str] = field(default_factory=list)
    limits: dict[str, float] = field(default_factory=dict)
    """Largest motor force by joint, where the document has it outside of an actuator."""
    inertialess: bool = False
    """Whether the mass of some link follows from its shape and density."""


def read_mjcf(root: ET.Element, bundle: Bundle, base: str | None) -> MechanismDraft:
    """Return the model with its files in the bundle, and with names for all bodies and joints.

    Args:
        root: Root of the document; it is changed.
        bundle: Collects the files.
        base: `fixed` or `free`; that of the document if None.

    Raises:
        AssetError: if it has something that cannot be simulated, or not safely.
    """
    _check_elements(root)
    notes = _leave_out(root)
    _take_files(root, bundle)
    notes += _drop_grounds(root)
    _name_all(root)
    if base is not None:
        _set_base(root, free=base == "free")
    if root.find("tendon") is not None:
        notes.append("the engine converts motors on tendons to motors on joints, and ignores tendons otherwise")
    return MechanismDraft(write_markup(root), notes)


def _check_elements(root: ET.Element) -> None:
    for section in root:
        if section.tag not in SECTIONS | IGNORED_ELEMENTS:
            raise _refusal(section.tag)
        if section.tag in IGNORED_ELEMENTS:
            continue
        for element in section.iter():
            if element is not section:
                _check_element(element, section.tag)
    textures = [
        texture for section in root if section.tag not in IGNORED_ELEMENTS for texture in section.iter("texture")
    ]
    if sum(map(_pixels, textures)) > MAX_PIXELS:
        raise AssetError(f"has textures of more than {MAX_PIXELS:,} pixels in total; make them smaller")


def _check_element(element: ET.Element, section: str) -> None:
    if element.tag not in KNOWN_ELEMENTS[section] | IGNORED_ELEMENTS:
        raise _refusal(element.tag)
    if element.tag == "geom" and element.get("type", "sphere") not in GEOMS:
        raise AssetError(f"has a geom of type `{element.get('type')}`; the engine has {', '.join(sorted(GEOMS))}")
    if section == "actuator" and not any(name in element.attrib for name in TRANSMISSIONS):
        raise AssetError(f"has an actuator `{element.get('name', '')}` that does not act on a joint; remove it")
    if section == "equality" and element.tag == "joint":
        _check_coupling(element)
    if element.tag == "texture" and _is_too_large(element.get("width"), element.get("height"), element.get("gridsize")):
        raise AssetError(f"has a texture of more than {MAX_TEXTURE} x {MAX_TEXTURE} pixels")
    if section == "worldbody" and _number(element.get("ref")):
        name, ref = element.get("name", ""), element.get("ref")
        raise AssetError(f'measures the position of joint `{name}` from ref="{ref}"; remove `ref`')


def _check_coupling(element: ET.Element) -> None:
    """Refuse gears that nothing could turn: the inertia of the faster joint counts by the square of the ratio."""
    factors = [abs(_number(text, "polycoef")) for text in element.get("polycoef", "0 1").split()]
    ratio = factors[1] if len(factors) > 1 else 1.0
    if max(factors, default=0.0) > MAX_RATIO or 0 < ratio < 1 / MAX_RATIO:
        name = element.get("joint1", "")
        raise AssetError(f"couples joint `{name}` at 1:{ratio:g} (`polycoef`); up to 1:{MAX_RATIO:g} is possible")


def _number(text: str | None, name: str = "ref") -> float:
    try:
        return float(text or 0.0)
    except ValueError:
        raise AssetError(f'has an invalid number: {name}="{(text or "")[:40]}"') from None


def _pixels(texture: ET.Element) -> int:
    """Pixels of a texture that MuJoCo generates: the six sides of a cube unless its type is 2d."""
    if texture.get("builtin", "none") == "none":
        return 0
    wide, tall = (int(size) if (size := texture.get(name, "0")).isdecimal() else 0 for name in ("width", "height"))
    return wide * tall if texture.get("type", "cube") == "2d" else 6 * wide * wide


def _is_too_large(*sizes: str | None) -> bool:
    numbers = [number for size in sizes if size for number in size.split()]
    return any(not number.isdecimal() or int(number) > MAX_TEXTURE for number in numbers)


def _refusal(tag: str) -> AssetError:
    return AssetError(f"has `<{tag}>`, which cannot be simulated: {ADVICE.get(tag, 'remove it')}")


def _leave_out(root: ET.Element) -> list[str]:
    found = set()
    for parent in list(root.iter()):
        for child in [child for child in parent if child.tag in IGNORED_ELEMENTS]:
            found.add(child.tag)
            parent.remove(child)
    return [f"left out, because the engine ignores it: {', '.join(sorted(found))}"] if found else []


def _take_files(root: ET.Element, bundle: Bundle) -> None:
    where: dict[str, str] = {}
    bare = False
    for compiler in root.iter("compiler"):
        where |= {key: compiler.attrib.pop(key) for key in DIRECTORIES if key in compiler.attrib}
        bare = compiler.attrib.pop("strippath", "false") == "true" or bare
    for asset in root.iter("asset"):
        for element in asset:
            for key in [key for key in element.attrib if key.startswith("file")]:
                mesh = element.tag == "mesh"
                folder = where.get("meshdir" if mesh else "texturedir", where.get("assetdir", ""))
                reference = Path(element.attrib[key]).name if bare else element.attrib[key]
                name = f"{folder.rstrip('/')}/{reference}" if folder and not reference.startswith("/") else reference
                # The default name of an asset is that of its file, which is about to change.
                element.attrib.setdefault("name", Path(reference).stem)
                element.attrib.pop("content_type", None)
                element.set(key, bundle.add(name, MESHES if mesh else TEXTURES, painted=False))
    if any("file" in element.attrib for element in root.iter() if element.tag not in ("mesh", "texture")):
        raise AssetError("refers to a file outside of its meshes and textures")


def _drop_grounds(root: ET.Element) -> list[str]:
    dropped = 0
    for world in root.iter("worldbody"):
        for geom in [geom for geom in world.findall("geom") if geom.get("type") == "plane"]:
            world.remove(geom)
            dropped += 1
    return ["its ground plane is left out; use `scene.statics` for the ground"] if dropped else []


def _name_all(root: ET.Element) -> None:
    bodies = [body for world in root.iter("worldbody") for body in world.iter("body")]
    if len(bodies) > MAX_LINKS:
        raise AssetError(f"has {len(bodies)} bodies; at most {MAX_LINKS} are possible")
    taken = {element.get("name") for element in root.iter() if element.get("name")}

    def fresh(stem: str) -> str:
        name, number = stem, 1
        while name in taken:
            number += 1
            name = f"{stem}_{number}"
        taken.add(name)
        return name

    for index, body in enumerate(bodies):
        name = body.get("name") or fresh(f"link_{index}")
        body.set("name", name)
        joints = _children(body, "joint", "freejoint")
        known = {joint.get("name") for joint in joints}
        for joint in joints:
            if joint.get("name"):
                continue
            # The default name of a joint is that of its link, as in a case.
            joint.set("name", name if name not in known else fresh(name))
            known.add(joint.get("name"))


def _children(parent: ET.Element, *tags: str) -> list[ET.Element]:
    """The children of an element with these tags, including those in frames."""
    found = []
    for child in parent:
        found += [child] if child.tag in tags else _children(child, *tags) if child.tag == "frame" else []
    return found


def _set_base(root: ET.Element, *, free: bool) -> None:
    bodies = [body for world in root.iter("worldbody") for body in _children(world, "body")]
    for body in bodies:
        loose = [joint for joint in body if joint.tag == "freejoint" or joint.get("type") == "free"]
        if not free:
            for joint in loose:
                body.remove(joint)
        elif len(bodies) > 1:
            raise AssetError("has several roots, so that only the file can set `base: free`, with `<freejoint/>`")
        elif not loose:
            if _children(body, "joint", "freejoint"):
                raise AssetError(f"holds its root `{body.get('name')}` with a joint, so that `base` cannot be free")
            body.insert(0, ET.Element("freejoint", name=str(body.get("name"))))
