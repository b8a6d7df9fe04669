"""Colours: names, `#rrggbb`, or three numbers."""

import re
from collections.abc import Sequence
from typing import Annotated

from pydantic import AfterValidator

from text2sim.spec_schema.errors import nearest
from text2sim.spec_schema.models.base import Fraction, Noun

# CSS names (https://www.w3.org/TR/css-color-4/#named-colors) as `name rrggbb`, followed by materials and other things
# with a typical colour.
_TABLE = """
aliceblue f0f8ff antiquewhite faebd7 aqua 00ffff aquamarine 7fffd4 azure f0ffff beige f5f5dc bisque ffe4c4
black 000000 blanchedalmond ffebcd blue 0000ff blueviolet 8a2be2 brown a52a2a burlywood deb887 cadetblue
5f9ea0 chartreuse 7fff00 chocolate d2691e coral ff7f50 cornflowerblue 6495ed cornsilk fff8dc crimson dc143c
cyan 00ffff darkblue 00008b darkcyan 008b8b darkgoldenrod b8860b darkgray a9a9a9 darkgreen 006400 darkgrey
a9a9a9 darkkhaki bdb76b darkmagenta 8b008b darkolivegreen 556b2f darkorange ff8c00 darkorchid 9932cc darkred
8b0000 darksalmon e9967a darkseagreen 8fbc8f darkslateblue 483d8b darkslategray 2f4f4f darkslategrey 2f4f4f
darkturquoise 00ced1 darkviolet 9400d3 deeppink ff1493 deepskyblue 00bfff dimgray 696969 dimgrey 696969
dodgerblue 1e90ff firebrick b22222 floralwhite fffaf0 forestgreen 228b22 fuchsia ff00ff gainsboro dcdcdc
ghostwhite f8f8ff gold ffd700 goldenrod daa520 gray 808080 green 008000 greenyellow adff2f grey 808080
honeydew f0fff0 hotpink ff69b4 indianred cd5c5c indigo 4b0082 ivory fffff0 khaki f0e68c lavender e6e6fa
lavenderblush fff0f5 lawngreen 7cfc00 lemonchiffon fffacd lightblue add8e6 lightcoral f08080 lightcyan e0ffff
lightgoldenrodyellow fafad2 lightgray d3d3d3 lightgreen 90ee90 lightgrey d3d3d3 lightpink ffb6c1 lightsalmon
ffa07a lightseagreen 20b2aa lightskyblue 87cefa lightslategray 778899 lightslategrey 778899 lightsteelblue
b0c4de lightyellow ffffe0 lime 00ff00 limegreen 32cd32 linen faf0e6 magenta ff00ff maroon 800000
mediumaquamarine 66cdaa mediumblue 0000cd mediumorchid ba55d3 mediumpurple 9370db mediumseagreen 3cb371
mediumslateblue 7b68ee mediumspringgreen 00fa9a mediumturquoise 48d1cc mediumvioletred c71585 midnightblue
191970 mintcream f5fffa mistyrose ffe4e1 moccasin ffe4b5 navajowhite ffdead navy 000080 oldlace fdf5e6 olive
808000 olivedrab 6b8e23 orange ffa500 orangered ff4500 orchid da70d6 palegoldenrod eee8aa palegreen 98fb98
paleturquoise afeeee palevioletred db7093 papayawhip ffefd5 peachpuff ffdab9 peru cd853f pink ffc0cb plum
dda0dd powderblue b0e0e6 purple 800080 rebeccapurple 663399 red ff0000 rosybrown bc8f8f royalblue 4169e1
saddlebrown 8b4513 salmon fa8072 sandybrown f4a460 seagreen 2e8b57 seashell fff5ee sienna a0522d silver c0c0c0
skyblue 87ceeb slateblue 6a5acd slategray 708090 slategrey 708090 snow fffafa springgreen 00ff7f steelblue
4682b4 tan d2b48c teal 008080 thistle d8bfd8 tomato ff6347 turquoise 40e0d0 violet ee82ee wheat f5deb3 white
ffffff whitesmoke f5f5f5 yellow ffff00 yellowgreen 9acd32

aluminium b8bcc0 amber ffbf00 asphalt 3b3d40 bone e3dac9 brass b5a642 brick 9c4a3c bronze cd7f32 cardboard
b58b5a charcoal 36454f clay b66a50 concrete 9a9a96 copper b87333 cork c69c6d cream fff3d6 emerald 50c878 grass
5a8f3c iron 6e6f72 lead 6c6f7a marble eceae4 mint 98e2c6 mustard d4a82a oak b98b52 pine d9b779 plaster e8e2d6
rubber 2b2b2d rust a8492a sand d8c193 skin e0ac8a slate 5f6b73 steel 8f979e stone 8c8880 terracotta c8643f
walnut 5c4033 water 4f8fbf wood b07d48
"""
_WORDS = _TABLE.split()
NAMED: dict[str, str] = dict(zip(_WORDS[::2], _WORDS[1::2], strict=True))
PALETTES: dict[str, tuple[str, ...]] = {
    name: tuple(f"#{digits}" for digits in text.split())
    for name, text in {
        # Okabe and Ito, https://jfly.uni-koeln.de/color/, without black
        "okabe_ito": "e69f00 56b4e9 009e73 f0e442 0072b2 d55e00 cc79a7",
        # Paul Tol, https://sronpersonalpages.nl/~pault/
        "tol_bright": "4477aa ee6677 228833 ccbb44 66ccee aa3377 bbbbbb",
        "tol_vibrant": "ee7733 0077bb 33bbee ee3377 cc3311 009988 bbbbbb",
        "tol_muted": "cc6677 332288 ddcc77 117733 88ccee 882255 44aa99 999933 aa4499",
        "tol_light": "77aadd ee8866 eedd88 ffaabb 99ddff 44bb99 bbcc33 aaaa00 dddddd",
        # Ramps of matplotlib in eight steps; cividis looks the same with nearly every kind of colour vision.
        "viridis": "440154 46327e 365c8d 277f8e 1fa187 4ac16d a0da39 fde725",
        "cividis": "00224e 1f3a6c 434e6c 62646f 7e7b78 9c9475 bfaf6d e5cc50",
    }.items()
}
"""Colours by palette, chosen to be distinguishable with colour-vision deficiencies."""
_HEX = re.compile(r"#([0-9a-fA-F]{6}|[0-9a-fA-F]{3})")


