"""Materials and looks of bodies."""

from typing import Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import (
    Bool,
    Density,
    Fraction,
    Integer,
    Length,
    Mass,
    Model,
    NonNegative,
    Positive,
    Real,
)
from text2sim.spec_schema.models.colors import Color, ColorName

DENSITY = 1000.0
"""Density [kg/m3] of rigid bodies whose material gives neither density nor mass."""

LEAST_FRICTION = 0.01
"""Smallest coefficient that the engine takes between rigid bodies."""


class Material(Model):
    """Mass and contact properties of a rigid body."""

    density: Density | None = DENSITY
    """Density [kg/m3]; unset if `mass` is given."""
    mass: Mass | None = None
    """Mass [kg] of one copy, instead of `density`."""
    friction: Real = Field(default=0.5, ge=LEAST_FRICTION, le=5.0)
    """Coulomb coefficient. For a pair of bodies the larger value applies, unless `scene.contact.pairs` gives one. For
    liquids 0.01 counts as none."""
    rolling_friction: Real = Field(default=0.0, ge=0.0, le=1.0)
    """Rolling resistance [m]: the torque is this length times the normal force; of a pair, the larger value applies. A
    ball or wheel of radius r with a coefficient of rolling resistance c (0.01 for a billiard ball) needs c r; of that a
    half to two thirds acts with a pyramidal `friction_cone`. Cloth and soft bodies do not resist rolling: let a
    `damping` of the free mount of a ball stop it there."""
    torsional_friction: Real = Field(default=0.0, ge=0.0, le=1.0)
    """Resistance [m] to spin about the contact normal, applied like `rolling_friction`: two thirds of `friction` times
    the radius of the contact patch."""
    restitution: Real | None = Field(default=None, ge=0.0, le=0.995)
    """Coefficient of restitution (speed after over speed before) between two bodies of this material, or between one
    and a static that has none. It requires a short time step. Between unequal bodies the damping ratio is the mean."""
    touch_soft: Bool = True
    """Whether cloth, grains, liquids and soft bodies (but `fem`) collide with it; false for a hook or rod that only
    holds them, or for a link that only guides others. What a link says itself counts before its body."""
    soft_reach: Length | None = None
    """Distance [m] outside its surface at which `mpm` bodies begin to feel it, for a whole body, not a link. By default
    a quarter of a cell in a scene with a liquid; otherwise 0.002, or an eighth of a cell if that is less. About one
    cell keeps out material that is pressed or squeezed. Material on the surface rests at this distance, and flows past
    more slowly."""

    @model_validator(mode="after")
    def _one_mass(self) -> "Material":
        if self.mass is not None:
            if self.density is not None and "density" in self.model_fields_set:
                raise ValueError("give either density or mass, not both")
            object.__setattr__(self, "density", None)  # drops the default; the field still counts as not set
        if self.soft_reach is not None and not self.touch_soft:
            raise ValueError("soft_reach has no effect with touch_soft: false; give only one of them")
        return self

    @property
    def torques(self) -> tuple[float, float]:
        """Coefficients [m] of torsional and rolling friction."""
        return self.torsional_friction, self.rolling_friction


class Vary(Model):
    """Variation of the colour from copy to copy."""

    hue: Fraction = 0.0
    """Largest change of hue, as a fraction of the full circle."""
    value: Fraction = 0.0
    """Largest change of brightness."""
    seed: Integer = Field(default=0, ge=0)
    """Same seed, same colours."""


class Palette(Model):
    """Colours that are assigned to copies in turn, chosen to be distinguishable with colour-vision deficiencies."""

    palette: Literal["okabe_ito", "tol_bright", "tol_vibrant", "tol_muted", "tol_light", "viridis", "cividis"]
    """Name of the palette. `viridis` and `cividis` are ramps from dark to light in eight steps; the others are
    qualitative."""
    start: Integer = Field(default=0, ge=0, le=1000)
    """Index of its first colour, from 0."""


