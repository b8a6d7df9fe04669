"""The program that colours pixels: the light model of the engine's rasteriser, so that a preview looks like the film.

The engine draws colours with metallic 0.2 and roughness 0.8, and textures with 1 and 0.9, whatever the surface says.
"""

from typing import Any

import numpy as np

LIGHTS = 8
"""Most lights of a scene."""

_LINEAR = """
vec3 linear(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}
"""

VERTEX = """#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in mat4 place;   // one per copy, from here on
layout(location = 7) in vec4 tint;
uniform mat4 view;
out vec3 point;
out vec3 outward;
out vec2 at;
flat out vec4 color;
%s
void main() {
    vec4 world = place * vec4(position, 1.0);
    point = world.xyz;
    outward = mat3(place) * normal;
    at = uv;
    color = vec4(linear(tint.rgb), tint.a);   // here, for powers are what takes longest
    gl_Position = view * world;
}
""" % (_LINEAR,)  # noqa: UP031, braces are GLSL's

FRAGMENT = """#version 330 core
const float PI = 3.141592653589793;
in vec3 point;
in vec3 outward;
in vec2 at;
flat in vec4 color;
uniform vec3 eye;
uniform vec3 ambient;
uniform int lights;
uniform vec4 light_place[%d];   // w = 0: the direction it shines in; w = 1: where it stands
uniform vec3 light_color[%d];
uniform float roughness;
uniform float metallic;
uniform bool textured;
uniform sampler2D picture;
out vec4 pixel;
%s
vec3 reflected(vec3 n, vec3 v, vec3 l, vec3 dull, vec3 straight) {
    vec3 h = normalize(l + v);
    float nl = clamp(dot(n, l), 0.001, 1.0);
    float nv = clamp(abs(dot(n, v)), 0.001, 1.0);
    float nh = clamp(dot(n, h), 0.0, 1.0);
    float vh = clamp(dot(v, h), 0.0, 1.0);
    float away = 1.0 - vh;
    vec3 fresnel = straight + (1.0 - straight) * (away * away * away * away * away);
    float k = (roughness + 1.0) * (roughness + 1.0) / 8.0;
    float shadowed = nv / (nv * (1.0 - k) + k) * nl / (nl * (1.0 - k) + k);
    float alpha = roughness * roughness * roughness * roughness;
    float spread = nh * nh * (alpha - 1.0) + 1.0;
    float facing = alpha / (PI * spread * spread);
    return nl * ((1.0 - fresnel) * dull / PI + fresnel * (shadowed * facing / (4.0 * nl * nv + 0.001)));
}

void main() {
    vec4 base = color;
    if (textured) {
        vec4 texel = texture(picture, at);
        base = vec4(linear(texel.rgb), color.a * texel.a);
    }
    vec3 n = normalize(outward);
    vec3 v = normalize(eye - point);
    vec3 dull = base.rgb * 0.96 * (1.0 - metallic);
    vec3 straight = mix(vec3(0.04), base.rgb, metallic);
    vec3 sum = base.rgb * ambient;
    for (int i = 0; i < lights; i++) {
        vec3 way = light_place[i].w > 0.5 ? light_place[i].xyz - point : -light_place[i].xyz;
        float fall = light_place[i].w > 0.5 ? dot(way, way) : 1.0;
        sum += light_color[i] / fall * reflected(n, v, normalize(way), dull, straight);
    }
    pixel = clamp(vec4(pow(sum, vec3(1.0 / 2.2)), base.a), 0.0, 1.0);
}
""" % (LIGHTS, LIGHTS, _LINEAR)  # noqa: UP031, braces are GLSL's


class Shader:
    """The compiled program."""

    def __init__(self, gl: Any) -> None:
        from OpenGL.GL import shaders

        self._gl = gl
        self._program = shaders.compileProgram(
            shaders.compileShader(VERTEX, gl.GL_VERTEX_SHADER),
            shaders.compileShader(FRAGMENT, gl.GL_FRAGMENT_SHADER),
            validate=False,  # nothing is bound yet that it could be checked against
        )
        self._places: dict[str, int] = {}

    def use(self) -> None:
        """Draw with it from now on."""
        self._gl.glUseProgram(self._program)

    def light(self, ambient: Any, lights: list[tuple[tuple[float, ...], tuple[float, ...]]]) -> None:
        """Set the lights: each is (x, y, z, w) and (red, green, blue) times its strength; see the shader."""
        lights = lights[:LIGHTS]
        self._gl.glUniform3f(self._at("ambient"), *map(float, ambient))
        self._gl.glUniform1i(self._at("lights"), len(lights))
        if lights:
            places, colors = (np.array(rows, np.float32) for rows in zip(*lights, strict=True))
            self._gl.glUniform4fv(self._at("light_place"), len(lights), places)
            self._gl.glUniform3fv(self._at("light_color"), len(lights), colors)

    def look(self, view: np.ndarray, eye: Any) -> None:
        """Set the camera: the matrix from the world to the picture, shape (4, 4), and where it stands."""
        self._gl.glUniformMatrix4fv(self._at("view"), 1, True, view.astype(np.float32))
        self._gl.glUniform3f(self._at("eye"), *map(float, eye))

    def surface(self, *, textured: bool) -> None:
        """Set what the next draw is made of."""
        self._gl.glUniform1i(self._at("textured"), int(textured))
        self._gl.glUniform1f(self._at("metallic"), 1.0 if textured else 0.2)
        self._gl.glUniform1f(self._at("roughness"), 0.9036 if textured else 0.8)

    def _at(self, name: str) -> int:
        if name not in self._places:
            self._places[name] = self._gl.glGetUniformLocation(self._program, name)
        return self._places[name]
