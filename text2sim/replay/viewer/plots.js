// A plot of each measure, with the ranges that its expectations forbid, and a line at the current time.

const number = (x) => x === null || x === undefined || Number.isNaN(x) ? "–" :
  Math.abs(x) >= 1e5 || (x !== 0 && Math.abs(x) < 1e-3) ? x.toExponential(2) : String(Number(x.toPrecision(4)));

const GOOD = "#009e73", BAD = "#d55e00", OPEN = "#808890", BLUE = "#0072b2";

class Plot {
  constructor(parent, measure, times, span, events, seek) {
    Object.assign(this, { measure, times, span, events });
    const figure = make("figure"), head = make("figcaption");
    head.append(make("span", measure.name, "name"), this.value = make("span", "", "value"));
    this.canvas = make("canvas");
    this.canvas.setAttribute("aria-label", "Plot of " + measure.name);
    figure.append(head, this.canvas);
    parent.append(figure);
    const go = (event) => {
      if (event.buttons !== 1 && event.type !== "pointerdown") return;
      const box = this.canvas.getBoundingClientRect();
      seek(span[0] + (event.clientX - box.left - LEFT) / (box.width - LEFT) * (span[1] - span[0]));
    };
    this.canvas.addEventListener("pointerdown", go);
    this.canvas.addEventListener("pointermove", go);
    let [low, high] = [Infinity, -Infinity];
    for (const y of measure.values) if (Number.isFinite(y)) { low = Math.min(low, y); high = Math.max(high, y); }
    if (low > high) [low, high] = [0, 1];
    const size = high - low || Math.abs(high) || 1;
    for (const bound of measure.bounds) for (const edge of [bound.low, bound.high]) {
      if (edge !== null && edge > low - 2 * size && edge < high + 2 * size) {
        this.marked = true;
        [low, high] = [Math.min(low, edge), Math.max(high, edge)];
      }
    }
    const margin = (high - low) * 0.08 || Math.abs(high) * 0.5 || 1;
    this.range = [low - margin, high + margin];
  }

  /** Draws everything except the line. */
  paint(ink, soft) {
    const { canvas, measure, times, range } = this, scale = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * scale;
    canvas.height = canvas.clientHeight * scale;
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    const [w, h] = [canvas.clientWidth, canvas.clientHeight];
    this.x = (t) => LEFT + (t - this.span[0]) / (this.span[1] - this.span[0] || 1) * (w - LEFT - 1);
    const y = (value) => h - 2 - (value - range[0]) / (range[1] - range[0]) * (h - 4);
    pen.font = "10px system-ui, sans-serif";
    pen.fillStyle = soft;
    pen.textAlign = "right";
    pen.fillText(number(range[1]), LEFT - 4, 9);
    pen.fillText(number(range[0]), LEFT - 4, h - 2);
    pen.strokeStyle = soft;
    pen.globalAlpha = 0.35;
    pen.strokeRect(LEFT - 0.5, 0.5, w - LEFT, h - 1);
    pen.setLineDash([2, 3]);
    for (const event of this.events.slice(0, 60)) line(pen, this.x(event.time), 0, this.x(event.time), h);
    for (const bound of measure.bounds) {
      pen.fillStyle = pen.strokeStyle = bound.ok === true ? GOOD : bound.ok === false ? BAD : OPEN;
      const [from, to] = [this.x(bound.from) - 1, this.x(bound.to) + 1];
      for (const [edge, far] of [[bound.low, h], [bound.high, 0]]) {
        if (edge === null) continue;
        const at = clamp(y(edge), 0, h);
        pen.globalAlpha = 0.16;
        if (bound.every) pen.fillRect(from, Math.min(at, far), to - from, Math.abs(far - at));
        pen.globalAlpha = 1;
        line(pen, from, at, to, at);
      }
    }
    pen.setLineDash([]);
    pen.globalAlpha = 1;
    pen.strokeStyle = BLUE;
    pen.lineWidth = 1.6;
    pen.beginPath();
    let drawn = false;
    measure.values.forEach((value, k) => {
      if (!Number.isFinite(value)) drawn = false;
      else if (drawn) pen.lineTo(this.x(times[k]), y(value));
      else { pen.moveTo(this.x(times[k]), y(value)); drawn = true; }
    });
    pen.stroke();
    this.base = pen.getImageData(0, 0, canvas.width, canvas.height);
    this.ink = ink;
  }

  setTime(t) {
    const [a, b, w] = around(this.times, t), { values, unit: words } = this.measure;
    this.value.textContent = `${number(values[a] * (1 - w) + values[b] * w)} ${words}`;
    if (!this.base) return;
    const pen = this.canvas.getContext("2d");
    pen.putImageData(this.base, 0, 0);
    pen.strokeStyle = this.ink;
    pen.lineWidth = 1;
    const at = Math.round(this.x(t)) + 0.5;
    line(pen, at, 0, at, this.canvas.clientHeight);
  }
}

const LEFT = 46;

function line(pen, x, y, u, v) {
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(u, v);
  pen.stroke();
}
