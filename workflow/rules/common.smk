from functools import cache

once = cache(code_hash)


def code(script):
    """Make the parameter that holds a hash of all that a script runs, found by its imports."""
    path = Path(workflow.basedir) / "workflow" / "scripts" / f"{script}.py"
    return lambda wildcards: once(path)
