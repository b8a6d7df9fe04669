"""Export of materials to USD as UsdPreviewSurface, which every application supports."""

from pathlib import Path
from typing import Any

from text2sim.exchange.files import save_picture
from text2sim.exchange.materials import ExportMaterial
from text2sim.exchange.openusd import openusd


class UsdMaterials:
    """The materials of a stage, each defined once.

    Args:
        stage: The stage.
        at: Path of the parent prim.
        textures: Folder for pictures, made when the first is written.

    Attributes:
        pictures: Path of each picture in the stage.
    """

    def __init__(self, stage: Any, at: str, textures: Path):
        self._stage, self._at, self._textures = stage, at, textures
        self._made: dict[ExportMaterial, Any] = {}
        self._holed: set[Path] = set()
        self.pictures: dict[Path, str] = {}

    def bind(self, prim: Any, material: ExportMaterial) -> None:
        """Bind a material to a prim."""
        if material not in self._made:
            self._made[material] = self._make(f"{self._at}/material_{len(self._made)}", material)
        openusd().UsdShade.MaterialBindingAPI.Apply(prim).Bind(self._made[material])

    def _make(self, path: str, material: ExportMaterial) -> Any:
        usd = openusd()
        kinds, shader = usd.Sdf.ValueTypeNames, usd.UsdShade.Shader
        material_prim = usd.UsdShade.Material.Define(self._stage, path)
        surface = shader.Define(self._stage, f"{path}/surface")
        surface.CreateIdAttr("UsdPreviewSurface")
        for name in ("roughness", "metallic", "opacity", "clearcoat"):
            surface.CreateInput(name, kinds.Float).Set(float(getattr(material, name)))
        color = surface.CreateInput("diffuseColor", kinds.Color3f)
        color.Set(usd.Gf.Vec3f(*material.color))
        if material.picture is not None:
            reader = shader.Define(self._stage, f"{path}/st")
            reader.CreateIdAttr("UsdPrimvarReader_float2")
            reader.CreateInput("varname", kinds.String).Set("st")
            texture = shader.Define(self._stage, f"{path}/picture")
            texture.CreateIdAttr("UsdUVTexture")
            texture.CreateInput("file", kinds.Asset).Set(usd.Sdf.AssetPath(self._picture(material.picture)))
            texture.CreateInput("sourceColorSpace", kinds.Token).Set("sRGB")
            for wrap in ("wrapS", "wrapT"):
                texture.CreateInput(wrap, kinds.Token).Set("repeat")
            texture.CreateInput("st", kinds.Float2).ConnectToSource(reader.CreateOutput("result", kinds.Float2))
            color.ConnectToSource(texture.CreateOutput("rgb", kinds.Float3))
            if material.picture in self._holed:
                surface.GetInput("opacity").ConnectToSource(texture.CreateOutput("a", kinds.Float))
                surface.CreateInput("opacityThreshold", kinds.Float).Set(0.5)
        material_prim.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", kinds.Token))
        return material_prim

    def _picture(self, source: Path) -> str:
        if source not in self.pictures:
            self._textures.mkdir(exist_ok=True)
            name = f"picture_{len(self.pictures)}.png"
            if save_picture(source, self._textures / name):
                self._holed.add(source)
            self.pictures[source] = f"./{self._textures.name}/{name}"
        return self.pictures[source]
