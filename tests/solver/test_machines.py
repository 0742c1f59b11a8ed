"""The same bits on every processor: those of record, and imitated ones in their own processes."""

import os
import platform
import subprocess
import sys

import pytest

STUDY = """
import hashlib
import sys
from dataclasses import replace
from pathlib import Path

import snapmap
from snapmap.beam.modal import natural_frequency
from snapmap.study.variables import write
from snapmap import Reference, Study
from snapmap.solver.outcome import SNAPPED
from snapmap.numerics.portable import geometric, linear

device, folder, names = snapmap.load_device(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:]
stressed = replace(device.beam, free=1.0, imperfection=0.05, residual_stress=-8.0)
damped = replace(stressed, damping=natural_frequency(stressed) / 250.0)
ringing = replace(device, beam=damped)
chaotic = {"N": linear(1100, 2350, 6), "f0": geometric(700, 5000, 4), "C": [0.025]}


def sweep(model, device=device):
    return snapmap.sweep(Study(device, model), **chaotic)


products = {
    "cosines": lambda: sweep("3 cosines"),
    "elements": lambda: sweep("2 elements"),
    "reference": lambda: sweep(Reference(elements=2)),
    "history": lambda: snapmap.simulate(Study(device, "3 cosines"), 2200.0, 1000.0, 0.025),
    "quality": lambda: sweep("3 cosines", ringing),
    "threshold": lambda: snapmap.threshold(Study(device, "cosines"), [1500.0, 6000.0], [0.025]),
}
for name in names or products:
    product = products[name]()
    if name == "cosines":
        assert (product.outcome == SNAPPED).sum() > 10  # the end open: what follows is chaotic
    write(product, folder / "product.nc")
    print(name, hashlib.sha256((folder / "product.nc").read_bytes()).hexdigest())
    numbers = (product[key].values for key in sorted(product.variables))
    bits = b"".join(column.tobytes() for column in numbers if column.dtype.kind in "if")
    print(name, "numbers", hashlib.sha256(bits).hexdigest()[:16])
"""
BITS = {
    "cosines numbers": "5436d396a3af8a9a",
    "reference numbers": "9d942870cac4291c",
    "quality numbers": "26a137aced4f4e60",
}
"""Hashes of numbers, on x86-64 and on ARM: a file also names the version of Python."""
IS_X86 = platform.machine() in ("x86_64", "AMD64")
ANOTHER = {"OPENBLAS_CORETYPE": "Haswell", "NUMBA_CPU_NAME": "haswell"}
"""Vectors of 256 bits, in which LLVM takes its own order of instructions."""
if not IS_X86:
    ANOTHER = {"OPENBLAS_CORETYPE": "ARMV8", "NUMBA_CPU_NAME": "generic"}
OTHERS = {"another": ANOTHER}
if IS_X86:
    OTHERS["any with FMA"] = {"OPENBLAS_CORETYPE": "Zen", "NUMBA_CPU_NAME": "x86-64-v3"}
    OTHERS["no wide vectors"] = {
        "OPENBLAS_CORETYPE": "SkylakeX",
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 X86_V3",
    }


def compute(root, folder, processor):
    """The hash of each file of the study, computed by a process with the given environment."""
    command = [sys.executable, "-c", STUDY, root / "config" / "config.yaml", folder]
    folders = root / "workflow" / "scripts", root / "tests"
    path = {"PYTHONPATH": os.pathsep.join(map(str, folders))}
    run = subprocess.run(command, env=os.environ | path | processor, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return dict(line.rsplit(maxsplit=1) for line in run.stdout.splitlines())


def test_the_bits_are_those_of_every_machine(root, tmp_path, monkeypatch, capsys):
    names = [key.partition(" ")[0] for key in BITS]
    monkeypatch.setattr(sys, "argv", ["", root / "config" / "config.yaml", tmp_path, *names])
    exec(STUDY, {})
    here = dict(line.rsplit(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert BITS.items() <= here.items()


@pytest.mark.long
@pytest.mark.parametrize("processor", OTHERS)
def test_no_product_changes_a_bit(root, tmp_path, processor):
    """Its kernels are compiled afresh; here they may come from the cache."""
    cache, here = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}, compute(root, tmp_path, {})
    assert len(here) == 12 and compute(root, tmp_path, OTHERS[processor] | cache) == here
