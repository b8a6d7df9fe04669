"""Lets bodies that are made of particles weigh what they should."""


def weigh(bodies, masses):
    """Make up for particles that are a few too many or too few for the volume that they fill.

    A particle counts as a cube of the solver's particle size. What it is made of gets denser and stiffer by the same
    factor: it moves as before, and presses on others with its true weight. Call before the scene is built.

    Args:
        bodies: Copy name -> entity.
        masses: Copy name -> mass [kg] that a body of particles should have.
    """
    for name, mass in masses.items():
        entity = bodies[name]
        material = entity.material
        factor = mass / (entity.n_particles * entity.particle_size**3 * material.rho)
        for modulus in ("rho", "lam", "mu", "von_mises_yield_stress"):
            if hasattr(material, modulus):
                setattr(material, modulus, factor * getattr(material, modulus))
