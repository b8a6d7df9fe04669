"""Export of a recorded run as a USD stage: z up, metres, a time sample for every recorded pose."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim import __version__
from text2sim.exchange.files import move_into_place, temporary_folder_beside
from text2sim.exchange.materials import ExportMaterial
from text2sim.exchange.openusd import openusd
from text2sim.exchange.scenery import Figure, Scenery, SceneryLink, SceneryPiece, keyframe_rows
from text2sim.exchange.usd_lights import add_lights
from text2sim.exchange.usd_materials import UsdMaterials
from text2sim.exchange.viewing import Track, camera_tracks
from text2sim.spec_schema.errors import MachineError, RunError

Array = NDArray[np.floating]

SUFFIXES = (".usdc", ".usda", ".usdz")
ROOT = "/run"
APERTURE = 24.0
"""Height of a picture on 35 mm film [mm], to which focal lengths refer."""
TENTHS = 0.01
"""A millimetre in tenths of the stage's unit (a metre), the unit of camera lenses in USD:
https://openusd.org/release/api/class_usd_geom_camera.html."""


def write_usd(folder: Path, path: Path, *, every: int = 1) -> dict[str, int]:
    """Write a recorded run as USD.

    Pictures go into the archive of a .usdz, or into `<name>_textures/` beside a .usdc or .usda.

    Args:
        folder: The run folder.
        path: The file, whose suffix selects the kind.
        every: Write every N-th recorded frame as a time sample, and the last.

    Returns:
        The numbers of bodies, frames and pictures.

    Raises:
        RunError: if nothing is recorded, or the file cannot be written.
        MachineError: if this machine lacks OpenUSD.
    """
    if path.suffix not in SUFFIXES:
        raise RunError(f"{path}: a USD file ends in {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}")
    usd = openusd()
    scenery = Scenery(folder, stride=every)
    with temporary_folder_beside(path) as place, _refusals(path):
        flat = place / (f"{path.stem}.usdc" if path.suffix == ".usdz" else path.name)
        textures = place / f"{path.stem}_textures"
        writer = _Writer(flat, scenery, textures)
        counts = writer.write()
        if path.suffix == ".usdz":
            archive = place / path.name
            if not usd.UsdUtils.CreateNewUsdzPackage(str(flat), str(archive)):
                raise RunError(f"{path}: OpenUSD could not make the archive")
            move_into_place(archive, path)
        else:
            if textures.is_dir():
                beside = path.parent / textures.name
                beside.mkdir(exist_ok=True)
                for picture in sorted(textures.iterdir()):
                    move_into_place(picture, beside / picture.name)
            move_into_place(flat, path)
    return counts


@contextmanager
def _refusals(path: Path) -> Iterator[None]:
    """Report errors of OpenUSD in writing: on a full disk it does not raise an `OSError`."""
    try:
        yield
    except openusd().Tf.ErrorException as error:
        message = str(error).strip().partition("\n")[0].rpartition(" : ")[2].strip("'")
        raise MachineError(f"{path}: OpenUSD cannot write it: {message}") from error


