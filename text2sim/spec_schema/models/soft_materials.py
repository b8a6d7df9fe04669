"""Materials of deformable bodies."""

from typing import Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Bool, Density, Length, Model, NonNegative, Positive, Real


class SoftMaterial(Model):
    """The isotropic material of a soft body."""

    model: Literal["elastic", "neo_hookean", "elasto_plastic"] = "elastic"
    """`elastic` returns to its shape (corotated); `neo_hookean` handles large strains better; `elasto_plastic` keeps
    dents (mpm only)."""
    youngs_modulus: Positive = 1e5
    """Young's modulus [Pa]: rubber foam 1e4 to 1e5, soft rubber 1e6."""
    poisson_ratio: Real = Field(default=0.3, ge=0.0, lt=0.5)
    """Poisson's ratio, how much it bulges under compression; 0.5 would preserve its volume."""
    density: Density = 1000.0
    """Density [kg/m3]."""
    friction: Real = Field(default=0.5, ge=0.0, le=5.0)
    """Coulomb coefficient against rigid bodies. For an mpm body that of the rigid body applies instead."""
    adhesion: NonNegative = 0.0
    """With solver mpm: it sticks to rigid bodies up to this traction [Pa], in shear and in tension: shaving foam, dough
    and mud some 100 to 1000. A layer of thickness h stays on a slope of angle a, and on a wall, up to `density 9.81 h
    sin(a)`. If its `yield_stress` is less than 1.7 times that, it creeps down and leaves a trail."""
    damping: NonNegative | None = None
    """Rate [1/s] at which it stops wobbling. With mpm, velocities relative to the motion of a rigid body decay at this
    rate, so that the amplitude of a wobble falls as `exp(-damping t / 2)`, and falling, sliding and tumbling are left
    alone: rubber and jelly 5 to 20, foam and dough 50 and more; by default none. With fem, all of its velocity
    decays; derived by default."""
    hydroelastic_modulus: Positive | None = None
    """With solver fem: stiffness of contact. The contact pressure [Pa] grows with the depth up to this value in the
    middle of the body; by default 1e7. For bodies that are squeezed to half their width use 10 to 30 times
    `youngs_modulus`: the engine cannot solve contact that is hundreds of times stiffer than the body."""
    yield_stress: Positive | None = None
    """With `elasto_plastic`: von Mises stress [Pa] from which it flows; by default a tenth of the stiffness. It is 1.7
    times the yield stress in shear that tables give. A column bulges at its foot above the height
    `yield_stress / (rho g)`."""
    viscosity: NonNegative = 0.0
    """With `elasto_plastic`: plastic viscosity [Pa s] (Bingham): it keeps its shape below `yield_stress`, and flows
    slowly above it, as foams, creams and pastes do; with 0 it gives way at once. `yield_stress` and `viscosity` are
    about 40 and 2 for custard, 100 and 5 for whipped cream, 100 and 10 for shaving foam, 150 and 5 for mayonnaise, 300
    and 30 for toothpaste, 2000 and 1000 for lava, 10,000 and 1000 for wet clay. A block of height h stays as it is
    below a density of `yield_stress / (9.81 h)`; else it sinks, most of its way within some `3 viscosity /
    yield_stress` seconds. Give a `youngs_modulus` of ten times `yield_stress`, and of the pressure at its base, or
    more."""
    tear_stretch: Real | None = Field(default=None, gt=1.0, le=10.0)
    """With solver mpm, not `elasto_plastic`: the largest stretch, length over length at rest in any direction, beyond
    which it tears, for ever: jelly 1.4, bread 1.3, tofu 1.15, cake 1.1. What has torn bears pressure and friction, and
    no tension: it can be cut, and torn in two. A bar breaks at a stress of about `youngs_modulus (tear_stretch - 1)`.
    Driven blades and wires cut it if they are `1.5 + 5 (tear_stretch - 1)` cells thick, counting twice what their
    `soft_reach` adds to its default: for tofu, a wire of half a cell with a `soft_reach` of one cell. By default
    nothing tears by strain."""


