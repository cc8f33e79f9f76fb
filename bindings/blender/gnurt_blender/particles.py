# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of particles for the shaders of the objects that they show."""

from . import hashes


def values(instance, frame):
    """What the node Particle Info gives of the particle that shows an instance; None if none does."""
    system = instance.particle_system if instance is not None and instance.is_instance else None
    if system is None:
        return None
    number = instance.persistent_id[0]
    if not 0 <= number < len(system.particles):
        return None
    found = system.particles[number]
    return {
        "Index": float(number),
        "Random": float(hashes.of_number(number)),
        "Age": frame - found.birth_time,
        "Lifetime": found.lifetime,
        "Location": tuple(found.location),
        "Size": found.size,
        "Velocity": tuple(found.velocity),
        "Angular Velocity": tuple(found.angular_velocity),
    }
