"""A film of gas between the mass and a plate below it: C over the gap cubed.

C is that of the film as thick as at rest; a film thinner than LEAST is no thinner.
"""

FILM, LEAST = 40.0, 1.0  # um


def damping(C, velocity, place):
    ratio = FILM / max(FILM + place, LEAST)  # the mass moves to the plate where place falls
    return C * ratio**3 * velocity
