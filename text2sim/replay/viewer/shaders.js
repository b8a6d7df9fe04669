// Everything is lit by one lamp with a shadow, and by light from all around; what is far away fades into the background.

const COMMON = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
uniform mat4 camera, lamp;
uniform vec3 eye, toLamp, background, center;
uniform float radius;
uniform sampler2DShadow shadow;
vec3 linear(vec3 c) { return pow(c, vec3(2.2)); }
float lit(vec3 place, vec3 normal) {
  vec4 at = lamp * vec4(place + normal * radius * 0.004, 1.0);
  vec3 spot = at.xyz * 0.5 + 0.5;
  if (any(lessThan(spot, vec3(0.0))) || any(greaterThan(spot, vec3(1.0)))) return 1.0;
  float sum = 0.0;
  for (int i = -1; i <= 1; i++) for (int j = -1; j <= 1; j++)
    sum += texture(shadow, vec3(spot.xy + vec2(i, j) * 1.2 / 2048.0, spot.z - 0.0012));
  return sum / 9.0;
}
vec3 shade(vec3 place, vec3 normal, vec3 color, float rough, float metal) {
  vec3 back = normalize(eye - place);
  float facing = max(dot(normal, toLamp), 0.0), open = facing > 0.0 ? lit(place, normal) : 0.0;
  vec3 around = mix(vec3(0.34, 0.33, 0.32), vec3(0.62, 0.65, 0.7), normal.z * 0.5 + 0.5);
  vec3 base = color * (1.0 - 0.75 * metal), gloss = mix(vec3(0.04), color, metal);
  vec3 middle = normalize(toLamp + back);
  float power = 2.0 / max(rough * rough * rough, 0.002);
  float glint = pow(max(dot(normal, middle), 0.0), power) * (power + 8.0) / 25.0 * facing * open;
  float rim = pow(1.0 - max(dot(normal, back), 0.0), 5.0);
  vec3 mirrored = mix(vec3(0.25), vec3(0.95), smoothstep(-0.4, 0.7, reflect(-back, normal).z));
  return base * (around + 1.05 * facing * open) + gloss * glint * (1.0 - rough * 0.7)
    + mirrored * (gloss + (1.0 - gloss) * rim * 0.6 * (1.0 - rough)) * mix(0.35, 1.0, metal) * (1.0 - 0.5 * rough);
}
vec3 shown(vec3 light, vec3 place) {
  vec3 tone = pow(1.0 - exp(-1.15 * light), vec3(1.0 / 2.2));
  return mix(tone, background, smoothstep(1.8, 4.6, distance(place, center) / radius));
}`;

const SHADERS = {
  mesh: [`${COMMON}
layout(location = 0) in vec3 point;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in mat4 pose;
layout(location = 7) in vec4 color;
layout(location = 8) in vec4 surface;
out vec3 place, facing;
out vec2 spot;
out vec4 paint;
flat out vec4 kind;
void main() {
  vec4 at = pose * vec4(point, 1.0);
  place = at.xyz; facing = mat3(pose) * normal; spot = uv; paint = color; kind = surface;
  gl_Position = camera * at;
}`, `
in vec3 place, facing;
in vec2 spot;
in vec4 paint;
flat in vec4 kind;
uniform sampler2D picture;
uniform bool dressed;
out vec4 pixel;
void main() {
  vec3 normal = normalize(facing);
  if (!gl_FrontFacing) normal = -normal;
  vec3 color = dressed ? texture(picture, vec2(spot.x, 1.0 - spot.y)).rgb : paint.rgb;
  color = linear(color);
  if (kind.w > 0.5) color = mix(color, vec3(1.0, 0.5, 0.03), 0.35);
  vec3 light = shade(place, normal, color, kind.x, kind.y);
  pixel = vec4(shown(light, place), paint.a);
}`],
  number: ["mesh", `
flat in vec4 kind;
out vec4 pixel;
void main() {
  float n = kind.z + 1.0;
  pixel = vec4(mod(n, 256.0), mod(floor(n / 256.0), 256.0), floor(n / 65536.0), 255.0) / 255.0;
}`],
  ball: [`${COMMON}
layout(location = 0) in vec3 point;
uniform float size, pixels;
out vec3 place;
flat out float shadeOf;
void main() {
  place = point;
  shadeOf = 0.86 + 0.28 * fract(float(gl_VertexID) * 0.618);  // which tells grains apart
  gl_Position = camera * vec4(point, 1.0);
  gl_PointSize = max(size * pixels / gl_Position.w, 1.5);
}`, `
in vec3 place;
flat in float shadeOf;
uniform vec4 paint, kind;
uniform vec3 right, above;
uniform bool numbered;
out vec4 pixel;
void main() {
  vec2 at = gl_PointCoord * 2.0 - 1.0;
  float deep = 1.0 - dot(at, at);
  if (deep < 0.0) discard;
  if (numbered) {
    float n = kind.z + 1.0;
    pixel = vec4(mod(n, 256.0), mod(floor(n / 256.0), 256.0), floor(n / 65536.0), 255.0) / 255.0;
    return;
  }
  vec3 normal = normalize(right * at.x - above * at.y + normalize(eye - place) * sqrt(deep));
  vec3 color = linear(paint.rgb) * shadeOf;
  if (kind.w > 0.5) color = mix(color, vec3(1.0, 0.5, 0.03), 0.35);
  pixel = vec4(shown(shade(place, normal, color, kind.x, kind.y), place), paint.a);
}`],
  touch: [`${COMMON}
layout(location = 0) in vec3 point;
layout(location = 1) in float strength;
uniform float pixels;
void main() {
  gl_Position = camera * vec4(point, 1.0);
  gl_PointSize = (4.0 + 11.0 * sqrt(strength)) * pixels;
}`, `
out vec4 pixel;
void main() {
  float away = length(gl_PointCoord * 2.0 - 1.0);
  if (away > 1.0) discard;
  pixel = away > 0.72 ? vec4(1.0, 1.0, 1.0, 0.9) : vec4(0.84, 0.27, 0.0, 0.92);
}`],
  shade: [`#version 300 es
layout(location = 0) in vec3 point;
layout(location = 3) in mat4 pose;
uniform mat4 lamp;
void main() { gl_Position = lamp * pose * vec4(point, 1.0); }`, `
precision lowp float;
void main() {}`],
  spot: [`#version 300 es
layout(location = 0) in vec3 point;
uniform mat4 lamp;
uniform float size;
void main() { gl_Position = lamp * vec4(point, 1.0); gl_PointSize = size; }`, `
precision lowp float;
void main() {}`],
};

function compile(gl, name) {
  let [vertex, fragment] = SHADERS[name];
  if (vertex in SHADERS) vertex = SHADERS[vertex][0];
  const head = vertex.startsWith(COMMON) ? COMMON : "#version 300 es";
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, head + fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(name + ": " + gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(name + ": " + gl.getProgramInfoLog(program));
  const places = {};
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
    const { name: uniform } = gl.getActiveUniform(program, i);
    places[uniform] = gl.getUniformLocation(program, uniform);
  }
  return { program, places };
}