class ColorError(ValueError):
    """A word that is not a colour."""

    rule = "unknown-color"

    def __init__(self, word: str) -> None:
        super().__init__(
            f"unknown colour `{word[:40]}`; give a CSS name, a material, #rrggbb, #rgb, or three numbers from 0 to 1"
        )
        self.hint = nearest(word, NAMED)


def rgb(color: str | Sequence[float]) -> tuple[float, float, float]:
    """Return red, green and blue, each from 0 to 1, in sRGB.

    Args:
        color: A name, `#rrggbb`, `#rgb`, or three numbers, which are returned as they are.

    Raises:
        ColorError: If the name is unknown.
    """
    if not isinstance(color, str):
        red, green, blue = color
        return (float(red), float(green), float(blue))
    found = _HEX.fullmatch(color)
    digits = found[1] if found else NAMED.get(color.lower().replace(" ", "").replace("_", ""))
    if digits is None:
        raise ColorError(color)
    if len(digits) == 3:
        digits = "".join(2 * digit for digit in digits)
    red, green, blue = (int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4))
    return (red, green, blue)


def _known(word: str) -> str:
    rgb(word)
    return word


ColorName = Annotated[str, AfterValidator(_known), Noun("a colour", "colours")]
"""A CSS name, a material (`terracotta`, `steel`), or `#rrggbb`."""
Color = ColorName | tuple[Fraction, Fraction, Fraction]
"""A name, `#rrggbb`, or three numbers from 0 to 1 (sRGB)."""
