"""The same bits on every processor: each is imitated in a process of its own."""

import os
import subprocess
import sys

import pytest

STUDY = """
import hashlib
import sys
from dataclasses import replace
from pathlib import Path

import snapmap
from snapmap.beam.modal import damped
from snapmap.io.netcdf import write
from snapmap.solver.outcome import SNAPPED
from snapmap.numerics.portable import geometric, linear

device, folder, names = snapmap.load_device(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:]
stressed = replace(device.beam, free=1.0, imperfection=0.05, residual_stress=-8.0)
ringing = replace(device, beam=damped(stressed, 250.0))
chaotic = {"N": linear(1100, 2350, 6), "f0": geometric(700, 5000, 4), "C": [0.025]}


def sweep(model, **options):
    return snapmap.sweep(device, **chaotic, model=model, **options)


products = {
    "cosines": lambda: sweep("cosines", modes=3),
    "handout": lambda: sweep("handout", elements=2),
    "reference": lambda: sweep("reference", elements=2),
    "history": lambda: snapmap.simulate(device, 2200.0, 1000.0, 0.025, model="cosines", modes=3),
    "quality": lambda: snapmap.simulate(ringing, 900.0, 2e4, 2.5, model="cosines", modes=3),
    "threshold": lambda: snapmap.threshold(device, [1500.0, 6000.0], [0.025], model="cosines"),
}
for name in names or products:
    product = products[name]()
    if name == "cosines":
        assert (product.outcome == SNAPPED).sum() > 10  # the end open: what follows is chaotic
    write(product, folder / "product.nc")
    print(name, hashlib.sha256((folder / "product.nc").read_bytes()).hexdigest())
"""
WITHOUT = {
    "BLAS for Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "BLAS for Zen": {"OPENBLAS_CORETYPE": "Zen"},
    "BLAS for SkylakeX, numpy without wide vectors": {
        "OPENBLAS_CORETYPE": "SkylakeX",
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 X86_V3",
    },
}
KERNELS = "cosines", "handout", "reference"
COMPILED = {"for Haswell": "haswell", "for all with FMA": "x86-64-v3"}


def compute(root, folder, processor, *names):
    """The hash of each file of the study, computed by a process with the given environment."""
    command = [sys.executable, "-c", STUDY, root / "config" / "config.yaml", folder, *names]
    path = {"PYTHONPATH": str(root / "workflow" / "scripts")}
    run = subprocess.run(command, env=os.environ | path | processor, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return dict(line.split() for line in run.stdout.splitlines())


@pytest.fixture(scope="module")
def here(root, tmp_path_factory):
    """As this machine computes them by itself, with vectors of 512 bits where it has them."""
    found = compute(root, tmp_path_factory.mktemp("here"), {})
    assert len(found) == 6
    return found


@pytest.mark.parametrize("processor", WITHOUT)
def test_libraries_for_another_processor_change_no_bit(root, tmp_path, here, processor):
    assert compute(root, tmp_path, WITHOUT[processor]) == here


@pytest.mark.parametrize(
    "processor", ["for Haswell", pytest.param("for all with FMA", marks=pytest.mark.long)]
)
def test_kernels_for_another_processor_change_no_bit(root, tmp_path, here, processor):
    """Both have vectors of 256 bits, and each takes its own order of instructions.

    They are compiled afresh; where the others find theirs in the cache, that is compared as well.
    """
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    found = compute(root, tmp_path, {"NUMBA_CPU_NAME": COMPILED[processor]} | cache, *KERNELS)
    assert found == {name: here[name] for name in KERNELS}
