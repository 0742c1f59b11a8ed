"""Drag that grows with the cube of the velocity, as of turbulent air."""

unit_of_C = "uN*us^3/um^3"


def damping(C, velocity, place):
    return C * velocity**3
