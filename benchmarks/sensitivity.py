"""How the threshold moves with the device, and how much the beam is stressed: docs/limits.md.

PYTHONPATH=workflow/scripts ./run python benchmarks/sensitivity.py
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from markdown import table

from snapmap import load_device, threshold
from snapmap.bases.cosines import symmetric_cosines
from snapmap.cells import to_cells
from snapmap.modal import reduce_to_modes, step_limit
from snapmap.models import Model, build_model
from snapmap.protocol import Protocol
from snapmap.reference import follow, nodal_system
from snapmap.survey import survey
from snapmap.wells import find_barrier

ROOT = Path(__file__).resolve().parents[1]
BEAM = ("span", "rise", "thickness", "depth", "youngs_modulus", "density")
OTHERS = ("mass", "spring", "contact", "gravity")
F0, C, TOLERANCE, ELEMENTS = 1500.0, 0.025, 1e-6, 10


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    print(one_percent_more(device))
    print(eigenstrain(device))
    print(stresses(device))


def one_percent_more(device):
    first = lowest(device)
    rows = [["as it is", f"{first:.2f}"]]
    for key in BEAM:
        more = replace(device.beam, **{key: 1.01 * getattr(device.beam, key)})
        rows.append([key, f"{100 * (lowest(replace(device, beam=more)) / first - 1):+.2f} %"])
    for key in OTHERS:
        more = replace(device, **{key: 1.01 * getattr(device, key)})
        rows.append([key, f"{100 * (lowest(more) / first - 1):+.2f} %"])
    damped = replace(device, beam=replace(device.beam, damping=4e-4))
    rows.append(["damping 4e-4 /us", f"{100 * (lowest(damped) / first - 1):+.3f} %"])
    rows += [[f"C = {c:g}", f"{100 * (lowest(device, c) / first - 1):+.2f} %"] for c in (25, 200)]
    return table(["1 % more of", "N_first"], rows)


def lowest(device, damping=C):
    options = {"model": "cosines", "modes": 5, "tolerance": TOLERANCE}
    return threshold(device, [F0], [damping], **options).N_first.item()


def eigenstrain(device):
    first, rows = None, []
    for strain in (0.0, 1e-5, -1e-5, 1e-4, -1e-4):
        strained, model = with_eigenstrain(device, strain)
        found = survey(model, [F0], [C], Protocol(), TOLERANCE).N_first[0]
        first = first or found
        rise = strained.beam.rise / device.beam.rise - 1
        rows.append([f"{strain:g}", f"{100 * rise:+.3f} %", f"{100 * (found / first - 1):+.2f} %"])
    return table(["eigenstrain", "rise", "N_first"], rows)


def with_eigenstrain(device, strain):
    """The device at its new rise, and five cosines about it with the axial force that is left."""
    beam = device.beam
    n_1 = beam.bending_stiffness * (2 * np.pi / beam.span) ** 2
    arch, push = 0.75 * beam.bistability**2, strain * beam.youngs_modulus * beam.area / n_1
    # 1 - 1/s = N/N_1 = arch (1 - s^2) + push, s the new rise over the old one.
    scale = np.roots([arch, 0, 1 - arch - push, -1]).real.max()
    force = (1 - 1 / scale) * n_1
    old, unit_force = symmetric_cosines(5), force / (beam.stiffness_unit * beam.span)
    basis = replace(
        old,
        bending=old.bending - unit_force * old.geometric,
        flexibility=lambda axial_force: old.flexibility(axial_force + unit_force),
    )
    strained = replace(device, beam=replace(beam, rise=scale * beam.rise))
    modal = reduce_to_modes(strained, basis, 5)
    dt = 0.5 * step_limit(strained, modal)
    return strained, Model("cosines", strained, basis, modal, find_barrier(modal), dt)


def stresses(device):
    model = build_model(device, "reference", elements=ELEMENTS)
    rows = []
    for N in (984, 1000, 1500, 2400):
        u, basis = motion(device, model, N), model.basis.scaled_to(device.beam)
        w = device.beam.rise + u @ basis.midpoint
        snap = np.argmax(w <= device.beam.second_equilibrium)
        stretch = np.sum(u * (u @ basis.geometric + 2 * slope(basis)), axis=1)
        axial = device.beam.axial_stiffness * stretch / device.beam.area
        bending = bending_stress(device.beam, u)
        for label, part in (("to the snap", slice(snap + 1)), ("to the horizon", slice(None))):
            ends = f"{axial[part].min():.0f} to {axial[part].max():.0f}"
            most = (bending[part] + axial[part]).max()
            rows.append([f"{N}, {label}", f"{bending[part].max():.0f}", ends, f"{most:.0f}"])
    return table(["N", "bending, MPa", "axial, MPa", "largest tension, MPa"], rows)


def slope(basis):
    return basis.geometric @ basis.start


def motion(device, model, N):
    """Nodal displacements from the start at every step, (steps, n)."""
    *load, t_end = (value[0] for value in to_cells(device, [N], [F0], [C], Protocol().horizon))
    n, steps = model.basis.load.size, int(np.ceil(t_end / model.dt))
    kept = np.zeros((steps, 2 * n + 4))
    follow(nodal_system(device, model.basis), *load, -np.inf, model.dt, steps, kept)
    return kept[:, :n]


def bending_stress(beam, u):
    """Largest E t/2 |w'' - w0''| at the ends of all elements, MPa."""
    h = 1 / 2 / ELEMENTS
    nodal = np.pad(u, ((0, 0), (2, 1)))
    ends = np.array([[-6, -4 * h, 6, -2 * h], [6, 2 * h, -6, 4 * h]]) / h**2
    of_element = [nodal[:, i : i + 4] @ ends.T for i in range(0, 2 * ELEMENTS, 2)]
    return (
        beam.youngs_modulus
        * beam.thickness
        / 2
        / beam.span**2
        * abs(np.hstack(of_element)).max(axis=1)
    )


if __name__ == "__main__":
    main()
