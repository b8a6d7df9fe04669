"""The panels of a layout: three views in parallel projection with axes in metres, and what the camera sees."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil, floor, log10

import numpy as np

from text2sim.drawing.canvas import FAINT, INK, Box, Canvas, Color, clipped, text_width
from text2sim.drawing.labels import Label, place_labels
from text2sim.drawing.marks import ArrowMark, CameraMark, JointMark
from text2sim.drawing.picture import Picture
from text2sim.drawing.stage import Stage
from text2sim.drawing.view import View, parallel

AXES: dict[str, np.ndarray] = {
    "top": np.array([(1.0, 0, 0), (0, 1, 0), (0, 0, 1)]),
    "front": np.array([(1.0, 0, 0), (0, 0, 1), (0, -1, 0)]),
    "side": np.array([(0.0, 1, 0), (0, 0, 1), (1, 0, 0)]),
}
"""Right, up and back of each view: from above, from -y, from +x."""
NAMES = {"top": "xy", "front": "xz", "side": "yz"}
LINE = 19.0
"""Height of a label [pixels]."""
LABELS = 14
MANY = 4
"""A body with more joints than this gets thin lines for them."""
MARGIN = 0.08
"""Part of a panel that stays free on each side."""

JOINT: Color = (214, 40, 120)
VELOCITY: Color = (20, 90, 200)
FORCE: Color = (200, 40, 30)
CAMERA: Color = (110, 80, 170)
DOMAIN: Color = (0, 130, 110)
COLORS: dict[str, Color] = {
    "velocity": VELOCITY,
    "spin": VELOCITY,
    "force": FORCE,
    "torque": FORCE,
    "impulse": FORCE,
}


@dataclass(frozen=True)
class Marks:
    """What is drawn over the bodies."""

    joints: Sequence[JointMark] = ()
    arrows: Sequence[ArrowMark] = ()
    cameras: Sequence[CameraMark] = ()
    domain: tuple[Sequence[float], Sequence[float]] | None = None


@dataclass
class Panel:
    """A view in parallel projection, at its place on the page."""

    name: str
    """top, front or side."""
    view: View
    left: int
    upper: int
    blocked: np.ndarray = field(init=False)
    """(height, width) bool: where lines were drawn."""
    notes: list[Box] = field(default_factory=list)
    """Where something is written, on the page."""

    def __post_init__(self) -> None:
        """Begin with nothing drawn."""
        self.blocked = np.zeros((self.view.height, self.view.width), bool)

    @property
    def box(self) -> Box:
        """Its place on the page."""
        return (self.left, self.upper, self.left + self.view.width, self.upper + self.view.height)

    def at(self, point: Sequence[float]) -> tuple[float, float]:
        """Return where a point [m] of the world falls on the page."""
        x, y = self.view.pixels(point)
        return (self.left + float(x), self.upper + float(y))

    def block(self, a: Sequence[float], b: Sequence[float]) -> None:
        """Remember a line on the page."""
        part = clipped(a, b, self.box)
        if part is None:
            return
        (x0, y0), (x1, y1) = part
        count = int(max(abs(x1 - x0), abs(y1 - y0))) + 2
        x = np.clip(np.linspace(x0, x1, count) - self.left, 0, self.view.width - 1).astype(int)
        y = np.clip(np.linspace(y0, y1, count) - self.upper, 0, self.view.height - 1).astype(int)
        self.blocked[y, x] = True

    def write(self, canvas: Canvas, place: tuple[float, float], text: str, color: Color, *, bold: bool = False) -> None:
        """Write a short note, or near by if the place is taken; nothing else is written over it."""
        width, height = text_width(text, 12, bold), 15.0
        x = min(max(place[0], self.left + 5), self.box[2] - width - 5)
        for number in range(9):
            away = (number + 1) // 2 * (17 if number % 2 else -17)
            y = min(max(place[1] + away, self.upper + 4), self.box[3] - 19)
            box = (x - 3, y - 1, x + width + 3, y + height)
            if not any(_overlap(box, other) for other in self.notes):
                break
        canvas.box(box, fill=(255, 255, 255, 215), radius=3)
        canvas.text((x, y), text, 12, color, bold=bold)
        self.notes.append(box)

    def span(self, axis: int) -> tuple[float, float]:
        """Lowest and highest coordinate [m] along the picture: axis 0 to the right, 1 upwards."""
        middle = float(self.view.axes[axis] @ self.view.origin)
        half = (self.view.width, self.view.height)[axis] / 2 / self.view.focal
        return middle - half, middle + half


def fitted(name: str, bounds: tuple[np.ndarray, np.ndarray], box: tuple[int, int, int, int]) -> Panel:
    """Return a panel in which everything within bounds is seen."""
    axes, (low, high) = AXES[name], bounds
    width, height = box[2] - box[0], box[3] - box[1]
    size = np.maximum(np.abs(axes[:2] @ (high - low)), 1e-6)
    scale = (1 - 2 * MARGIN) * min(width / size[0], height / size[1])
    view = parallel(axes, ((low + high) / 2).tolist(), float(scale), (width, height))
    return Panel(name, view, box[0], box[1])


def nice_step(span: float, most: int) -> float:
    """Return the smallest of 1, 2, 5, 10, … that divides a span into at most so many."""
    power = 10.0 ** floor(log10(max(span, 1e-12) / most))
    return next(power * k for k in (1, 2, 5, 10, 20) if span / (power * k) <= most)


def ticks(low: float, high: float, most: int) -> list[float]:
    """Return round numbers between two others."""
    step = nice_step(high - low, most)
    return [k * step for k in range(ceil(low / step - 1e-9), floor(high / step + 1e-9) + 1)]


def ground(panel: Panel, pixels: np.ndarray, props: Stage) -> np.ndarray:
    """Return the background (height, width, 3) of a panel: white, a tint where there is a ground, and lines."""
    height, width = pixels.shape[:2]
    back = np.full((height, width, 3), 1.0, np.float32)
    for prop in props:
        if prop.plane and abs(float(_normal(prop.triangles) @ panel.view.axes[2])) > 0.9:
            low, high = _flat_bounds(panel, prop.triangles)
            x0, y0 = np.clip(np.ceil(low - 0.5), 0, (width, height)).astype(int)
            x1, y1 = np.clip(np.ceil(high - 0.5), 0, (width, height)).astype(int)
            back[y0:y1, x0:x1] = 0.86 + 0.14 * np.array(prop.rgb)
    for axis, length in ((0, width), (1, height)):
        for value in ticks(*panel.span(axis), _many(length)):
            low, high = panel.span(axis)
            part = (value - low) / (high - low)
            place = min(int((part if axis == 0 else 1 - part) * length), length - 1)
            strong = 0.88 if abs(value) < 1e-9 else 0.955
            if axis == 0:
                back[:, place] *= strong
            else:
                back[place] *= strong
    return back


def composed(picture: Picture, back: np.ndarray) -> np.ndarray:
    """Return a picture that was painted on white, on another background."""
    return picture.pixels + (1.0 - picture.coverage[:, :, None]) * (back - 1.0)


def draw_frame(canvas: Canvas, panel: Panel, title: str) -> None:
    """Draw axes with ticks, the scale and the title."""
    left, upper, right, lower = panel.box
    canvas.box((left - 0.5, upper - 0.5, right + 0.5, lower + 0.5), outline=(150, 156, 164))
    for axis, length in ((0, right - left), (1, lower - upper)):
        low, high = panel.span(axis)
        values = ticks(low, high, _many(length))
        for value in values:
            part = (value - low) / (high - low)
            text = f"{value:.6g}".replace("-", "−") if abs(value) > 1e-12 else "0"
            if axis == 0:
                x = left + part * (right - left)
                canvas.line([(x, lower), (x, lower + 4)], FAINT)
                canvas.text((x, lower + 6), text, 12, FAINT, anchor="ma")
            else:
                y = lower - part * (lower - upper)
                canvas.line([(left - 4, y), (left, y)], FAINT)
                canvas.text((left - 7, y), text, 12, FAINT, anchor="rm")
    across, up = NAMES[panel.name]
    canvas.text((right, lower + 21), f"{across} [m]", 12, INK, anchor="ra")
    canvas.text((left - 42, upper - 7), f"{up} [m]", 12, INK, anchor="ls")
    canvas.text((left + 20, upper - 7), title, 14, INK, bold=True, anchor="ls")
    _scale_bar(canvas, panel)


def _scale_bar(canvas: Canvas, panel: Panel) -> None:
    _, _, right, lower = panel.box
    metres = nice_step(panel.view.width / panel.view.focal, 8)
    length = metres * panel.view.focal
    text = f"{metres:g} m" if metres >= 1 else f"{metres * 100:g} cm" if metres >= 0.01 else f"{metres * 1000:g} mm"
    x1, y = right - 12, lower - 12
    x0 = x1 - length
    canvas.box((x0 - 8, y - 22, right - 4, lower - 4), fill=(255, 255, 255, 205), radius=4)
    canvas.line([(x0, y), (x1, y)], INK, 2)
    for x in (x0, x1):
        canvas.line([(x, y - 4), (x, y + 4)], INK, 1.5)
    canvas.text(((x0 + x1) / 2, y - 5), text, 12, INK, anchor="ms")
    panel.notes.append((x0 - 8, y - 22, right, lower))


def draw_ground_lines(canvas: Canvas, panel: Panel, props: Stage) -> None:
    """Draw every ground that is seen from its edge, hatched below."""
    for prop in (prop for prop in props if prop.plane):
        normal = panel.view.axes @ _normal(prop.triangles)
        if abs(normal[2]) > 0.2:
            continue
        low, high = _flat_bounds(panel, prop.triangles)
        ends = [panel.at(corner) for corner in prop.triangles.reshape(-1, 3)]
        a = min(ends, key=lambda p: p[0] * abs(normal[1]) + p[1] * abs(normal[0]))
        b = max(ends, key=lambda p: p[0] * abs(normal[1]) + p[1] * abs(normal[0]))
        part = clipped(a, b, panel.box)
        if part is None:
            continue
        (x0, y0), (x1, y1) = part
        color = tuple(int(150 * c) for c in prop.rgb)
        canvas.line([(x0, y0), (x1, y1)], color, 2)  # type: ignore[arg-type]
        panel.block((x0, y0), (x1, y1))
        length = max(abs(x1 - x0), abs(y1 - y0))
        for k in range(int(length / 12) + 1):
            x, y = x0 + (x1 - x0) * k * 12 / max(length, 1), y0 + (y1 - y0) * k * 12 / max(length, 1)
            end = (x - 8 * normal[0] - 5 * normal[1], y + 8 * normal[1] - 5 * abs(normal[0]))
            canvas.line([(x, y), end], (*color, 130), 1, clip=panel.box)  # type: ignore[arg-type]


def draw_marks(canvas: Canvas, panel: Panel, marks: Marks) -> None:
    """Draw joints, arrows, cameras and the domain."""
    if marks.domain is not None:
        _draw_domain(canvas, panel, marks.domain)
    for number, camera in enumerate(marks.cameras):
        _draw_camera(canvas, panel, camera, sees=number == 0)
    counts = Counter(joint.body for joint in marks.joints)
    for joint in marks.joints:
        _draw_joint(canvas, panel, joint, many=counts[joint.body] > MANY)
    longest = {
        kind: max((float(np.linalg.norm(a.vector)) for a in marks.arrows if a.kind == kind), default=1.0)
        for kind in COLORS
    }
    for arrow in marks.arrows:
        _draw_arrow(canvas, panel, arrow, longest[arrow.kind])


def _draw_joint(canvas: Canvas, panel: Panel, joint: JointMark, *, many: bool) -> None:
    points = [panel.at(point) for point in joint.points]
    if joint.kind == "path":
        canvas.line(points, (255, 255, 255, 200), 4, clip=panel.box)
        canvas.line(points, JOINT, 2, (7, 4), clip=panel.box)
        return
    a, b = points[0], points[-1]
    length = float(np.hypot(b[0] - a[0], b[1] - a[1]))
    if joint.kind == "ball" or length < 6:
        center, radius = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2), 3.0 if many else 4.5
        if _inside(center, panel.box):
            canvas.ring(center, radius, (255, 255, 255, 220), radius - 0.5)
            canvas.ring(center, radius, JOINT, 1.6)
            if joint.kind != "ball":
                canvas.ring(center, 1.0, JOINT, 1.0, fill=JOINT)
        return
    more = 7.0 / length
    ends = [(p[0] + more * (p[0] - q[0]), p[1] + more * (p[1] - q[1])) for p, q in ((a, b), (b, a))]
    part = clipped(*ends, panel.box)
    if part is None:
        return
    panel.block(*part)
    if joint.kind == "slider":
        canvas.arrow(*part, JOINT, 1.8, both=True)
    else:
        canvas.line(part, (255, 255, 255, 150 if many else 210), 2.0 if many else 3.4)
        canvas.line(part, (*JOINT[:3], 190) if many else JOINT, 1.0 if many else 1.6, (9, 3, 2, 3))


def _draw_arrow(canvas: Canvas, panel: Panel, arrow: ArrowMark, longest: float) -> None:
    local = panel.view.axes @ np.array(arrow.vector)
    size = float(np.linalg.norm(local))
    across = float(np.hypot(local[0], local[1]))
    start = panel.at(arrow.start)
    if not _inside(start, panel.box):
        return
    color = COLORS[arrow.kind]
    reach = max(0.2 * min(panel.view.width, panel.view.height) * size / longest, 22.0)
    if across < 0.08 * size:
        # Towards the eye, or away from it.
        canvas.ring(start, 7, (255, 255, 255, 230), 4)
        canvas.ring(start, 7, color, 2)
        canvas.ring(start, 2, color, 2, fill=color if local[2] > 0 else None)
        end = start
    else:
        length = reach * max(across / size, 0.3)
        end = (start[0] + length * local[0] / across, start[1] - length * local[1] / across)
        canvas.arrow(start, end, color)
        panel.block(start, end)
    if arrow.text:
        width = text_width(arrow.text, 12, bold=True)
        place = (end[0] - width / 2, end[1] - 20 if local[1] >= 0 else end[1] + 6)
        panel.write(canvas, place, arrow.text, color, bold=True)


def _draw_camera(canvas: Canvas, panel: Panel, camera: CameraMark, *, sees: bool) -> None:
    eye, target = panel.at(camera.eye), panel.at(camera.target)
    corners = [panel.at(corner) for corner in camera.corners] if sees else []
    for corner in corners:
        canvas.line([eye, corner], (*CAMERA[:3], 90), 1, clip=panel.box)
    canvas.line([*corners, *corners[:1]], (*CAMERA[:3], 60), 1, (4, 4), clip=panel.box)
    part = clipped(eye, target, panel.box)
    if part is None:
        return
    x, y = part[0]
    if _inside(eye, panel.box):
        way = np.array(target) - np.array(eye)
        way = way / max(float(np.linalg.norm(way)), 1e-9)
        side = np.array((-way[1], way[0]))
        tip = [np.array(eye), np.array(eye) + 13 * way + 7 * side, np.array(eye) + 13 * way - 7 * side]
        canvas.polygon([p.tolist() for p in tip], (*CAMERA[:3], 220))
    else:
        toward = np.array(part[1]) - np.array(part[0])
        if np.linalg.norm(toward) > 1:
            toward = toward / np.linalg.norm(toward)
            canvas.arrow((x, y), (x + 18 * toward[0], y + 18 * toward[1]), CAMERA, 2)
    panel.write(canvas, (x + 10, y + 8), f"camera {camera.name}", CAMERA)


def _draw_domain(canvas: Canvas, panel: Panel, domain: tuple[Sequence[float], Sequence[float]]) -> None:
    a, b = panel.at(domain[0]), panel.at(domain[1])
    corners = [(a[0], a[1]), (b[0], a[1]), (b[0], b[1]), (a[0], b[1]), (a[0], a[1])]
    canvas.line(corners, DOMAIN, 1.6, (8, 5), clip=panel.box)
    if _inside((a[0] + 1, b[1] + 1), panel.box):
        canvas.text((a[0] + 5, b[1] + 3), "domain", 12, DOMAIN)


def draw_labels(
    canvas: Canvas, panel: Panel, picture: Picture, props: Stage, texts: dict[str, str]
) -> list[Label]:
    """Name what is seen in a panel; return the labels."""
    names = list(texts)
    body_of = np.array([names.index(prop.body) if prop.body in texts else -1 for prop in props] + [-1])
    seen, through = body_of[picture.owner], body_of[picture.glazed]
    counts = np.bincount(seen[seen >= 0], minlength=len(names))
    # Glass is named where nothing else of it is seen.
    unseen = np.append(counts == 0, False)[through]
    seen = np.where(unseen, through, seen)
    counts = np.bincount(seen[seen >= 0], minlength=len(names))
    most = [k for k in np.argsort(-counts, kind="stable").tolist() if counts[k]][:LABELS]
    wanted = [(names[k], texts[names[k]], text_width(texts[names[k]], 13) + 28.0) for k in sorted(most)]
    taken = [(x0 - panel.left, y0 - panel.upper, x1 - panel.left, y1 - panel.upper) for x0, y0, x1, y1 in panel.notes]
    labels = place_labels(wanted, seen, names, LINE, panel.blocked, taken)
    x, y = panel.left, panel.upper
    for label in labels:
        box = label.box
        end = (x + label.target[0], y + label.target[1])
        near = (min(max(end[0], x + box[0]), x + box[2]), min(max(end[1], y + box[1]), y + box[3]))
        if abs(near[0] - end[0]) + abs(near[1] - end[1]) > 3:
            canvas.line([near, end], (255, 255, 255, 190), 3)
            canvas.line([near, end], INK, 1)
            canvas.ring(end, 1.6, INK, 1, fill=INK)
    for label in labels:
        left, upper, right, lower = (v + o for v, o in zip(label.box, (x, y, x, y), strict=True))
        canvas.box((left, upper, right, lower), (255, 255, 255, 235), (176, 182, 190), radius=4)
        swatches = _swatches(props, label.key)
        for k, color in enumerate(swatches):
            wide = 10 / len(swatches)
            canvas.box((left + 5 + k * wide, upper + 5, left + 5 + (k + 1) * wide, upper + 14), color)
        canvas.box((left + 5, upper + 5, left + 15, upper + 14), None, (90, 96, 104))
        canvas.text((left + 20, (upper + lower) / 2), label.text, 13, INK, anchor="lm")
    return labels


def _swatches(props: Stage, body: str) -> list[Color]:
    """At most four clearly different colours of a body."""
    found: list[Color] = []
    for prop in props:
        red, green, blue = (int(255 * c) for c in prop.rgb)
        if prop.body == body and all(abs(red - r) + abs(green - g) + abs(blue - b) > 90 for r, g, b, *_ in found):
            found.append((red, green, blue))
            if len(found) == 4:
                break
    return found


def _many(length: float) -> int:
    return max(int(length / 62), 2)


def _inside(point: Sequence[float], box: Box) -> bool:
    return box[0] <= point[0] <= box[2] and box[1] <= point[1] <= box[3]


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _normal(triangles: np.ndarray) -> np.ndarray:
    a, b, c = triangles[0]
    normal = np.cross(b - a, c - a)
    return normal / np.linalg.norm(normal)


def _flat_bounds(panel: Panel, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    pixels = panel.view.pixels(triangles.reshape(-1, 3))
    return pixels.min(axis=0), pixels.max(axis=0)
