from functools import cache

once = cache(code_hash)


def half(wildcards):
    """Half of the cores, so that other jobs go on beside one that could use them all.

    On a cluster, half of what a job may have: `cores` in profiles/slurm.
    """
    return max(1, workflow.cores // 2)


def code(script):
    """Make the parameter that holds a hash of all that a script runs, found by its imports."""
    path = clone / "workflow" / "scripts" / f"{script}.py"
    return lambda wildcards: once(path)


def own_points(wildcards):
    """Path and hash of a user's own points: a function, as a path may have braces."""
    return list(study.own_points)


def calibration(wildcards):
    """What is asked of measured shots; a function likewise."""
    return study.calibration._asdict() if study.calibration else {}
