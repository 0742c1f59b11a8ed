"""Speed and error of every model, beside what a user could take instead, as a Markdown report.

PYTHONPATH=workflow/scripts ./run python benchmarks/compare.py [--small] [--out report.md]

SciPy and heyoka take part if they are installed: see the group `bench` in pyproject.toml.
"""

import argparse
from pathlib import Path

from report import sections

from snapmap.config.devices import load_device
from studies.few import SMALL

ROOT = Path(__file__).resolve().parents[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, help="file to write the report to as well")
    parser.add_argument(SMALL, action="store_true", help="a few cells, to see that it runs")
    out = parser.parse_args().out
    report = []
    for section in sections(load_device(ROOT / "config" / "config.yaml")):
        print(section, flush=True)
        report.append(section)
    if out:
        out.write_text("\n".join(report), encoding="utf-8")


if __name__ == "__main__":
    main()