class _Writer:
    """Writes one stage."""

    def __init__(self, path: Path, scenery: Scenery, textures: Path) -> None:
        self._scenery, self._usd = scenery, openusd()
        self._name_of = self._usd.Tf.MakeValidIdentifier
        self._stage = self._usd.Usd.Stage.CreateNew(str(path))
        stage, film = self._stage, scenery.recording.film
        self._usd.UsdGeom.SetStageUpAxis(stage, self._usd.UsdGeom.Tokens.z)
        self._usd.UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        self._usd.UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
        self._rate = float(film["fps"])  # applications show whole time codes as frames
        stage.SetTimeCodesPerSecond(self._rate)
        stage.SetFramesPerSecond(self._rate)
        codes = self._codes(scenery.times)
        stage.SetStartTimeCode(codes[0])
        stage.SetEndTimeCode(codes[-1])
        root = self._usd.UsdGeom.Xform.Define(stage, ROOT)
        stage.SetDefaultPrim(root.GetPrim())
        root.GetPrim().SetMetadata("kind", "assembly")
        stage.GetRootLayer().comment = f"{scenery.recording.folder.name}, written by text2sim {__version__}"
        self._materials = UsdMaterials(stage, f"{ROOT}/materials", textures)
        self._taken: set[str] = set()
        """Paths of links of bodies that have several."""
        self._shapes: dict[tuple[Path, bool], str] = {}
        self._painted: dict[tuple[Path, ExportMaterial], str] = {}
        uses = Counter((piece.mesh, piece.material.two_sided) for link in scenery.links for piece in link.pieces)
        self._shared = {key for key, count in uses.items() if count > 1}

    def write(self) -> dict[str, int]:
        scenery, stage = self._scenery, self._stage
        for scope in ("bodies", "statics", "cameras", "lights", "materials"):
            self._usd.UsdGeom.Scope.Define(stage, f"{ROOT}/{scope}")
        links = Counter(link.body for link in scenery.links)
        bodies = {link.body for link in scenery.links if link.pieces} | {figure.body for figure in scenery.figures}
        for link in scenery.links:
            if link.body in bodies:
                self._add_link(link, single=links[link.body] == 1)
        for figure in scenery.figures:
            self._add_figure(figure)
        for name, track in camera_tracks(scenery.recording).items():
            self._add_camera(name, track)
        add_lights(stage, f"{ROOT}/lights", scenery.recording.film, self._name_of)
        stage.GetRootLayer().Save()
        return {"bodies": len(bodies), "frames": len(scenery.frames), "pictures": len(self._materials.pictures)}

    # --- contents --------------------------------------------------------------------

    def _add_link(self, link: SceneryLink, *, single: bool) -> None:
        path = self._body_path(link.body, link.body in self._scenery.recording.statics)
        if not single:
            self._xform(path, link.body)
            path = f"{path}/{self._name_of(link.name)}"
            while path in self._taken:  # `left-foot` and `left_foot` of a model file
                path += "_"
            self._taken.add(path)
        prim = self._xform(path, link.body if single else link.name)
        prim.SetCustomDataByKey("text2sim:body", link.body)
        prim.SetCustomDataByKey("text2sim:link", link.name)
        pos, quat = (values[:, link.row] for values in self._scenery.poses)
        self._animate(self._usd.UsdGeom.Xformable(prim), self._codes(self._scenery.times), pos, quat)
        if link.mass > 0:
            # Only the mass: a solver would move a rigid body of UsdPhysics away from the recorded poses.
            mass = self._usd.UsdPhysics.MassAPI.Apply(prim)
            mass.CreateMassAttr(link.mass)
            mass.CreateCenterOfMassAttr(self._usd.Gf.Vec3f(*link.com))
        for k, piece in enumerate(link.pieces):
            self._add_piece(f"{path}/shape_{k}", piece)

    def _add_piece(self, path: str, piece: SceneryPiece) -> None:
        key = piece.mesh, piece.material.two_sided
        if key in self._shared:
            shape = self._usd.UsdGeom.Xform.Define(self._stage, path)
            shape.GetPrim().GetReferences().AddInternalReference(self._painted_shape(piece.mesh, piece.material))
            shape.GetPrim().SetInstanceable(True)
        else:
            shape = self._mesh(path, *key)
            self._materials.bind(shape.GetPrim(), piece.material)
        if any(piece.pos) or abs(piece.quat[0]) != 1:
            shape.AddTranslateOp().Set(self._usd.Gf.Vec3d(*piece.pos))
            shape.AddOrientOp().Set(self._usd.Gf.Quatf(*piece.quat))

    def _painted_shape(self, mesh: Path, material: ExportMaterial) -> str:
        """The path of the class whose instances are all copies of a shape with one material.

        The material is bound inside the class, because not every reader supports materials of instances.
        """
        key = mesh, material
        if key not in self._painted:
            shape = self._shape(mesh, material.two_sided)
            path = f"{ROOT}/shapes/painted_{len(self._painted)}"
            self._stage.CreateClassPrim(path)
            prim = self._stage.DefinePrim(f"{path}/mesh")
            prim.GetReferences().AddInternalReference(f"{shape}/mesh")
            self._materials.bind(prim, material)
            self._painted[key] = path
        return self._painted[key]

    def _shape(self, mesh: Path, two_sided: bool) -> str:
        """The path of the class with a mesh, which is stored once."""
        key = mesh, two_sided
        if key not in self._shapes:
            self._stage.CreateClassPrim(f"{ROOT}/shapes")
            path = f"{ROOT}/shapes/shape_{len(self._shapes)}"
            self._stage.CreateClassPrim(path)
            self._mesh(f"{path}/mesh", mesh, two_sided)
            self._shapes[key] = path
        return self._shapes[key]

    def _mesh(self, path: str, mesh: Path, two_sided: bool) -> Any:
        shape = self._scenery.mesh(mesh)
        made = self._define_mesh(path, shape.faces, shape.uvs, two_sided)
        points = shape.vertices.astype(np.float32)
        made.CreatePointsAttr(self._usd.Vt.Vec3fArray.FromNumpy(points))
        made.CreateNormalsAttr(self._usd.Vt.Vec3fArray.FromNumpy(shape.normals.astype(np.float32)))
        made.CreateExtentAttr(_extent(points))
        return made

    def _define_mesh(self, path: str, faces: NDArray[np.integer], uvs: Array | None, two_sided: bool) -> Any:
        made = self._usd.UsdGeom.Mesh.Define(self._stage, path)
        made.CreateSubdivisionSchemeAttr(self._usd.UsdGeom.Tokens.none)
        made.CreateFaceVertexCountsAttr(self._usd.Vt.IntArray.FromNumpy(np.full(len(faces), 3, np.int32)))
        made.CreateFaceVertexIndicesAttr(self._usd.Vt.IntArray.FromNumpy(faces.astype(np.int32).ravel()))
        made.SetNormalsInterpolation(self._usd.UsdGeom.Tokens.vertex)
        made.CreateDoubleSidedAttr(two_sided)
        if uvs is not None:
            primvars = self._usd.UsdGeom.PrimvarsAPI(made.GetPrim())
            st = primvars.CreatePrimvar(
                "st", self._usd.Sdf.ValueTypeNames.TexCoord2fArray, self._usd.UsdGeom.Tokens.vertex
            )
            st.Set(self._usd.Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(uvs, np.float32)))
        return made

    def _add_figure(self, figure: Figure) -> None:
        path = self._body_path(figure.body, False)
        made: Any
        if figure.faces is not None:
            made = self._define_mesh(path, figure.faces, figure.uvs, figure.material.two_sided)
        else:
            made = self._usd.UsdGeom.Points.Define(self._stage, path)
            made.CreateWidthsAttr(self._usd.Vt.FloatArray(1, figure.spacing))
            made.SetWidthsInterpolation(self._usd.UsdGeom.Tokens.constant)
            made.CreateDisplayColorAttr([self._usd.Gf.Vec3f(*figure.material.color)])
        made.GetPrim().SetDisplayName(figure.body)
        made.GetPrim().SetCustomDataByKey("text2sim:body", figure.body)
        points, extent = made.CreatePointsAttr(), made.CreateExtentAttr()
        normals = None if figure.faces is None else made.CreateNormalsAttr()
        for code, frame in zip(self._codes(self._scenery.times), self._scenery.frames, strict=True):
            places = figure.points(int(frame))
            points.Set(self._usd.Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(places, np.float32)), code)
            extent.Set(_extent(places, figure.spacing / 2 if figure.faces is None else 0.0), code)
            if normals is not None:
                normals.Set(self._usd.Vt.Vec3fArray.FromNumpy(figure.normals(int(frame))), code)
        self._materials.bind(made.GetPrim(), figure.material)

    def _add_camera(self, name: str, track: Track) -> None:
        film, view = self._scenery.recording.film, track.views[0]
        made = self._usd.UsdGeom.Camera.Define(self._stage, f"{ROOT}/cameras/{self._name_of(name)}")
        made.GetPrim().SetDisplayName(name)
        width, height = film["resolution"]
        made.CreateVerticalApertureAttr(APERTURE * TENTHS)
        made.CreateHorizontalApertureAttr(APERTURE * TENTHS * width / height)
        focal = APERTURE / 2 / np.tan(np.radians(view.fov) / 2)
        made.CreateFocalLengthAttr(float(focal * TENTHS))
        made.CreateClippingRangeAttr((0.01, 10000.0))
        if view.aperture > 0:
            made.CreateFStopAttr(float(focal / 1000 / (2 * view.aperture)))
        codes = self._codes(track.times)
        self._set(made.CreateFocusDistanceAttr(), codes, np.array([row.focus for row in track.views]), float)
        self._animate(made, codes, *track.poses())

    # --- writing --------------------------------------------------------------------

    def _codes(self, times: Array) -> list[float]:
        return [float(round(t * self._rate, 9)) for t in times]

    def _animate(self, made: Any, codes: list[float], pos: Array, quat: Array) -> None:
        """Set the poses of a prim, without samples while it is at rest."""
        vector, turn = self._usd.Gf.Vec3d, self._usd.Gf.Quatf
        self._set(made.AddTranslateOp().GetAttr(), codes, pos, lambda row: vector(*row))
        self._set(made.AddOrientOp().GetAttr(), codes, quat, lambda row: turn(*row))

    def _set(self, attribute: Any, codes: list[float], values: Array, made_of: Callable[[Any], Any]) -> None:
        """Set the values of an attribute (n, ...), or a single one if it never changes."""
        rows = values.tolist()
        if not (values != values[0]).any():
            attribute.Set(made_of(rows[0]))
            return
        # Written to the layer, because a stage recomposes after every value.
        layer, path = self._stage.GetRootLayer(), attribute.GetPath()
        with self._usd.Sdf.ChangeBlock():
            for k in keyframe_rows(values):
                layer.SetTimeSample(path, codes[k], made_of(rows[k]))

    def _body_path(self, body: str, held: bool) -> str:
        """The path of a copy, below its body if that has copies."""
        base, bracket, _ = body.partition("[")
        path = f"{ROOT}/{'statics' if held else 'bodies'}/{self._name_of(base)}"
        if not bracket:
            return path
        self._xform(path, base)
        return f"{path}/{self._name_of(body.rstrip(']').replace('[', '_').replace(']', ''))}"

    def _xform(self, path: str, name: str) -> Any:
        prim = self._usd.UsdGeom.Xform.Define(self._stage, path).GetPrim()
        prim.SetDisplayName(name)
        return prim


def _extent(points: Array, margin: float = 0.0) -> Any:
    corners = np.array([points.min(axis=0) - margin, points.max(axis=0) + margin], np.float32)
    return openusd().Vt.Vec3fArray.FromNumpy(corners)
