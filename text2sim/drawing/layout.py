"""Page that shows the start of a case from above, from the front, from the side, and through its camera."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from text2sim.compiler.build import Resolution
from text2sim.compiler.shapes.pictures import picture_bytes
from text2sim.drawing.canvas import FAINT, INK, Canvas, shortened, text_width
from text2sim.drawing.framing import subject_bounds
from text2sim.drawing.labels import draw_labels
from text2sim.drawing.lighting import Light, ParallelLight, light_up, sky, soft_lamp
from text2sim.drawing.marks import arrow_marks, camera_marks, joint_marks
from text2sim.drawing.panel import composed, draw_frame, draw_ground_lines, draw_scale, fitted, ground, nice_step
from text2sim.drawing.picture import Picture, Style, paint
from text2sim.drawing.prop import Stage
from text2sim.drawing.signs import SignMarks, draw_legend, draw_marks
from text2sim.drawing.stage import stage
from text2sim.drawing.view import PictureView
from text2sim.drawing.views import camera_pose, cameras, film_view

SIZE = (1600, 1200)
HEAD, FOOT = 66, 34
LEFT, RIGHT, ABOVE, BELOW = 56, 14, 26, 42
"""Margins of a panel for its axes and title [pixels]."""
CELLS = {"top": (0, 0), "front": (0, 1), "side": (1, 1)}
"""Column and row of each panel; the camera has the remaining cell."""
TITLES = {"top": "from above", "front": "from the front (−y)", "side": "from the side (+x)"}
MAX_LABEL_WIDTH = 170
"""Largest width of a label [pixels]."""
THREADS = 2
MANY_TRIANGLES = 40_000
"""Number of triangles above which there are fewer shadows, to save time."""


def layout(resolution: Resolution, variant: str = "") -> bytes:
    """Return the page as a PNG; `variant` describes the overlay in the title."""
    props = stage(resolution)
    bounds = subject_bounds(props)
    width, height = SIZE
    page = np.ones((height, width, 3), np.float32)
    shown = [fitted(name, bounds, _cell(*cell)) for name, cell in CELLS.items()]
    main = next(iter(cameras(resolution)))
    film, corner = _film_panel(resolution, main)
    flat = Style((1.0, 1.0, 1.0), outline=0.6, planes=False)

    def paint_film() -> Picture:
        light = light_up(props, _lamps(resolution, bounds, len(props.triangles)), 0.1, bounds)
        return paint(props, film, light, _film_style(resolution, film, bounds))

    # numpy releases the lock of the interpreter. The slowest picture starts first.
    with ThreadPoolExecutor(THREADS) as pool:
        future = pool.submit(paint_film)
        pictures = list(pool.map(lambda panel: paint(props, panel.view, _headlight(panel.view), flat), shown))
        seen = future.result()
    for panel, picture in zip(shown, pictures, strict=True):
        x0, y0, x1, y1 = (int(value) for value in panel.box)
        page[y0:y1, x0:x1] = composed(picture, ground(panel, picture.pixels, props))
    page[corner[1] : corner[3], corner[0] : corner[2]] = seen.pixels
    canvas = Canvas(page)
    domain = resolution.loaded.case.scene.domain
    marks = SignMarks(
        joint_marks(resolution),
        arrow_marks(resolution, props),
        camera_marks(resolution),
        None if domain is None else (domain.min, domain.max),
    )
    texts = _texts(resolution, props)
    for panel, picture in zip(shown, pictures, strict=True):
        draw_ground_lines(canvas, panel, props)
        draw_frame(canvas, panel, TITLES[panel.name])
        draw_marks(canvas, panel, marks)
        draw_labels(canvas, panel, picture, props, texts)
        draw_scale(canvas, panel)
    title = _camera_title(resolution, main)
    left = min(corner[0] + 2.0, SIZE[0] - RIGHT - text_width(title, 14, bold=True))
    canvas.text((left, corner[1] - 7), title, 14, INK, bold=True, anchor="ls")
    canvas.box((corner[0] - 0.5, corner[1] - 0.5, corner[2] + 0.5, corner[3] + 0.5), outline=(150, 156, 164))
    _draw_head(canvas, resolution, variant)
    draw_legend(canvas, float(LEFT), SIZE[1] - FOOT / 2 - 2, marks)
    return picture_bytes(canvas.finished(), "PNG", compress_level=3)


def _cell(column: int, row: int) -> tuple[int, int, int, int]:
    wide, tall = SIZE[0] // 2, (SIZE[1] - HEAD - FOOT) // 2
    left, upper = column * wide + LEFT, HEAD + row * tall + ABOVE
    return left, upper, (column + 1) * wide - RIGHT, HEAD + (row + 1) * tall - BELOW


def _lamps(resolution: Resolution, bounds: tuple[np.ndarray, np.ndarray], triangles: int) -> list[ParallelLight]:
    """The brightest light of the case, raised if it is very low, and a sky."""
    lights = [light for light in resolution.plan.render["lights"].values() if "direction" in light or "pos" in light]
    brightest = max(lights, key=lambda light: light["strength"], default={"direction": (0.3, 0.5, -1.0)})
    if "direction" in brightest:
        direction = -np.array(brightest["direction"], float)
    else:
        direction = np.array(brightest["pos"], float) - (bounds[0] + bounds[1]) / 2
    direction /= max(float(np.linalg.norm(direction)), 1e-9)
    direction[2] = max(direction[2], 0.35)
    count = 7 if triangles < MANY_TRIANGLES else 3
    return soft_lamp(direction.tolist(), (0.78, 0.75, 0.69), 2, 0.03) + sky(
        count, (0.36, 0.4, 0.46), (0.32, 0.32, 0.32)
    )


def _headlight(view: PictureView) -> Light:
    """Light for a parallel view: from behind the viewer, without shadows, which could be mistaken for things."""
    right, up, back = view.axes
    lamps = soft_lamp((back + 0.45 * up - 0.35 * right).tolist(), (0.62, 0.62, 0.62), 1, 0.0)
    return Light([*lamps, *sky(1, (0.22, 0.22, 0.24), (0.22, 0.22, 0.24))], 0.24)


def _film_panel(resolution: Resolution, name: str) -> tuple[PictureView, tuple[int, int, int, int]]:
    """A camera's view, and its box on the page."""
    left, upper, right, lower = _cell(1, 0)
    left -= LEFT - RIGHT
    lower += BELOW - 12
    view = film_view(resolution, name, (right - left, lower - upper))
    x, y = left + (right - left - view.width) // 2, upper + (lower - upper - view.height) // 2
    return view, (x, y, x + view.width, y + view.height)


