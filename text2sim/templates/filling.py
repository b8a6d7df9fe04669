"""Corrects the mass of bodies that consist of particles."""


def weigh(bodies, masses):
    """Give bodies of particles their intended mass, even if the number of particles does not match their volume.

    A particle counts as a cube of the solver's particle size. Density and stiffness change by the same factor, so the
    body deforms as before, and presses on others with its true weight. Call before the scene is built.

    Args:
        bodies: Copy name -> entity.
        masses: Copy name -> intended mass [kg].
    """
    for name, mass in masses.items():
        entity = bodies[name]
        material = entity.material
        factor = mass / (entity.n_particles * entity.particle_size**3 * material.rho)
        for modulus in ("rho", "lam", "mu", "von_mises_yield_stress"):
            if hasattr(material, modulus):
                setattr(material, modulus, factor * getattr(material, modulus))