Finish = Literal[
    "rough",
    "painted",
    "plastic",
    "smooth",
    "rubber",
    "metal",
    "brushed_metal",
    "polished_metal",
    "wood",
    "concrete",
    "brick",
    "ceramic",
    "glass",
    "frosted_glass",
    "cloth",
    "silicone",
    "paper",
    "sand",
    "cardboard",
    "leather",
    "felt",
    "marble",
    "plaster",
    "jelly",
    "peel",
    "foliage",
    "bark",
    "fur",
    "crust",
    "stone",
]


class Pattern(Model):
    """A pattern over the colour of a body: boards, tiles, print. Path traced only."""

    kind: Literal[
        "planks", "bricks", "tiles", "checker", "gingham", "stripes", "dots", "rings", "carton", "crate", "book", "pips"
    ]
    """`planks`: boards, or staves on round shapes. `rings`: pale sawn ends of a cylinder of timber. The last four are
    for boxes: tape and print, framed boards, covers and pages, a die or domino."""
    size: Length | None = None
    """Width [m] of a board, tile or stripe, or length of a brick; by default derived from the body."""
    color: ColorName | None = None
    """Colour of joints, tape, stripes or pips; by default derived from that of the body."""
    turned: Bool = False
    """Rotate the pattern by 90 degrees. Otherwise boards and stripes run along the longest side."""


class Label(Model):
    """Text on each large side of a body."""

    text: str = Field(min_length=1, max_length=24, pattern=r"^[^\x00-\x1f\x7f]*$")
    """A number, a letter, a name; for a `book` its title."""
    color: ColorName | None = None
    """Colour of the letters; by default a legible one."""
    plate: ColorName | None = None
    """Colour of a disc or plate behind the letters; by default there is none."""


class Look(Model):
    """Colour and surface, without influence on the physics."""

    color: Color | list[ColorName] | Palette | None = None
    """A name (`terracotta`) or `#rrggbb`. A list or a palette (`{palette: okabe_ito}`) is assigned in turn to copies,
    and to parts and links with `repeat`."""
    finish: Finish = "rough"
    """Surface of the body; the preview shows its gloss. `glass` hardly shows: a pane that should be seen is `smooth`
    with an opacity of 0.15. `stone` is rough-hewn, and rounds a box to a boulder. A liquid is by default as clear as
    water, with the colour where it is deep; `smooth` with an opacity of 1 makes it milk or paint, and with 0.9 honey or
    syrup, with the colour where it is thin, too."""
    pattern: Pattern | None = None
    """Boards, tiles or print over the colour, such as `{kind: stripes, size: 0.03, color: white}` (its width; across
    the longest side with `turned: true`): planks, bricks, tiles, checker, gingham, stripes, dots, rings; on boxes also
    carton, crate, book, pips."""
    label: Label | None = None
    """Text on the body, such as `{text: "7", color: white}`."""
    opacity: Fraction = 1.0
    """1 is opaque, 0 is invisible."""
    vary: Vary | None = None
    """Variation from copy to copy. In path-traced films copies differ slightly by default; `vary: {}` makes them
    identical."""
    visible: Bool = True
    """False omits the body, link or part from every picture, such as the thick wall behind a thin pane; of rigid
    bodies, a change needs a new run."""


class JointDynamics(Model):
    """Passive dynamics of a joint."""

    damping: NonNegative | None = None
    """Viscous damping [N s/m for a slider, N m s/rad for a hinge or ball]."""
    friction: NonNegative = 0.0
    """Dry friction of the joint [N or N m]."""
    armature: NonNegative | None = None
    """Inertia of the rotor that is added to the joint [kg or kg m2]; never added implicitly."""
    spring: NonNegative = 0.0
    """Stiffness of a spring to the position zero [N/m or N m/rad]; `initial` does not shift that zero."""


class Actuator(Model):
    """A motor on a joint: a PD servo with a limited force; without a drive it gives none."""

    stiffness: NonNegative = 0.0
    """Proportional gain kp [N/m or N m/rad]; 0 for a velocity motor."""
    damping: NonNegative = 0.0
    """Derivative gain kv [N s/m or N m s/rad]."""
    max_force: Positive | None = None
    """Largest force [N] or torque [N m] of the motor; unlimited by default."""
