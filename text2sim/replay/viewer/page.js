// Everything on the page comes from untrusted files: it is inserted as text, never as HTML.

const byId = (id) => document.getElementById(id);
const make = (kind, text, name) => {
  const element = document.createElement(kind);
  if (text !== undefined) element.textContent = text;
  if (name) element.className = name;
  return element;
};

/** A small text, with code in backticks. */
function prose(text) {
  const element = make("small");
  text.split("`").forEach((part, k) => element.append(k % 2 ? make("code", part) : part));
  return element;
}

const COARSE = [1, 0.6, 0.4, 0.25], SLOW = 90;

class Replay {
  constructor() {
    Object.assign(this, { canvas: byId("view"), coarse: 0, time: 0, span: [0, 0], plots: [], rows: [] });
    try {
      this.stage = new Stage(this.canvas);
      this.stage.onchange = () => this.redraw();
      this.control = new ViewControl(this.stage.camera, this.canvas, () => this.redraw());
      this.control.onfree = () => { byId("camera").value = "free"; };
    } catch (error) {
      byId("trouble").textContent = `Nothing can be drawn in 3D: ${error.message}. Plots and events work without.`;
      byId("trouble").hidden = false;
    }
    this.listen();
    new ResizeObserver(() => { this.refresh(); }).observe(this.canvas.parentElement);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.refresh());
  }

  /** Shows a recording; one that replaces another keeps time and view, or follows the end. */
  show(data) {
    const first = !this.data, following = this.time >= this.span[1] - 1e-9;
    const ends = [data.links.times, data.figures[0]?.times, data.measure_times].map((times) => times?.at(-1) ?? 0);
    this.data = data;
    this.span = [0, Math.max(...ends) || 1];
    if (!first) this.time = following ? this.span[1] : Math.min(this.time, this.span[1]);
    this.shown = undefined;
    byId("time").max = this.span[1];
    byId("contacts").hidden = !data.contacts;
    for (const name of ["plots", "expect", "events", "ticks", "notes"]) byId(name).replaceChildren();
    this.stage?.show(data);
    this.control?.show(data);
    this.plots = data.measures.map((row) => new Plot(byId("plots"), row, data.measure_times, this.span, data.events, (t) => this.seek(t)));
    byId("plots-part").hidden = !data.measures.length;
    this.listCameras();
    if (first) this.reset();
    this.listExpectations();
    this.listEvents();
    for (const note of data.notes) byId("notes").append(make("li", note));
    byId("notes-part").hidden = !data.notes.length;
    this.refresh();
  }

  /** Looks through a camera of the film. */
  seeThrough(track) {
    if (this.control) this.control.track = track;
    byId("camera").value = track;
    this.redraw();
  }

  reset() {
    this.control?.reset();
    byId("camera").value = "free";
    this.redraw();
  }

  /** Takes sizes and colours from the page. */
  refresh() {
    if (!this.data) return;
    this.resize();
    const dark = window.matchMedia("(prefers-color-scheme: dark)").matches;
    if (this.stage) this.stage.background = this.data.background.map((c, k) => dark ? 0.16 * c + [0.03, 0.04, 0.05][k] : c);
    const style = getComputedStyle(document.body);
    for (const plot of this.plots) plot.paint(style.getPropertyValue("--ink"), style.getPropertyValue("--soft"));
    this.redraw();
  }

  /** Sets the resolution: lower while playing if drawing is slow, as without a graphics card. */
  resize() {
    const scale = Math.min(window.devicePixelRatio || 1, 2) * (this.playing ? COARSE[this.coarse] : 1), { canvas } = this;
    canvas.width = Math.max(Math.round(canvas.clientWidth * scale), 1);
    canvas.height = Math.max(Math.round(canvas.clientHeight * scale), 1);
  }

  listCameras() {
    const list = byId("camera"), chosen = this.control?.track;
    list.replaceChildren(list.options[0]);
    this.data.cameras.forEach((camera, k) => {
      const option = make("option", `film: ${camera.name}`);
      option.value = k;
      list.append(option);
    });
    list.value = chosen ?? "free";
  }

  listExpectations() {
    const list = byId("expect"), { expect, events, measures } = this.data;
    byId("expect-part").hidden = !expect.length;
    for (const row of [...expect].sort((a, b) => (a.ok ?? 0.5) - (b.ok ?? 0.5))) {
      const item = make("li", undefined, row.ok ? "good" : row.ok === false ? "bad" : "open");
      item.append(make("b", row.ok ? "✓ " : row.ok === false ? "✗ " : "? "), make("code", row.name), prose(`${row.wanted}: ${row.why}`));
      const first = events.find((event) => event.name === row.event);
      const bound = measures.flatMap((measure) => measure.bounds).find((one) => one.name === row.name);
      const time = first ? first.time : bound?.from;
      if (time !== undefined && time > 0) this.jump(item, time);
      list.append(item);
    }
  }

  listEvents() {
    const { events } = this.data, ticks = byId("ticks"), list = byId("events"), colors = [...new Set(events.map((row) => row.name))];
    byId("events-part").hidden = !events.length;
    this.rows = events.map((event) => {
      const item = make("li");
      item.append(make("span", `${event.time.toFixed(3)} s`, "when"), make("code", event.name), make("small", event.of));
      this.jump(item, event.time);
      list.append(item);
      const tick = make("button", undefined, "tick");
      tick.style.left = `${100 * event.time / this.span[1]}%`;
      tick.style.setProperty("--row", colors.indexOf(event.name) % 3);
      tick.title = `${event.name} ${event.time.toFixed(3)} s${event.of ? ": " + event.of : ""}`;
      tick.setAttribute("aria-label", tick.title);
      tick.tabIndex = -1;
      tick.addEventListener("click", () => this.seek(event.time));
      ticks.append(tick);
      return item;
    });
  }

  jump(item, time) {
    item.classList.add("jump");
    item.tabIndex = 0;
    item.addEventListener("click", () => this.seek(time));
    item.addEventListener("keydown", (event) => { if (event.key === "Enter") this.seek(time); });
  }

  listen() {
    const slider = byId("time"), list = byId("camera");
    list.addEventListener("change", () => {
      if (list.value === "free") this.control.free(); else this.seeThrough(Number(list.value));
      list.blur();
    });
    slider.addEventListener("input", () => this.seek(Number(slider.value)));
    byId("play").addEventListener("click", () => this.toggle());
    byId("contacts").addEventListener("click", () => this.showTouches());
    byId("reset").addEventListener("click", () => this.reset());
    this.canvas.addEventListener("dblclick", () => this.reset());
    let pressed = [0, 0];
    this.canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("pointerup", (event) => {
      if (event.button === 0 && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 4) this.pick(event.offsetX, event.offsetY);
    });
    window.addEventListener("keydown", (event) => this.press(event));
    // A clicked button must not keep the focus, or the space bar would press it.
    document.addEventListener("click", (event) => { if (event.detail) event.target.closest("button")?.blur(); });
  }

  press(event) {
    if (!this.data || event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.("select")) return;
    if (event.key === " " && event.target.matches?.("button")) return;  // the button handles it
    const times = this.data.links.times.length > 1 ? this.data.links.times : this.data.figures[0]?.times ?? this.data.links.times;
    const step = (count) => {
      this.pause();
      const [a, b, w] = around(times, this.time);
      this.seek(times[clamp((count > 0 && w < 1 - 1e-6 ? a : w > 1e-6 ? b : a) + count, 0, times.length - 1)]);
    };
    const speed = (by) => {
      const list = byId("speed");
      list.selectedIndex = clamp(list.selectedIndex + by, 0, list.options.length - 1);
    };
    const deeds = {
      " ": () => this.toggle(), ArrowLeft: () => step(event.shiftKey ? -10 : -1), ArrowRight: () => step(event.shiftKey ? 10 : 1),
      ArrowUp: () => speed(1), ArrowDown: () => speed(-1), Home: () => this.seek(0), End: () => this.seek(this.span[1]),
      c: () => this.showTouches(), r: () => this.reset(), Escape: () => this.choose(-1),
    };
    const deed = deeds[event.key];
    if (!deed) return;
    event.preventDefault();
    deed();
  }

  showTouches() {
    if (!this.stage || !this.data?.contacts) return;
    this.stage.touches = !this.stage.touches;
    byId("contacts").setAttribute("aria-pressed", this.stage.touches);
    this.redraw();
  }

  /** Names the body in a pixel of the picture. */
  pick(x, y) {
    if (!this.stage || !this.data) return "";
    this.control.look(this.time);
    this.choose(this.stage.pick(x, y));
    return this.stage.bodies[this.stage.chosen] ?? "";
  }

  choose(chosen) {
    this.stage?.choose(chosen);
    this.redraw();
  }

  /** Shows the chosen body and what it touches. */
  tell() {
    const label = byId("chosen"), name = this.stage?.bodies[this.stage.chosen];
    label.hidden = name === undefined;
    label.textContent = name ?? "";
    if (name === undefined || !this.data.contacts) return;
    const { names } = this.data.contacts, mine = names.indexOf(name), felt = new Map();
    for (const [a, b, force] of this.stage.touching) {
      if (a === mine || b === mine) { const other = names[a === mine ? b : a]; felt.set(other, (felt.get(other) ?? 0) + force); }
    }
    const rows = [...felt].sort((a, b) => b[1] - a[1]).slice(0, 4).map(([other, force]) => `${other} ${number(force)} N`);
    if (rows.length) label.append(make("small", "touches " + rows.join(", ")));
  }

  toggle() { if (this.playing) this.pause(); else this.play(); }

  play() {
    if (this.time >= this.span[1] - 1e-9) this.time = 0;
    this.playing = true;
    this.before = null;
    this.resize();
    byId("play").textContent = "❚❚";
    byId("play").setAttribute("aria-label", "Pause");
    this.redraw();
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.resize();
    this.redraw();
    byId("play").textContent = "▶";
    byId("play").setAttribute("aria-label", "Play");
  }

  seek(t) {
    this.time = clamp(t, ...this.span);
    this.redraw();
  }

  redraw() {
    if (this.waiting || !this.data) return;
    this.waiting = true;
    requestAnimationFrame((now) => { this.waiting = false; this.frame(now); });
  }

  frame(now) {
    if (this.playing) {
      if (this.before !== null) this.time += Math.min((now - this.before) / 1000, 0.25) * Number(byId("speed").value);
      if (this.before !== null && now - this.before > SLOW && this.coarse < COARSE.length - 1) {
        this.coarse++;
        this.resize();
      }
      this.before = now;
      if (this.time >= this.span[1]) { this.time = this.span[1]; this.pause(); }
    }
    if (this.stage) {
      if (this.shown !== this.time) this.stage.setTime(this.time);
      this.control.look(this.time);
      this.stage.draw();
    }
    if (this.shown !== this.time) {
      for (const plot of this.plots) plot.setTime(this.time);
      byId("time").value = this.time;
      byId("clock").textContent = `${this.time.toFixed(3)} s`;
      const past = this.data.events.filter((event) => event.time <= this.time + 1e-9).length - 1;
      this.rows.forEach((row, k) => row.classList.toggle("now", k === past));
    } else for (const plot of this.plots) plot.setTime(this.time);
    this.tell();
    this.shown = this.time;
    this.drawn = (this.drawn ?? 0) + 1;
    if (this.playing) this.redraw();
  }
}

window.replay = new Replay();
const contents = byId("contents");
if (contents) {
  inflated(byId("blob").textContent).then((buffer) => {
    window.replay.show(unpack(JSON.parse(contents.textContent), buffer));
  }).catch((error) => {
    byId("trouble").textContent = `This page cannot be shown here: ${error.message}`;
    byId("trouble").hidden = false;
  });
} else follow(window.replay);
