from dataclasses import asdict
from pathlib import Path


def code(*modules):
    """Paths of the package's modules, for the input of rules: Snakemake follows no imports."""
    package = Path(workflow.basedir) / "workflow" / "scripts" / "snapmap"
    found = {module: sorted(package.glob(module)) for module in modules}
    for module, paths in found.items():
        if not paths:
            raise WorkflowError(f"{module}: no such module in {package}")
    return [str(path) for paths in found.values() for path in paths]


BEAM = code("device.py", "bases/*.py", "modal.py", "wells.py")
SOLVER = [*BEAM, *code("models.py", "lanes.py", "reference.py")]
LADDER = [*SOLVER, *code("cells.py", "protocol.py", "thresholds.py", "ladder.py")]
GRID = [*LADDER, *code("outcome.py", "grid.py")]
PLOT = code("figures/style.py", "figures/paper.mplstyle", "quantity.py", "atomic.py")
MAPS = [*code("figures/maps.py", "figures/curves.py"), *PLOT]
