"""Deformable bodies: bending surfaces, grains, and liquids with a surface that is rebuilt for every frame."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.assets.surface import signed_volumes
from text2sim.recording.film_record import SoftPart, SurfaceLook
from text2sim.recording.vectors import rotate_back
from text2sim.rendering.decorating import Layer, decorated
from text2sim.rendering.finishes import drawn_finish, finish_of, material, needs_uvs
from text2sim.rendering.grains import Grains
from text2sim.rendering.meshes import RenderMesh, boxed_uvs
from text2sim.rendering.particle_surface import liquid_surface
from text2sim.rendering.rigid import read_picture
from text2sim.rendering.shapes import filtering, mesh_shape, shaded
from text2sim.rendering.tears import Tears, Torn, nearest, torn_at
from text2sim.rendering.tessellation import Tessellation
from text2sim.rendering.water import absorption, clear_liquid
from text2sim.rendering.wetting import Wall, creased, cut_off, wetted
from text2sim.templates.shading import LETS_GO, Shell, part_of_triangles, smooth_normals
from text2sim.templates.soft_states import SoftStates
from text2sim.templates.streams import flowing

Array = NDArray[np.floating]
Around = tuple[int, int, float]

TORN = "rubber"
"""Finish of torn faces."""
DEPTHS = 0.6
"""Length of the way [edges of a cube of its volume] on which light takes on the colour of a clear liquid."""


class SoftSurface:
    """A body with a mesh; both sides of cloth are visible.

    Args:
        name: Name of its shape.
        part: The body.
        at_rest: Its vertices at rest [m], shape (n, 3).
        arrays: Its triangles and texture coordinates.
        texture_scale: Factor on the lengths that textures of finishes cover.
        particles: Its particles at rest [m]; its vertices if None.
    """

    def __init__(
        self,
        name: str,
        part: SoftPart,
        at_rest: Array,
        arrays: dict[str, Array],
        texture_scale: float = 1.0,
        particles: Array | None = None,
    ):
        self.name, look = name, part.look
        shell = Shell(at_rest, arrays["faces"])
        self._shell = shell
        # As in the preview, triangles that would span a tear are dropped.
        tears = part.kind == "soft" and part.row["solver"] == "mpm"
        uvs = arrays.get("uvs")
        uvs = uvs[shell.sources].astype(float) if uvs is not None and len(uvs) == len(at_rest) else None
        picture = None if look.picture is None or uvs is None else read_picture(look.picture)
        self._own: NDArray[np.integer] = shell.sources
        self._faces = shell.faces.astype(np.int64)
        self._corners: NDArray[np.integer] = np.arange(len(shell.sources))
        uvs = None if uvs is None else self._unrolled(uvs)
        upright = rotate_back(np.array(part.row.get("quat", (1.0, 0, 0, 0))), at_rest)  # patterns lie in its own frame
        layer, textured = None, any(needs_uvs(one.finish) for one in (look, *filter(None, part.parts)))
        if picture is None and look.decoration is not None:
            flat = self._metric(upright, uvs) if part.kind == "cloth" and uvs is not None else None
            uvs, layer = self._decorated(upright, flat, look, textured=textured)
        elif picture is None and textured:
            uvs = self._metric(upright, uvs)
        self._finer = None
        if part.kind == "cloth":
            places = np.unique(np.round(at_rest, 7), axis=0, return_inverse=True)[1].ravel()
            self._finer = Tessellation(self._faces, places[self._own])
            uvs = None if uvs is None else self._finer.between(uvs)
        self._uvs = uvs
        rest: dict[str, Any] = {"two_sided": part.kind == "cloth", "texture_scale": texture_scale}
        printed = picture is not None or layer is not None
        kept = np.ones(len(self._faces), bool)
        if is_clear(part.kind, look, printed=printed):
            kept = ~hollows(at_rest, arrays["faces"])
            rest["two_sided"] = True  # what is painted on a clear skin shows from within, too
        self._coats = [Coat(kept, part.kind, look, picture, layer, **rest)]
        if part.regions is not None:
            placed = np.asarray(part.row["pos"]), np.asarray(part.row["quat"])
            owner = part_of_triangles(part.regions, at_rest, arrays["faces"], *placed)
            own = np.isin(owner, [k for k, one in enumerate(part.parts) if one is not None], invert=True)
            self._coats[0].faces = kept & own
            self._coats += [
                Coat(kept & (owner == k), part.kind, one, **rest)
                for k, one in enumerate(part.parts)
                if one is not None and (owner == k).any()
            ]
        self.is_clear = any(coat.is_clear for coat in self._coats)
        self._gap, self._tears = LETS_GO * float(part.row["spacing"]), None
        if tears:
            self._tears = Tears(at_rest, at_rest if particles is None else particles, float(part.row["spacing"]))

    def whole(self, vertices: Array, particles: Array, torn: Torn = None) -> NDArray[np.bool_]:
        """Return which triangles have not torn, shape (f,).

        Particles of one piece are below them, and their edges are not too long.

        Args:
            vertices: Its vertices [m].
            particles: Its particles [m].
            torn: Which of its particles have torn; None if its material knows of no tears.
        """
        if self._tears is None:
            return np.ones(len(self._faces), bool)
        held = self._tears.held(vertices, particles, torn)
        return self._shell.whole(vertices, self._gap) & held[self._own][self._faces].all(axis=1)

    def _inside(
        self, vertices: Array, particles: Array, torn: Torn, whole: NDArray[np.bool_], bsdf: Any
    ) -> dict[str, Any]:
        """Return what shows where its skin has torn: a surface just below it, with the colour of the nearest skin.

        Args:
            vertices: Its vertices [m].
            particles: Its particles [m].
            torn: Which of its particles have torn, or None.
            whole: Which of its triangles have not torn.
            bsdf: Material instead of that of torn faces.
        """
        assert self._tears is not None
        inner, faces = self._tears.inside(particles, torn)
        if not len(faces):
            return {}
        paint = np.zeros((len(self._own), 3))
        for coat in self._coats:
            paint[self._faces[coat.faces].ravel()] = coat.colors[0]
        skin = np.unique(self._faces[whole]) if whole.any() else np.arange(len(self._own))
        colors = paint[skin[nearest(vertices[self._own[skin]], inner)]]
        normals, name = smooth_normals(inner[faces], faces.ravel(), len(inner)), f"{self.name}_inside"
        return {name: mesh_shape(name, bsdf or material(TORN), inner, faces, normals, colors=colors)}

    def _decorated(
        self, at_rest: Array, flat: Array | None, look: SurfaceLook, *, textured: bool
    ) -> tuple[Array, Layer]:
        """Return texture coordinates in metres for a pattern, and the layer, which deforms with the body.

        Args:
            at_rest: Vertices at rest [m], turned as in the body's own frame.
            flat: Their positions in the flat cloth [m].
            look: The look, with the pattern.
            textured: Whether a finish of the body has a texture, which uses the same texture coordinates.
        """
        assert look.decoration is not None
        whole = RenderMesh(at_rest[self._own], self._faces, self._shell.normals(at_rest)[self._corners], flat)
        laid, layer, corners = decorated(whole, look.decoration, look.color, np.eye(3), textured=textured)
        self._faces, self._own, self._corners = laid.faces, self._own[corners], self._corners[corners]
        assert laid.uvs is not None
        return laid.uvs, layer

    def _unrolled(self, uvs: Array) -> Array:
        """Return texture coordinates, shape (n, 2), whose u goes on to 1 at the seam of a band, where it fell to 0."""
        u = uvs[self._faces, 0]
        early = (np.ptp(u, axis=1) > 0.5)[:, None] & (u < 0.5)
        if u.max() > 1 - 1e-6 or not early.any():
            return uvs
        again, index = np.unique(self._faces[early], return_inverse=True)
        self._faces = self._faces.copy()
        self._faces[early] = len(uvs) + index
        self._own, self._corners = np.r_[self._own, self._own[again]], np.r_[self._corners, again]
        return np.concatenate([uvs, uvs[again] + (1, 0)])

    def _metric(self, at_rest: Array, uvs: Array | None) -> Array:
        """Return texture coordinates in metres of the body at rest."""
        if uvs is not None:
            a, b, c = self._faces.T
            own, ends = at_rest[self._own], np.concatenate([np.stack([a, b]), np.stack([b, c])], axis=1)
            long = ((own[ends[0]] - own[ends[1]]) ** 2).sum(axis=1)
            # Least-squares fit of the squared lengths of u and v to the edges: a sheet need not be square.
            squares = np.linalg.lstsq((uvs[ends[0]] - uvs[ends[1]]) ** 2, long, rcond=None)[0]
            return uvs * np.sqrt(np.maximum(squares, 1e-12))
        whole = RenderMesh(at_rest[self._own], self._faces, np.zeros((len(self._own), 3)))
        # The normals are used to store the index of the original vertex of each corner.
        whole = RenderMesh(
            whole.vertices, whole.faces, np.repeat(np.arange(len(self._own), dtype=float)[:, None], 3, axis=1)
        )
        laid = boxed_uvs(whole)
        corners = laid.normals[:, 0].astype(int)
        self._faces, self._own, self._corners = laid.faces, self._own[corners], self._corners[corners]
        assert laid.uvs is not None
        return laid.uvs

    def shapes(
        self, vertices: Array, particles: Array, bsdf: Any = None, *, clear: bool = False, torn: Torn = None
    ) -> dict[str, Any]:
        """Return the mesh of its clear or of its other parts.

        Args:
            vertices: Its vertices [m].
            particles: Its particles [m].
            torn: Which of its particles have torn, or None.
            bsdf: Material instead of its own.
            clear: Whether only clear parts are returned, or only others.
        """
        normals, whole = self._shell.normals(vertices)[self._corners], self.whole(vertices, particles, torn)
        places, faces = vertices[self._own], self._faces
        if self._finer is not None:
            places, faces, normals = self._finer.vertices(places), self._finer.faces, self._finer.unit(normals)
        found = {}
        for k, coat in enumerate(self._coats):
            if coat.is_clear != clear or not (drawn := coat.faces & whole).any():
                continue
            color, shade = (np.broadcast_to(c, (len(places), 3)) for c in coat.colors)
            name = f"{self.name}_{k}"
            shown = faces[drawn if self._finer is None else self._finer.each(drawn)]
            found[name] = mesh_shape(
                name, bsdf or coat.bsdf, places, shown, normals, colors=color, shades=shade, uvs=self._uvs
            )
        open_ = any((coat.faces & ~whole).any() for coat in self._coats if not coat.is_clear)
        if open_ and not clear:
            found |= self._inside(vertices, particles, torn, whole, bsdf)
        return found


class Coat:
    """The triangles of a surface that share a look.

    Args:
        faces: Which triangles, shape (f,).
        kind: Kind of the body.
        look: The look.
        picture: Picture in place of its colour.
        layer: Layer over its colour.
        rest: Arguments of `material`.
    """

    def __init__(
        self,
        faces: NDArray[np.bool_],
        kind: str,
        look: SurfaceLook,
        picture: Array | None = None,
        layer: Layer | None = None,
        **rest: Any,
    ):
        self.faces = faces
        self.is_clear = is_clear(kind, look, printed=picture is not None or layer is not None)
        finish = drawn_finish(look.finish, look.color, look.opacity) if self.is_clear else look.finish
        opacity = 1.0 if finish_of(look.finish).kind != "solid" else look.opacity
        self.bsdf = material(finish, opacity=opacity, picture=picture, layer=layer, **rest)
        color, shade = shaded(look.color, finish)
        self.colors = (color, filtering(color, opacity)) if self.is_clear else (color, shade)


def is_clear(kind: str, look: SurfaceLook, *, printed: bool = False) -> bool:
    """Return whether a surface is drawn as a clear skin, which does not refract; a veil is not.

    Args:
        kind: Kind of the body.
        look: Its look.
        printed: Whether a picture or pattern lies on it.
    """
    clear = finish_of(drawn_finish(look.finish, look.color, look.opacity)).kind == "clear"
    return clear and not printed and not (kind == "cloth" and needs_uvs(look.finish))


def hollows(vertices: Array, faces: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which triangles, shape (f,), bound a cavity inside: a core that fills it has the same surface."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    a, b, c = faces.T.astype(np.int64)
    joined = coo_array((np.ones(2 * len(a)), (np.r_[a, b], np.r_[b, c])), shape=(len(vertices),) * 2)
    group = connected_components(joined, directed=False)[1][a]
    return (np.bincount(group, signed_volumes(vertices[faces])) < 0)[group]


class LiquidSurface:
    """Particles with a surface around all of them.

    A clear liquid refracts and absorbs light, see `water.py`. It has its colour where it is about half as deep as a
    cube of its volume is high, is darker where it is deeper, and almost colourless where it is thin. One with the
    finish of something solid has it where it is thinner, too, the nearer its opacity is to 1: syrup, honey.
    """

    def __init__(self, name: str, part: SoftPart):
        look = part.look
        self.name, self._spacing = name, float(part.row["spacing"])
        self.is_clear = look.opacity < 1 or is_clear(part.kind, look)
        self._color, self._shade = shaded(look.color, "smooth")
        if self.is_clear:
            first, end = part.row["points"]
            depth = DEPTHS * self._spacing * (end - first) ** (1 / 3)
            if finish_of(look.finish).kind == "solid":
                depth *= min(2 * (1 - look.opacity), 1.0)
            self._shade = absorption(1 - look.opacity * (1 - self._color), depth)
        self.bsdf = clear_liquid() if self.is_clear else material("smooth", two_sided=True)

    def shape(self, points: Array, walls: Sequence[Wall] = ()) -> Callable[[Any], Any] | None:
        """Return a factory of the surface that takes a material; None without a surface.

        Args:
            points: Positions of its particles [m].
            walls: Rigid surfaces that it may touch.
        """
        wetting = wetted(points, self._spacing, walls)
        vertices, faces = liquid_surface(wetting.points, self._spacing / 2)
        if not len(faces):
            return None
        if len(wetting.points) > len(points):
            vertices, on = cut_off(vertices, wetting, self._spacing)
            vertices, faces = creased(vertices, faces, on)
        normals = smooth_normals(vertices[faces], faces.ravel(), len(vertices))
        colors, shades = (np.broadcast_to(c, vertices.shape) for c in (self._color, self._shade))
        return lambda bsdf: mesh_shape(self.name, bsdf, vertices, faces, normals, colors=colors, shades=shades)


class SoftBodies:
    """All deformable bodies.

    Args:
        parts: The bodies.
        states: Their recorded states.
        texture_scale: Factor on the lengths that textures of finishes cover.
    """

    def __init__(self, parts: list[SoftPart], states: SoftStates, texture_scale: float = 1.0):
        self._states, self._figures = states, []
        self._mouths: list[Array | None] = []
        for k, part in enumerate(parts):
            if not part.look.visible or part.look.opacity <= 0:
                continue
            name = f"soft{k}"
            with np.load(part.geometry) as file:
                arrays = dict(file)
            self._mouths.append(arrays["rest"] if part.row.get("stream") else None)
            if "faces" in arrays:
                start = (0, 0, 0.0)
                figure: Any = SoftSurface(
                    name, part, self._places(part, start), arrays, texture_scale, self._particles(part, start)
                )
            else:
                figure = LiquidSurface(name, part) if part.kind == "liquid" else Grains(name, part)
            self._figures.append((part, figure))

    @property
    def has_liquids(self) -> bool:
        """Whether any body is a liquid."""
        return any(isinstance(figure, LiquidSurface) for _, figure in self._figures)

    @property
    def has_skins(self) -> bool:
        """Whether any part of a body is a clear skin; see `trace`."""
        return any(figure.is_clear for _, figure in self._figures if isinstance(figure, SoftSurface))

    def shapes(self, around: Around, bsdf: Any = None, *, clear: bool = False) -> dict[str, Any]:
        """Return the shapes of all clear or of all other parts between two recorded frames, without liquids.

        Args:
            around: The two frames, and the fraction between them.
            bsdf: Material instead of their own.
            clear: Whether only clear parts are returned, or only others.
        """
        found: dict[str, Any] = {}
        for part, figure, points in self._drawn(around):
            if isinstance(figure, SoftSurface) and (figure.is_clear or not clear):
                particles, torn = self._particles(part, around), torn_at(self._states, part.row, around)
                found |= figure.shapes(points, particles, bsdf, clear=clear, torn=torn)
            elif isinstance(figure, Grains) and not clear:
                found |= figure.shapes(points, bsdf)
        return found

    def liquids(self, around: Around, walls: Sequence[Wall]) -> list[tuple[LiquidSurface, Callable[[Any], Any]]]:
        """Return the liquids between two recorded frames, and factories of their shapes that take a material.

        Args:
            around: The two frames, and the fraction between them.
            walls: Rigid surfaces that liquids may touch.
        """
        found = []
        for _, figure, points in self._drawn(around):
            if isinstance(figure, LiquidSurface) and (make := figure.shape(points, walls)) is not None:
                found.append((figure, make))
        return found

    def _drawn(self, around: Around) -> Iterator[tuple[SoftPart, Any, Array]]:
        """Yield bodies of which something is drawn, and their points [m]."""
        for (part, figure), mouth in zip(self._figures, self._mouths, strict=True):
            points = self._places(part, around)
            if mouth is not None:
                points = points[flowing(points, mouth, part.row["spacing"])]
            if len(points):
                yield part, figure, points

    def _particles(self, part: SoftPart, around: Around) -> Array:
        return self._states.at("soft_points", around)[slice(*part.row["points"])].astype(float)

    def _places(self, part: SoftPart, around: Around) -> Array:
        name, columns = ("soft_points", "points") if part.row["surface"] is None else ("soft_surface", "surface")
        return self._states.at(name, around)[slice(*part.row[columns])].astype(float)
