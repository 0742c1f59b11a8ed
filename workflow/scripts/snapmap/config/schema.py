"""The schema by which editors complete and check a config: config/schema.json."""

import json

from ..values.reading import schema
from .document import OF_SNAKEMAKE, Document

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def written() -> str:
    """Write the schema of a config, as JSON."""
    whole = schema(Document)
    del whole["properties"]["run"]["properties"][OF_SNAKEMAKE]
    text = json.dumps({"$schema": DIALECT} | whole, indent=1, ensure_ascii=False)
    return f"{text}\n"
