// From where it is seen: freely, or as a camera of the film.

class Eye {
  constructor(canvas, data, onchange) {
    Object.assign(this, { canvas, data, onchange, track: null });
    this.reset();
    const held = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, event);
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId);
      if (!before) return;
      const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
      if (held.size > 1) {
        const other = [...held.values()].find((row) => row.pointerId !== event.pointerId);
        const apart = (row) => Math.hypot(row.clientX - other.clientX, row.clientY - other.clientY);
        this.zoom(apart(before) / Math.max(apart(event), 1));
        this.pan(dx / 2, dy / 2);
      } else if (before.button > 0 || event.shiftKey || event.ctrlKey) this.pan(dx, dy);
      else this.turn(dx, dy);
      held.set(event.pointerId, wrap(event, before.button));
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => held.delete(event.pointerId));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(clamp(event.deltaY, -200, 200) * 0.0015));
    }, { passive: false });
  }

  /** Looks at everything from where the film begins. */
  reset() {
    const first = this.data.cameras[0];
    this.fov = (first?.fov ?? 40) * Math.PI / 180;
    this.take(first ? this.along(first, 0) : { pos: add(this.data.center, [0, -4 * this.data.radius, 0]), look: this.data.center });
    this.onchange?.();
  }

  /** Goes on freely from where a camera stands. */
  take({ pos, look }) {
    const arm = minus(pos, look);
    // Turn about what is in the middle of the picture, as far away as what happens.
    const away = clamp(dot(minus(pos, this.data.center), unit(arm)), 0.3 * long(arm), 3 * long(arm)) || long(arm);
    this.target = minus(pos, times(unit(arm), away));
    Object.assign(this, { track: null, away, yaw: Math.atan2(arm[1], arm[0]), pitch: Math.asin(clamp(arm[2] / long(arm), -1, 1)) });
  }

  free() {
    if (this.track === null) return;
    const camera = this.data.cameras[this.track];
    this.fov = camera.fov * Math.PI / 180;
    this.take(this.along(camera, this.time ?? 0));
    this.onfree?.();
  }

  turn(dx, dy) {
    this.free();
    this.yaw -= dx * 0.006;
    this.pitch = clamp(this.pitch + dy * 0.006, -1.55, 1.55);
    this.onchange();
  }

  pan(dx, dy) {
    this.free();
    const { pos, look, up } = this.camera(), [right, above] = basis(pos, look, up);
    const step = 2 * this.away * Math.tan(this.fov / 2) / this.canvas.clientHeight;
    this.target = add(this.target, add(times(right, -dx * step), times(above, dy * step)));
    this.onchange();
  }

  zoom(factor) {
    this.free();
    this.away = clamp(this.away * factor, 0.02 * this.data.radius, 60 * this.data.radius);
    this.onchange();
  }

  along(camera, t) {
    const [a, b, w] = around(camera.times, t);
    const mix = (values) => [0, 1, 2].map((c) => values[3 * a + c] * (1 - w) + values[3 * b + c] * w);
    return { pos: mix(camera.pos), look: mix(camera.look), up: camera.up, fov: camera.fov * Math.PI / 180 };
  }

  /** Where it stands at a time, and its vertical field of view: a narrow page shows no less across than the film. */
  camera(t = this.time ?? 0) {
    const camera = this.standing(t), { clientWidth: w, clientHeight: h } = this.canvas;
    const narrow = Math.max(this.data.aspect * h / Math.max(w, 1), 1);
    return { ...camera, fov: 2 * Math.atan(Math.tan(camera.fov / 2) * narrow) };
  }

  standing(t) {
    this.time = t;
    if (this.track !== null) return this.along(this.data.cameras[this.track], t);
    const flat = Math.cos(this.pitch);
    const way = [flat * Math.cos(this.yaw), flat * Math.sin(this.yaw), Math.sin(this.pitch)];
    return { pos: add(this.target, times(way, this.away)), look: this.target, up: [0, 0, 1], fov: this.fov };
  }
}

const wrap = (event, button) => ({ pointerId: event.pointerId, clientX: event.clientX, clientY: event.clientY, button });
