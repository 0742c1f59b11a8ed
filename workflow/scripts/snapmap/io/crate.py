"""A finished study in one file that says what it is: a Workflow Run RO-Crate."""

import hashlib
import importlib
import os
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from io import StringIO
from pathlib import Path

import netCDF4
import yaml

from .. import __version__
from .atomic import replacing
from .provenance import KEYWORDS, code_version

CODE = ("Snakefile", "workflow/**/*", "profiles/default/profile.yaml")
CODE += ("run", "requirements.lock", "pyproject.toml", "README.md", "LICENSE", "CITATION.cff")
PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": ("Process Run Crate", "0.5"),
    "https://w3id.org/ro/wfrun/workflow/0.5": ("Workflow Run Crate", "0.5"),
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": ("Workflow RO-Crate", "1.0"),
}
BIOSCHEMAS = "https://bioschemas.org/profiles/ComputationalWorkflow/1.0-RELEASE"
TERMS = "https://w3id.org/ro/terms/workflow-run/context"
"""Has `sha256`, which RO-Crate 1.1 has not."""
KINDS = {
    ".csv": "text/csv",
    ".html": "text/html",
    ".js": "text/javascript",
    ".md": "text/markdown",
    ".nc": "application/x-netcdf",
    ".pdf": "application/pdf",
    ".png": "image/png",
    ".py": "text/x-python",
    ".svg": "image/svg+xml",
    ".yaml": "application/yaml",
}
"""Formats by ending: Python's own table differs with its version and its host."""
ABSENT = (
    "rocrate: is not installed; ./run uv pip install --require-hashes "
    "--requirements requirements-publish.lock"
)


def write_crate(
    path: str | Path,
    project: Path,
    config: Mapping,
    named: Sequence[str],
    results: Sequence[str],
) -> None:
    """Pack a finished study, with its config and the code, into a zip that can be run again.

    project: folder of the Snakefile; named: files that the config names, in the current folder
    results: files of the run, of which one is the cube
    Raises ValueError, one line, where `rocrate` is absent or a named file lies elsewhere.
    """
    crate = _empty_crate()
    cube = next(result for result in results if Path(result).name == "cube.nc")
    with netCDF4.Dataset(cube) as dataset:
        origin = {key: dataset.getncattr(key) for key in ("history", "packages", "python")}
    for file in _code(project):
        _add(crate, file, file.relative_to(project).as_posix())
    text = yaml.safe_dump(dict(config), sort_keys=False, allow_unicode=True)
    asked = [_add(crate, StringIO(text), "config.yaml")]
    asked += [_add(crate, file, _inside(file)) for file in named]
    made = [_add(crate, file, file) for file in results]
    workflow = _workflow(crate, project, origin)
    about = {
        "name": "Run of the study",
        "description": f"{origin['history']}, Python {origin['python']}",
        "actionStatus": "http://schema.org/CompletedActionStatus",
    }
    action = crate.add_action(workflow, "#run", asked if named else asked[0], made, about)
    _describe(crate, action, cube)
    with replacing(path) as temporary:
        crate.write_zip(temporary)


def _empty_crate():
    try:
        library = importlib.import_module("rocrate.rocrate")
    except ModuleNotFoundError as error:
        raise ValueError(ABSENT) from error
    return library.ROCrate(version="1.1")


def _code(project) -> Iterator[Path]:
    for pattern in CODE:
        for path in sorted(project.glob(pattern)):
            if path.is_file() and "__pycache__" not in path.parts:
                yield path


def _inside(file):
    """The path itself, if it leads to the same file wherever the crate is unpacked."""
    if os.path.isabs(file) or ".." in Path(file).parts:
        raise ValueError(f"{file}: lies outside the study's folder; copy it there, and name it so")
    return file


def _add(crate, source, place):
    """Add a file with its checksum."""
    if isinstance(source, StringIO):
        content = source.getvalue().encode()
        digest, size = hashlib.sha256(content).hexdigest(), len(content)
    else:
        with open(source, "rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        size = os.stat(source).st_size
    kind = KINDS.get(Path(place).suffix, "text/plain")
    about = {"name": place, "sha256": digest, "contentSize": str(size), "encodingFormat": kind}
    return crate.add_file(source, place, properties=about)


def _workflow(crate, project, origin):
    """The Snakefile as what was run, with the packages that it ran with."""
    packages = iter(origin["packages"].split())
    versions = dict(zip(packages, packages, strict=True))
    about = dict(crate.get("Snakefile").properties())
    del about["@type"]
    about |= {"name": "snapmap", "version": code_version(), "conformsTo": {"@id": BIOSCHEMAS}}
    written = {"lang": "snakemake", "lang_version": versions.pop("snakemake"), "main": True}
    source = project / "Snakefile"
    workflow = crate.add_workflow(source, "Snakefile", properties=about, **written)
    for name, version in (versions | {"python": origin["python"]}).items():
        about = {"@type": "SoftwareApplication", "name": name, "softwareVersion": version}
        workflow.append_to("softwareRequirements", crate.add_jsonld({"@id": f"#{name}", **about}))
    return workflow


def _describe(crate, action, cube):
    """Say what the whole is, and which profiles it keeps to."""
    day = float(os.environ.get("SOURCE_DATE_EPOCH") or os.stat(cube).st_mtime)
    root = crate.root_dataset
    root["name"] = "Snap-through of a bistable beam under shock"
    root["description"] = f"A study by snapmap {__version__}: config, code and results"
    root["keywords"] = KEYWORDS
    root["datePublished"] = datetime.fromtimestamp(day, UTC).date().isoformat()
    root["license"] = crate.get("LICENSE")
    root["mentions"] = action
    crate.get("README.md")["about"] = root
    for place, (name, version) in PROFILES.items():
        profile = {"@id": place, "@type": "CreativeWork", "name": name, "version": version}
        root.append_to("conformsTo", crate.add_jsonld(profile))
    crate.metadata.extra_contexts.append(TERMS)
