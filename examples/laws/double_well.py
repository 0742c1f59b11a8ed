"""A double well by its force over displacement, here a cubic; a measured curve goes as well."""

STIFFNESS = 20.0  # uN/um, at rest
SADDLE, SECOND = 8.0, 18.0  # um from rest, where the force is 0 again


def force(displacement):
    shares = (1 - displacement / SADDLE) * (1 - displacement / SECOND)
    return STIFFNESS * displacement * shares
