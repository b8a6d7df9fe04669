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
"""Density [kg/m3] of rigid bodies whose material says neither density nor mass."""


class Material(Model):
    """Contact and mass of a rigid body."""

    density: Density | None = DENSITY
    """Density [kg/m3]; none if `mass` is given."""
    mass: Mass | None = None
    """Mass [kg] of one copy, instead of `density`."""
    friction: Real = Field(default=0.5, ge=0.01, le=5.0)
    """Coulomb coefficient. A pair of bodies slides with the larger of its two values, unless
    `scene.contact.pairs` has one for it."""
    rolling_friction: Real = Field(default=0.0, ge=0.0, le=1.0)
    """Rolling resistance [m]: its torque is this times the normal force; of two bodies, the larger value counts. A ball
    of radius r that rolls slows down at 5/7 g times this over r. It is c r for a coefficient of rolling resistance c,
    which is 0.01 for a billiard ball on its cloth."""
    torsional_friction: Real = Field(default=0.0, ge=0.0, le=1.0)
    """The same against spin about the normal of a contact [m]: two thirds of friction times the radius of the patch."""
    restitution: Real | None = Field(default=None, ge=0.0, le=0.995)
    """Bounce: speed after over speed before, between two bodies of this material, or of one and a static that has none;
    it takes a short time step. Between unequal bodies the damping ratio is the mean."""
    touch_soft: Bool = True
    """Whether soft bodies, cloth, grains and liquids feel it; false for a hook or rod that only holds."""
    soft_reach: Length | None = None
    """How far [m] outside its surface `mpm` bodies begin to feel it. If left out: half a cell in a scene with a liquid,
    which keeps that out of walls; else 0.002, or an eighth of a cell if that is less. About a cell keeps out what is
    pressed or squeezed. What lies on it stays as far off, and flows past it more slowly."""

    @model_validator(mode="after")
    def _one_mass(self) -> "Material":
        if self.mass is not None:
            if self.density is not None and "density" in self.model_fields_set:
                raise ValueError("give either density or mass, not both")
            object.__setattr__(self, "density", None)  # the default is not meant; it stays a field that was not set
        if self.soft_reach is not None and not self.touch_soft:
            raise ValueError("soft_reach says how deformable bodies touch it, and touch_soft: false that they do not")
        return self

    @property
    def torques(self) -> tuple[float, float]:
        """Coefficients [m] of torsional and rolling friction."""
        return self.torsional_friction, self.rolling_friction


class Vary(Model):
    """Variation of the colour from copy to copy."""

    hue: Fraction = 0.0
    """Largest change of hue, as a part of the whole circle."""
    value: Fraction = 0.0
    """Largest change of brightness."""
    seed: Integer = Field(default=0, ge=0)
    """Same seed, same colours."""


class Palette(Model):
    """Colours that copies take in turn, which people with every kind of colour vision tell apart."""

    palette: Literal["okabe_ito", "tol_bright", "tol_vibrant", "tol_muted", "tol_light", "viridis", "cividis"]
    """Its name. `viridis` and `cividis` are ramps from dark to light in eight steps, the others are for things that
    are different."""
    start: Integer = Field(default=0, ge=0, le=1000)
    """Which of its colours comes first, counted from 0."""


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
]


class Pattern(Model):
    """What lies over the colour of a body: boards, tiles, print. Seen in path traced films."""

    kind: Literal[
        "planks", "bricks", "tiles", "checker", "gingham", "stripes", "dots", "carton", "crate", "book", "pips"
    ]
    """`planks`: boards; staves on what is round. The last four are for boxes: tape and print, framed boards, covers
    and pages, a die or domino."""
    size: Length | None = None
    """Width [m] of a board, tile or stripe, length of a brick; by default as fits."""
    color: ColorName | None = None
    """Of joints, tape, stripes or pips; by default as fits."""
    turned: Bool = False
    """By 90 degrees: boards and stripes run along the longest side."""


class Label(Model):
    """What is written on a body, on each large side of it."""

    text: str = Field(min_length=1, max_length=24, pattern=r"^[^\x00-\x1f\x7f]*$")
    """A number, a letter, a name; of a `book`, its title."""
    color: ColorName | None = None
    """Of the letters; as is read well if left out."""
    plate: ColorName | None = None
    """Of a disc or plate behind them; none if left out."""


class Look(Model):
    """Colour and surface. Never changes the physics."""

    color: Color | list[ColorName] | Palette | None = None
    """A name (`terracotta`), `#rrggbb`, three numbers in 0..1, a list of names that copies take in turn, and parts and
    links with `repeat`, or a palette (`{palette: okabe_ito}`)."""
    finish: Finish = "rough"
    """Surface of the body; the preview shows how it shines. A liquid that is given none is as clear as `glass`."""
    pattern: Pattern | None = None
    """Boards, tiles or print over the colour, as `{kind: stripes, size: 0.03, color: white}`: planks, bricks, tiles,
    checker, gingham, stripes, dots; on boxes also carton, crate, book, pips."""
    label: Label | None = None
    """What is written on it, as `{text: "7", color: white}`."""
    opacity: Fraction = 1.0
    """1 is solid, 0 is invisible."""
    vary: Vary | None = None
    """Variation from copy to copy. In path traced films copies differ a little by themselves; `vary: {}` makes them
    alike."""
    visible: Bool = True
    """False leaves the body out of every picture."""


class JointDynamics(Model):
    """What a joint does when nobody drives it."""

    damping: NonNegative | None = None
    """Viscous damping [N s/m for a slider, N m s/rad for a hinge or ball]."""
    friction: NonNegative = 0.0
    """Dry friction of the joint [N or N m]."""
    armature: NonNegative | None = None
    """Inertia of the rotor that is added to the joint [kg or kg m2]; never added in secret."""
    spring: NonNegative = 0.0
    """Stiffness of a spring to the position 0 [N/m or N m/rad]; `initial` does not move that."""


class Actuator(Model):
    """A motor on a joint: a PD servo with a limited force."""

    stiffness: NonNegative = 0.0
    """Proportional gain kp [N/m or N m/rad]; 0 for a velocity motor."""
    damping: NonNegative = 0.0
    """Derivative gain kv [N s/m or N m s/rad]."""
    max_force: Positive | None = None
    """Largest force [N] or torque [N m] it can give; unlimited if left out."""
