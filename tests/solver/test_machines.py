"""The same bits on every processor: those of record, and imitated ones in their own processes."""

import os
import platform
import subprocess
import sys

import pytest
from small_studies import cases_of

STUDY, BITS = cases_of(__file__).values()
IS_X86 = platform.machine() in ("x86_64", "AMD64")
ANOTHER = {"OPENBLAS_CORETYPE": "Haswell", "NUMBA_CPU_NAME": "haswell"}
"""Vectors of 256 bits, in which LLVM takes its own order of instructions."""
if not IS_X86:
    ANOTHER = {"OPENBLAS_CORETYPE": "ARMV8", "NUMBA_CPU_NAME": "generic"}
OTHERS = {"another": ANOTHER}
if IS_X86:
    OTHERS["any with FMA"] = {"OPENBLAS_CORETYPE": "Zen", "NUMBA_CPU_NAME": "x86-64-v3"}
    OTHERS["no wide vectors"] = {"NPY_DISABLE_CPU_FEATURES": "X86_V4 X86_V3"}
    OTHERS["no wide vectors"]["OPENBLAS_CORETYPE"] = "SkylakeX"


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
