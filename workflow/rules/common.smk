def half(wildcards):
    """Half of the cores, so that other jobs go on beside one that could use them all.

    On a cluster, half of what a job may have: `cores` in profiles/slurm.
    """
    return max(1, workflow.cores // 2)


def memory(megabytes):
    return lambda wildcards, attempt: attempt * megabytes


def own_points(wildcards):
    """Path and hash of a user's own points: a function, as a path may have braces."""
    return list(study.own_points)


def views(several):
    return [view._asdict() for view in several]
