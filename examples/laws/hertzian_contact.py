"""A ball on a flat: the push grows with the overlap to the power 3/2."""

HERTZ = 60.0  # uN/um^1.5, 4/3 E* sqrt(R)


def contact(stiffness, overlap):
    return HERTZ * overlap**1.5 if overlap > 0 else 0.0
