"""A mass that is fixed to the midpoint: a contact that pulls as it pushes."""


def contact(stiffness, overlap):
    return stiffness * overlap
