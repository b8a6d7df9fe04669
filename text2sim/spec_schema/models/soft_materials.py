"""Materials of deformable bodies."""

from typing import Literal

from pydantic import Field

from text2sim.spec_schema.models.base import Bool, Density, Length, Model, NonNegative, Positive, Real


class SoftMaterial(Model):
    """The stuff of a soft body, isotropic."""

    model: Literal["elastic", "neo_hookean", "elasto_plastic"] = "elastic"
    """`elastic` returns to its shape (corotated); `neo_hookean` bears large strains better; `elasto_plastic`
    keeps a dent (mpm only)."""
    youngs_modulus: Positive = 1e5
    """Stiffness [Pa]: rubber foam 1e4 to 1e5, soft rubber 1e6."""
    poisson_ratio: Real = Field(default=0.3, ge=0.0, lt=0.5)
    """How much it bulges when it is pressed; 0.5 would keep its volume."""
    density: Density = 1000.0
    """Density [kg/m3]."""
    friction: Real = Field(default=0.5, ge=0.0, le=5.0)
    """Coulomb coefficient against rigid bodies. An mpm body takes that of the rigid body instead."""
    damping: NonNegative | None = None
    """With solver fem: part of the velocity that is lost in a second [1/s]; derived if left out."""
    hydroelastic_modulus: Positive | None = None
    """With solver fem: how hard its contact is. The pressure [Pa] of contact grows with the depth, and is this large in
    the middle of the body; 1e7 if left out. For bodies that are squeezed to half their width, 10 to 30 times
    `youngs_modulus`: the engine does not solve contact that is hundreds of times harder than the body."""
    yield_stress: Positive | None = None
    """With `elasto_plastic`: von Mises stress [Pa] from which it flows; a tenth of the stiffness if left out."""


class ClothMaterial(Model):
    """The stuff of a cloth."""

    area_density: Positive = 0.3
    """Mass of an area [kg/m2]: shirt 0.15, curtain 0.3, canvas 0.5."""
    thickness: Length = 1e-3
    """Thickness [m]. With solver pbd the distance of its particles takes this place in contact."""
    friction: Real = Field(default=0.3, ge=0.0, le=5.0)
    """Coulomb coefficient, on itself and other cloth; on a rigid body the larger of both holds."""
    youngs_modulus: Positive | None = None
    """With solver ipc: stiffness [Pa] of the fabric in its plane; 1e6 if left out."""
    poisson_ratio: Real | None = Field(default=None, ge=0.0, lt=0.5)
    """With solver ipc: how much it narrows when it is stretched; 0.3 if left out."""
    bending_stiffness: NonNegative | None = None
    """With solver ipc: resistance to bending, as the engine means it; 10 if left out."""
    stretch_compliance: NonNegative | None = None
    """With solver pbd: how much the threads give [m/N]; 1e-7 if left out."""
    bending_compliance: NonNegative | None = None
    """With solver pbd: how easily it folds [rad/N]; 1e-4 if left out, which is stiff as card. 1e4 drapes like
    cotton."""
    air_resistance: NonNegative | None = None
    """With solver pbd: drag `c |v| v` [kg/m] of still air on each point; c is 1e-3 if left out. A sheet is a parachute:
    with n points, `(size / cell + 1)` along each side, it carries a mass m down at `sqrt(m g / (n c))`."""


class GranularMaterial(Model):
    """Sand, grain, gravel."""

    density: Density = 1600.0
    """Of the heap, air included [kg/m3]."""
    friction_angle_deg: Real = Field(default=35.0, gt=0.0, lt=80.0)
    """Inner friction angle [deg]: how steep a heap of it stands."""
    youngs_modulus: Positive = 5e5
    """Stiffness [Pa]; softer than real grains so that steps may be long."""
    poisson_ratio: Real = Field(default=0.2, ge=0.0, lt=0.5)
    """How much it presses sideways when it is pressed."""


class LiquidMaterial(Model):
    """Water, oil, honey."""

    density: Density = 1000.0
    """Density [kg/m3]."""
    stiffness: Positive = 5e5
    """How strongly it resists compression [Pa]; softer than real water (2e9) so that steps may be long."""
    viscous: Bool = False
    """Let it resist shear, too, as much as its stiffness allows: more like paste than like water."""


class SnowMaterial(Model):
    """Snow: crumbles when it is stretched, hardens when it is pressed."""

    density: Density = 300.0
    """Density [kg/m3]: fresh 100, packed 400."""
    youngs_modulus: Positive = 5e5
    """Stiffness [Pa] before it is pressed."""
    poisson_ratio: Real = Field(default=0.2, ge=0.0, lt=0.5)
    """How much it bulges when it is pressed."""
    crush: Positive = Field(default=0.025, le=0.5)
    """Compression, as a part of its length, from which it crushes."""
    crumble: Positive = Field(default=0.0045, le=0.5)
    """Stretch, as a part of its length, from which it crumbles."""
