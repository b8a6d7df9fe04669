// Vectors, orientations (w, x, y, z) and matrices (column by column, as WebGL wants them).

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const long = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => times(a, 1 / (long(a) || 1));
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/** Right, up and ahead of a picture; +y is up in it when it looks straight down. */
function basis(pos, look, up) {
  const ahead = unit(minus(look, pos));
  let right = cross(ahead, up);
  if (long(right) < 1e-3) right = cross(ahead, [0, 1, 0]);
  right = unit(right);
  return [right, cross(right, ahead), ahead];
}

function viewMatrix(pos, look, up) {
  const [right, above, ahead] = basis(pos, look, up);
  return [right[0], above[0], -ahead[0], 0, right[1], above[1], -ahead[1], 0, right[2], above[2], -ahead[2], 0,
    -dot(right, pos), -dot(above, pos), dot(ahead, pos), 1];
}

function perspective(fov, aspect, near, far) {
  const f = 1 / Math.tan(fov / 2);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
}

function orthographic(half, near, far) {
  return [1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -2 / (far - near), 0, 0, 0, -(far + near) / (far - near), 1];
}

function product(a, b) {
  const made = new Array(16);
  for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++) {
    made[4 * j + i] = a[i] * b[4 * j] + a[i + 4] * b[4 * j + 1] + a[i + 8] * b[4 * j + 2] + a[i + 12] * b[4 * j + 3];
  }
  return made;
}

/** The pose of something at (p, q), whose frame is itself at (P, Q). */
function joinedPose(P, Q, p, q) {
  const [a, b, c, d] = Q, [w, x, y, z] = q;
  return [add(P, turned(Q, p)), [a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y,
    a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w]];
}

function turned(q, v) {
  const way = [q[1], q[2], q[3]], twist = times(cross(way, v), 2);
  return add(add(v, times(twist, q[0])), cross(way, twist));
}

/** Writes the matrix of a pose into an array. */
function writePose(array, at, pos, q) {
  const [w, x, y, z] = q;
  array[at] = 1 - 2 * (y * y + z * z); array[at + 1] = 2 * (x * y + w * z); array[at + 2] = 2 * (x * z - w * y);
  array[at + 4] = 2 * (x * y - w * z); array[at + 5] = 1 - 2 * (x * x + z * z); array[at + 6] = 2 * (y * z + w * x);
  array[at + 8] = 2 * (x * z + w * y); array[at + 9] = 2 * (y * z - w * x); array[at + 10] = 1 - 2 * (x * x + y * y);
  array[at + 12] = pos[0]; array[at + 13] = pos[1]; array[at + 14] = pos[2];
  array[at + 3] = array[at + 7] = array[at + 11] = 0; array[at + 15] = 1;
}

/** Rows before and after a time, and how far it is from the one to the other. */
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