def _film_style(resolution: Resolution, view: PictureView, bounds: tuple[np.ndarray, np.ndarray]) -> Style:
    size = float((bounds[1] - bounds[0]).max())
    away = float(np.linalg.norm(view.origin - (bounds[0] + bounds[1]) / 2))
    background = resolution.plan.render["background"]
    return Style(background, outline=0.3, grid=nice_step(size, 5), haze=3.0 * away + 4.0 * size)


def _camera_title(resolution: Resolution, name: str) -> str:
    known = cameras(resolution)
    camera = known[name]
    kind = camera["kind"] if resolution.loaded.case.render.cameras else "derived: the case has none"
    x, y, z = camera_pose(resolution, name).pos
    several = f", first of {len(known)}" if len(known) > 1 else ""
    where = ", ".join(f"{round(value, 3) + 0.0:.4g}" for value in (x, y, z)).replace("-", "−")
    return f"camera {name} ({kind}{several}) at {where}, fov {camera['fov']:g}°"


def _texts(resolution: Resolution, props: Stage) -> dict[str, str]:
    """Labels of bodies and statics, except grounds."""
    planes = {prop.body for prop in props if prop.plane}
    return {
        name: shortened(name, MAX_LABEL_WIDTH, 13) + (f" ×{len(copies)}" if len(copies) > 1 else "")
        for name, copies in resolution.placed.items()
        if name not in planes and copies
    }


def _draw_head(canvas: Canvas, resolution: Resolution, variant: str) -> None:
    plan, case = resolution.plan, resolution.loaded.case
    x = LEFT - 42
    canvas.text((x, 12), plan.case, 24, INK, bold=True)
    x += text_width(plan.case, 24, bold=True) + 16
    count = sum(len(group.entities) for group in plan.bodies)
    facts = [
        f"{plan.steps * plan.dt:g} s in steps of {plan.dt:g} s × {plan.settings.substeps}",
        f"{count} {'bodies' if count != 1 else 'body'}",
    ]
    if variant:
        facts.insert(0, variant)
    canvas.text((x, 20), "  ·  ".join(facts), 15, FAINT)
    if case.prompt:
        canvas.text((LEFT - 42, 46), shortened(case.prompt, SIZE[0] - LEFT, 13.5), 13.5, INK)
