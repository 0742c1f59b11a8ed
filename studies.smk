# All studies, whose tables docs/make_tables.py shows on the pages. Run it in the clone.
import sys
from pathlib import Path

sys.path.insert(0, workflow.basedir)
from snapmap.study.provenance import NUMBERS, code_hash
from studies.__main__ import NAMES, SLOW


rule all:
    input:
        [f"results/studies/{name}.md" for name in NAMES if name not in SLOW],


rule all_slow:
    input:
        [f"results/studies/{name}.md" for name in NAMES],


rule study:
    output:
        "results/studies/{name}.md",
    wildcard_constraints:
        name="|".join(NAMES),
    params:
        code=code_hash(*NUMBERS, Path(workflow.basedir) / "studies"),
    shell:
        "python -m studies {wildcards.name} > {output}"
