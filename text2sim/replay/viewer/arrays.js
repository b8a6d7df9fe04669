// The arrays of the page: deflated, in base64.

async function readBlob() {
  const element = document.getElementById("blob");
  const text = atob(element.textContent.trim());
  element.remove();
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

const KINDS = { Float32Array, Uint32Array, Uint16Array, Int16Array, Int8Array };

/** Puts arrays in the place of what the page says of them, everywhere below `value`. */
function unpack(value, buffer) {
  if (Array.isArray(value)) return value.map((row) => unpack(row, buffer));
  if (value === null || typeof value !== "object") return value;
  if (value.type in KINDS && "at" in value) {
    const array = new KINDS[value.type](buffer, value.at, value.count);
    return "low" in value ? { array, low: value.low, step: value.step } : array;
  }
  return Object.fromEntries(Object.entries(value).map(([key, row]) => [key, unpack(row, buffer)]));
}

/** Points of one box as floats. */
function floats(points) {
  const made = new Float32Array(points.array.length);
  for (let i = 0; i < made.length; i++) made[i] = points.low[i % 3] + points.step[i % 3] * points.array[i];
  return made;
}

/** Where the links are at a time: calls back with number, position and orientation. */
function eachPose(links, t, call) {
  const [a, b, w] = around(links.times, t), n = links.count;
  const { array, low, step } = links.pos, quat = links.quat;
  for (let k = 0; k < n; k++) {
    const pos = [0, 0, 0], turn = [0, 0, 0, 0], i = 3 * (a * n + k), j = 3 * (b * n + k);
    for (let c = 0; c < 3; c++) {
      pos[c] = low[3 * k + c] + step[3 * k + c] * (array[i + c] * (1 - w) + array[j + c] * w);
    }
    const p = 4 * (a * n + k), q = 4 * (b * n + k);
    let side = 0, size = 0;
    for (let c = 0; c < 4; c++) side += quat[p + c] * quat[q + c];
    for (let c = 0; c < 4; c++) {
      turn[c] = quat[p + c] * (1 - w) + (side < 0 ? -1 : 1) * quat[q + c] * w;
      size += turn[c] * turn[c];
    }
    size = Math.sqrt(size) || 1;
    for (let c = 0; c < 4; c++) turn[c] /= size;
    call(k, pos, turn);
  }
}

/** Points of a body that deforms at a time, into an array. */
function deformed(figure, t, into) {
  const [a, b, w] = around(figure.times, t), n = 3 * figure.count, { array, low, step } = figure.points;
  for (let i = 0; i < n; i++) {
    into[i] = low[i % 3] + step[i % 3] * (array[a * n + i] * (1 - w) + array[b * n + i] * w);
  }
}

/** Normals of a surface, into an array: the larger a triangle, the more it counts. */
function writeNormals(points, faces, into) {
  into.fill(0);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (const k of [a, b, c]) { into[k] += x; into[k + 1] += y; into[k + 2] += z; }
  }
}