class ClothMaterial(Model):
    """The material of a cloth."""

    area_density: Positive = 0.3
    """Mass per area [kg/m2]: shirt 0.15, curtain 0.3, canvas 0.5."""
    thickness: Length = 1e-3
    """Thickness [m]. With solver pbd contact uses the particle distance instead."""
    friction: Real = Field(default=0.3, ge=0.0, le=5.0)
    """Coulomb coefficient on itself, other cloth and mpm bodies; on a rigid body the larger of both values applies.
    Folded over a bar it slides off once L1 of it hangs on one side and less than `L1 / exp(3.14 friction)` on the
    other. With solver pbd that needs a `rigidity` of 1e-5 or less: cloth of the default stiffness stands off a bar of
    less than two cells, and friction counts for less."""
    youngs_modulus: Positive | None = None
    """In-plane Young's modulus E [Pa]. With solver pbd it makes the cloth elastic, such as rubber (1e6): the tension is
    `E thickness` [N/m] times the strain, Poisson's ratio is 1/3; by default its threads hardly stretch. With solver ipc
    by default 1e6."""
    prestretch: Real | None = Field(default=None, gt=1.0, le=4.0)
    """With solver pbd and a `youngs_modulus`: length of its threads at the start over that at rest, for what is held
    stretched at first, as a rubber band, a drumhead or a trampoline. A sleeve is stretched around alone, all
    else in both directions. A strip, b wide at rest, pulls with
    `E thickness b (prestretch - 1)`."""
    poisson_ratio: Real | None = Field(default=None, ge=0.0, lt=0.5)
    """With solver ipc: Poisson's ratio, how much it narrows under tension; by default 0.3."""
    stretch_compliance: NonNegative | None = None
    """With solver pbd: compliance of the threads [m/N]; by default 1e-7."""
    bending_compliance: NonNegative | None = None
    """With solver pbd: compliance of the folds [rad/N]; by default 1e-4, and 1e4 drapes like cotton. What it amounts to
    depends on cells and substeps: give a `rigidity` instead to what is stiff by its material."""
    rigidity: Positive | None = None
    """Flexural rigidity `E t^3 / 12` [N m]: cotton 1e-6, paper 3e-4, card 0.01. With solver pbd it replaces
    `bending_compliance`, and a mass m per area needs substeps of `cell^2 / 12 sqrt(m / rigidity)`, or it is softer.
    With solver ipc by default 2e-5."""
    crease_radius: Length | None = None
    """With solver pbd: folds tighter than this radius [m], `thickness / (2 yield strain)`, stay: in foil (0.05), in
    paper (0.01). An edge keeps what exceeds `cell / crease_radius` radians. By default all folds spring back."""
    rest_shape: Literal["flat", "start"] | None = None
    """With solver pbd: what bending returns it to, by default `flat`; `start` keeps the curl of `sag` and `folds`, and
    the form of a mesh."""
    pressure: NonNegative | None = None
    """With solver pbd, for a closed hull: pressure of the gas in it at the start above that outside [Pa]: pillow 50,
    balloon 1000. A flat bag swells; under a load it gives way where the load per area is more than that."""
    gas_modulus: NonNegative | None = None
    """With solver pbd, for a closed hull of volume V: the pressure [Pa] grows by `gas_modulus (V_start / V - 1)`; by
    default 0, as if a pump kept it. Sealed air has 1e5, and needs short steps."""
    damping: NonNegative | None = None
    """With solver pbd: rate c [1/s] of its internal friction, by default 0: it flutters with an amplitude that falls as
    `exp(-c t / 2)`. 5 ends it within a second, and folds close as slowly. It damps neither fall nor sway as a whole:
    let a wind fade over the period `2 pi sqrt(2 L / (3 g))` of what hangs down by L, or give a `drag`."""
    air_resistance: NonNegative | None = None
    """With solver pbd: coefficient c [kg/m] of the drag `c |v| v` of still air on each point; by default `cell^2 / 4`,
    as of air. A sheet with n points, `(size / cell + 1)` along each side, lets a mass m sink at `sqrt(m g / (n c))`, as
    a parachute."""

    @property
    def tension_modulus(self) -> float | None:
        """Young's modulus times thickness [N/m]; None if it is not given."""
        return None if self.youngs_modulus is None else self.youngs_modulus * self.thickness

    @property
    def has_gas(self) -> bool:
        """Whether it encloses gas."""
        return bool(self.pressure or self.gas_modulus)


class GranularMaterial(Model):
    """Sand, grain, gravel."""

    density: Density = 1600.0
    """Bulk density [kg/m3], including the air between grains."""
    friction_angle_deg: Real = Field(default=35.0, gt=0.0, lt=80.0)
    """Angle of internal friction [deg], which limits the slope of a heap."""
    cohesion: NonNegative = 0.0
    """Shear strength without pressure [Pa]: 0 if dry, some 1000 for damp sand. A block of density d stands up to a
    height of `2 cohesion tan(45 deg + friction_angle_deg / 2) / (9.81 d)`."""
    youngs_modulus: Positive = 5e5
    """Young's modulus [Pa]; softer than real grains, for longer time steps."""
    poisson_ratio: Real = Field(default=0.2, ge=0.0, lt=0.5)
    """Poisson's ratio, how much it pushes sideways under compression."""


class LiquidMaterial(Model):
    """Water, oil, honey.

    Waves live on only in a vessel whose `friction` is 0.01, which counts as none: with 0.1 the standing wave in a bowl
    of 0.2 m dies within one swing. If the vessel is 16 cells of the grid across, a wave keeps three quarters of its
    height in each period; with fewer cells, less.
    """

    density: Density = 1000.0
    """Density [kg/m3]."""
    stiffness: Positive = 5e5
    """Resistance to compression [Pa]; softer than real water (2e9), for longer time steps."""
    viscosity: NonNegative = 0.0
    """Dynamic viscosity [Pa s]: oil 0.1, syrup 2, honey 10; that of water is less than the grid's own. A high one wants
    short steps: at most some `density cell^2 / (8 viscosity)`. A volume V spreads on a flat floor to a radius of some
    `R = 0.9 (9.81 density V^3 t / (3 viscosity))^(1/8)`; where the layer `V / (3.14 R^2)` is thinner than a cell of the
    grid, it runs out in arms and drops. A liquid always levels out: what keeps a shape, as cream and toothpaste, is
    a `soft` body of model `elasto_plastic` with a `viscosity`."""
    viscous: Bool = False
    """Make it also resist shear, as much as its stiffness allows. Instead of `viscosity`, which says how much."""

    @model_validator(mode="after")
    def _one_viscosity(self) -> "LiquidMaterial":
        if self.viscous and self.viscosity:
            raise ValueError(f"give either viscous or viscosity (got true and {self.viscosity:g} Pa s)")
        return self


class SnowMaterial(Model):
    """Snow: crumbles under tension, hardens under compression."""

    density: Density = 300.0
    """Density [kg/m3]: fresh 100, packed 400."""
    youngs_modulus: Positive = 5e5
    """Young's modulus [Pa] before compression."""
    poisson_ratio: Real = Field(default=0.2, ge=0.0, lt=0.5)
    """Poisson's ratio, how much it bulges under compression."""
    crush: Positive = Field(default=0.025, le=0.5)
    """Compressive strain from which it crushes."""
    crumble: Positive = Field(default=0.0045, le=0.5)
    """Tensile strain from which it crumbles."""
