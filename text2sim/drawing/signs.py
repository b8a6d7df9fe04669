"""Drawing of marks over the bodies of a panel: joints, arrows, cameras and the domain, with a legend."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from text2sim.drawing.canvas import FAINT, Box, Canvas, Color, clipped, text_width
from text2sim.drawing.marks import ArrowMark, CameraMark, JointMark
from text2sim.drawing.panel import Panel

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
MANY_JOINTS = 4
"""Number of joints of a body above which their lines are thin."""


@dataclass(frozen=True)
class SignMarks:
    """Marks of a picture."""

    joints: Sequence[JointMark] = ()
    arrows: Sequence[ArrowMark] = ()
    cameras: Sequence[CameraMark] = ()
    domain: tuple[Sequence[float], Sequence[float]] | None = None


def draw_marks(canvas: Canvas, panel: Panel, marks: SignMarks) -> None:
    """Draw joints, arrows, cameras and the domain.

    Args:
        canvas: The page.
        panel: The panel.
        marks: The marks.
    """
    if marks.domain is not None:
        _draw_domain(canvas, panel, marks.domain)
    for number, camera in enumerate(marks.cameras):
        _draw_camera(canvas, panel, camera, sees=number == 0)
    counts = Counter(joint.body for joint in marks.joints)
    for joint in marks.joints:
        _draw_joint(canvas, panel, joint, many=counts[joint.body] > MANY_JOINTS)
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
    if joint.kind == "spring":
        canvas.line(_zigzag(a, b), (255, 255, 255, 200), 3.4, clip=panel.box)
        canvas.line(_zigzag(a, b), JOINT, 1.6, clip=panel.box)
        return
    if joint.kind == "ball" or length < 6:
        center, radius = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2), 3.0 if many else 4.5
        if _inside(center, panel.box):
            canvas.ring(center, radius, (255, 255, 255, 220), radius - 0.5)
            if joint.kind == "hinge":
                near = panel.view.local(np.array(joint.points))[:, 2]
                canvas.turn(center, 1.8 * radius, JOINT, 1 if near[-1] > near[0] else -1)
            else:
                canvas.ring(center, radius, JOINT, 1.6)
            if joint.kind != "ball":
                canvas.ring(center, 1.0, JOINT, 1.0, fill=JOINT)
        return
    more = 7.0 / length
    first, last = ((p[0] + more * (p[0] - q[0]), p[1] + more * (p[1] - q[1])) for p, q in ((a, b), (b, a)))
    part = clipped(first, last, panel.box)
    if part is None:
        return
    panel.block(part[0], part[1])
    if joint.kind == "slider":
        canvas.arrow(part[0], part[1], JOINT, 1.8, both=True)
    else:
        canvas.line(part, (255, 255, 255, 150 if many else 210), 2.0 if many else 3.4)
        canvas.line(part, (*JOINT[:3], 190) if many else JOINT, 1.0 if many else 1.6, (9, 3, 2, 3))


def _zigzag(a: tuple[float, float], b: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the points of a spring between two points of a page [pixels]."""
    along = np.subtract(b, a)
    length = float(np.hypot(*along))
    across = np.array([-along[1], along[0]]) / max(length, 1e-9)
    corners = 2 * max(3, round(length / 14))
    sides = np.array([0, 0, *(4 * (-1) ** k for k in range(corners)), 0, 0])
    shares = np.concatenate([[0.0], np.linspace(0.1, 0.9, corners + 2), [1.0]])
    return [(float(x), float(y)) for x, y in np.add(a, shares[:, None] * along + sides[:, None] * across)]


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
        # Nearly towards the eye or away from it.
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
        ahead = np.array(target) - np.array(eye)
        ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
        side = np.array((-ahead[1], ahead[0]))
        tip = [np.array(eye), np.array(eye) + 13 * ahead + 7 * side, np.array(eye) + 13 * ahead - 7 * side]
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


def _inside(point: Sequence[float], box: Box) -> bool:
    return box[0] <= point[0] <= box[2] and box[1] <= point[1] <= box[3]


def draw_legend(canvas: Canvas, left: float, y: float, marks: SignMarks) -> None:
    """Draw a legend of the kinds of marks in a picture.

    Args:
        canvas: The page.
        left: Left edge of the legend [pixels].
        y: Centre of its line [pixels].
        marks: The marks of the picture.
    """
    x = left
    kinds = {joint.kind for joint in marks.joints}
    arrows = {arrow.kind for arrow in marks.arrows}

    def explain(width: float, text: str) -> None:
        """Write the text for a mark that has just been drawn, of this width, and move on."""
        nonlocal x
        x += width
        canvas.text((x, y), text, 13, FAINT, anchor="lm")
        x += text_width(text, 13) + 34

    if "hinge" in kinds:
        canvas.line([(x, y), (x + 34, y)], JOINT, 1.6, (9, 3, 2, 3))
        canvas.turn((x + 48, y), 7, JOINT, 1)
        explain(64, "axis of a hinge, and its positive direction")
    if "slider" in kinds:
        canvas.arrow((x, y), (x + 30, y), JOINT, 1.8, both=True)
        explain(38, "travel of a slider")
    if "ball" in kinds:
        canvas.ring((x + 6, y), 4.5, JOINT, 1.6)
        explain(18, "ball joint")
    if "path" in kinds:
        canvas.line([(x, y), (x + 30, y)], JOINT, 2, (7, 4))
        explain(38, "path of a driven body")
    if "spring" in kinds:
        canvas.line(_zigzag((x, y), (x + 34, y)), JOINT, 1.6)
        explain(42, "spring or cord")
    for found, color, text in (
        (arrows & {"velocity", "spin"}, VELOCITY, "initial velocity, spin"),
        (arrows & {"force", "torque", "impulse"}, FORCE, "force, torque or impulse"),
    ):
        if found:
            canvas.arrow((x, y), (x + 28, y), color, 2.5)
            explain(38, text)
    if marks.cameras:
        canvas.line([(x, y), (x + 26, y - 7)], (*CAMERA[:3], 160), 1)
        canvas.line([(x, y), (x + 26, y + 7)], (*CAMERA[:3], 160), 1)
        explain(34, "field of view of a camera")
    if marks.domain is not None:
        canvas.line([(x, y), (x + 30, y)], DOMAIN, 1.6, (8, 5))
        explain(38, "domain")
