"""Slow and fast snap-through of guided and free beams: docs/limits.md, results/figures/tilt.pdf.

PYTHONPATH=workflow/scripts ./run python -m studies.tilt [--small]
"""

from dataclasses import replace
from pathlib import Path

from snapmap import load_device
from snapmap.beam.cosines import buckling_shapes
from snapmap.beam.equilibria import find_barrier
from snapmap.figures import style, thresholds
from snapmap.io.markdown import table
from snapmap.numerics.portable import geometric
from snapmap.thresholds.surface import threshold

from .few import few

ROOT = Path(__file__).resolve().parents[3]
IMPERFECTIONS = (0.001, 0.01, 0.1, 0.5)
F0, C = geometric(20, 2e4, 31), [25.0]
SHOWN = (0, 10, 16, 19, 22, 25, 28, 30)
"""Which frequencies stand in the table."""
THIN = 1.2
MODEL = {"model": "cosines", "modes": 5}


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    devices = {"guided": device}
    for imperfection in few(IMPERFECTIONS):
        beam = replace(device.beam, free=1.0, imperfection=imperfection)
        devices[f"free-{imperfection:g}um"] = replace(device, beam=beam)
    found = threshold(devices, few(F0), C, threads=2, **MODEL).isel(C=0)
    rows = []
    for name in devices:
        one = found.sel(device=name)
        N = (f"{one.N_first.values[i]:.0f}" for i in few(SHOWN))
        rows.append([name, f"{one.N_static.item():.0f}", *N])
    print(lost(device.beam), end="\n\n")
    print(table(["beam", "static", *(f"{F0[i]:.3g} Hz" for i in few(SHOWN))], rows))
    draw(found)


def lost(beam):
    """The barrier of a thin free beam, pJ, up to the imperfection that ends its second shape."""
    rows = []
    for share in (0.001, 0.003, 0.004, 0.005, 0.006):
        values = {"free": 1.0, "thickness": THIN, "imperfection": share * THIN}
        barrier = find_barrier(replace(beam, **values), buckling_shapes(8))
        rows.append([f"{share:g}", f"{barrier.energy:.2f}"])
    return table([f"imperfection over {THIN:g} um of thickness", "barrier, pJ"], rows)


def draw(found):
    """Draw the thresholds of all beams over f0, two columns wide."""
    folder = Path("results") / "figures"
    folder.mkdir(parents=True, exist_ok=True)
    with style.paper():
        figure = style.double_column(height=3.6)
        thresholds.draw_thresholds(figure.subplots(), found, "f0", "device")
        style.save(figure, folder / "tilt", found.attrs)


if __name__ == "__main__":
    main()
