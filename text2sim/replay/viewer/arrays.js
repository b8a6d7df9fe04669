// The arrays of a scene: deflated, in base64.

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

async function inflated(base64) {
  const text = atob(base64.trim());
  const packed = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

const KINDS = { Float32Array, Uint32Array, Uint16Array, Int16Array, Int8Array };

/** Replaces the descriptions of arrays below `value` by the arrays. */
function unpack(value, buffer) {
  if (Array.isArray(value)) return value.map((row) => unpack(row, buffer));
  if (value === null || typeof value !== "object") return value;
  if (value.type in KINDS && "at" in value) {
    const array = new KINDS[value.type](buffer, value.at, value.count);
    return "low" in value ? { array, low: value.low, step: value.step } : array;
  }
  return Object.fromEntries(Object.entries(value).map(([key, row]) => [key, unpack(row, buffer)]));
}

/** Rows before and after a time, and the weight of the latter. */
function around(times, t) {
  let low = 0, high = times.length - 1;
  if (high < 0 || t <= times[0]) return [0, 0, 0];
  if (t >= times[high]) return [high, high, 0];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  return [low, high, (t - times[low]) / (times[high] - times[low])];
}

/** Points of one box as floats. */
function floats(points) {
  return Float32Array.from(points.array, (x, i) => points.low[i % 3] + points.step[i % 3] * x);
}

/** Poses of all links at a time, as matrices. */
function posesAt(links, t) {
  const [a, b, w] = around(links.times, t), n = links.count, { array, low, step } = links.pos;
  const turn = (frame, k) => new THREE.Quaternion(links.quat[4 * (frame * n + k) + 1], links.quat[4 * (frame * n + k) + 2],
    links.quat[4 * (frame * n + k) + 3], links.quat[4 * (frame * n + k)]).normalize();
  return Array.from({ length: n }, (_, k) => {
    const place = (c) => {
      const [before, after] = [array[3 * (a * n + k) + c], array[3 * (b * n + k) + c]];
      return low[3 * k + c] + step[3 * k + c] * (before * (1 - w) + after * w);
    };
    return new THREE.Matrix4().compose(new THREE.Vector3(place(0), place(1), place(2)), turn(a, k).slerp(turn(b, k), w),
      new THREE.Vector3(1, 1, 1));
  });
}

/** The matrix of a pose: metres, and a quaternion (w, x, y, z). */
function matrixOf({ pos, quat: [w, x, y, z] }) {
  return new THREE.Matrix4().compose(new THREE.Vector3(...pos), new THREE.Quaternion(x, y, z, w), new THREE.Vector3(1, 1, 1));
}

/** Writes the points of a deformable body at a time into an array. */
function deformed(figure, t, into) {
  const [a, b, w] = around(figure.times, t), n = 3 * figure.count, { array, low, step } = figure.points;
  for (let i = 0; i < n; i++) into[i] = low[i % 3] + step[i % 3] * (array[a * n + i] * (1 - w) + array[b * n + i] * w);
}
