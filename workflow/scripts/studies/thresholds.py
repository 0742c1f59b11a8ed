"""Time, islands and error of thresholds, for docs/thresholds.md.

PYTHONPATH=workflow/scripts ./run python -m studies.thresholds [--small]
"""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from snapmap import load_device, sweep, threshold
from snapmap.io.markdown import number, table

from .few import few

ROOT = Path(__file__).resolve().parents[3]
SLOW = (35, 3.5, 0.35)
"""f0, Hz."""
CONVERGED = {"model": "cosines", "modes": 14, "step": 0.15}


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    print(changes_of_label(device))
    print(ragged_row(device))
    print(slow_pulses(device))
    print(surface(device))
    print(errors(device))


def changes_of_label(device):
    """Where labels change at 5.8 kHz, C = 0.025, on a scan in steps of 0.05 %."""
    N = np.geomspace(850, 1250, 800)
    rows = []
    for modes in few((3, 5, 7, 10)):
        asked = {"model": "cosines", "modes": modes, "until": "snap", "threads": 2}
        snapped = sweep(device, N=N, f0=[5800.0], C=[0.025], **asked).t_snap.notnull()
        changes = N[1:][np.diff(snapped.values.ravel().astype(int)) != 0]
        rows.append([str(modes), str(changes.size), f"{changes[0]:.1f}", f"{changes[-1]:.1f}"])
    return table(["cosines", "changes of label", "first N", "last N"], rows)


def ragged_row(device):
    """What is known of the same row."""
    found = threshold(device, [5800.0], [0.025], threads=2).squeeze()
    keys = "N_first", "N_error", "N_half", "half_error", "N_always"
    return table(list(keys), [[f"{found[key].item():.0f}" for key in keys]])


def slow_pulses(device):
    """Time of a threshold of a mass of 1 mg on the same beam and spring; C = 25."""
    heavy = replace(device, mass=1e6)
    threshold(heavy, [200.0], [25.0])  # compiles
    rows = []
    for f0 in few(SLOW):
        begin = time.perf_counter()
        found = threshold(heavy, [f0], [25.0]).squeeze()
        seconds = time.perf_counter() - begin
        rows.append([f"{f0:g}", f"{found.N_first.item():.4f}", f"{seconds:.0f}"])
    return table(["f0, Hz", "N_first", "seconds"], rows)


def surface(device):
    """Time of 250 x 20 thresholds, and at how many frequencies there are islands for each C."""
    axes = {"f0": few(np.geomspace(3e4, 100, 250)), "C": few(np.geomspace(0.025, 200, 20))}
    threshold(device, f0=[1500.0], C=[25.0])  # compiles
    begin = time.perf_counter()
    found = threshold(device, **axes, threads=2)
    seconds = time.perf_counter() - begin
    has = found.islands > 0
    lowest = found.f0.where(has).min("f0").values
    rows = zip(
        map(number, axes["C"]), map(str, has.sum("f0").values), map(number, lowest), strict=True
    )
    return f"{seconds:.0f} s\n\n" + table(["C", "f0 with islands, of 250", "lowest, Hz"], rows)


def errors(device):
    """Thresholds of eight devices drawn at random, against converged ones."""
    draw = np.random.default_rng(3)
    rows = []
    for i in range(few(8)):
        beam = {
            "rise": draw.uniform(5.5, 14),
            "thickness": draw.uniform(1.6, 2.4) if i % 2 else 2.0,
        }
        beam["span"] = draw.uniform(400, 800)
        other = replace(
            device,
            beam=replace(device.beam, **beam),
            mass=10 ** draw.uniform(3.3, 4.5),
            spring=draw.uniform(2, 12),
            contact=float(draw.choice([40.0, 400.0, np.inf])),
        )
        rows += error_rows(other)
    head = ["Q", "contact, N/m", "C", *(f"{f0} Hz: off, error bar, %" for f0 in FREQUENCIES)]
    return table(head, rows)


FREQUENCIES = (400, 1000, 2500, 6000)


def error_rows(device):
    critical = np.sqrt(device.spring * device.mass)
    axes = {"f0": FREQUENCIES, "C": [0.02 * critical, 0.4 * critical], "threads": 2}
    found, fine = threshold(device, **axes), threshold(device, **axes, **CONVERGED)
    off, bar = 100 * abs(found.N_first / fine.N_first - 1), 100 * found.N_error / found.N_first
    for i, C in enumerate(axes["C"]):
        pairs = zip(off.values[i], bar.values[i], strict=True)
        entries = [f"{one:.3f}, {other:.3f}" for one, other in pairs]
        yield [f"{device.beam.bistability:.2f}", f"{device.contact:g}", number(C), *entries]


if __name__ == "__main__":
    main()
