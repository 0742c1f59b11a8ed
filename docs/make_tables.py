"""Copies the tables that studies have made into docs/tables, and shows them on the pages.

./run python docs/make_tables.py

A page shows docs/tables/NAME.csv between <!-- table: NAME --> and <!-- end -->; a picture of the
same name goes to docs/pictures. Tables of a small run, or of another device, are left out.
"""

import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
from studies import tables  # noqa: E402, as only the clone has the studies

TABLES = ROOT / "docs" / "tables"
PAGES = [ROOT / "README.md", ROOT / "studies" / "impacts" / "README.md"]
PAGES += sorted((ROOT / "docs").rglob("*.md"))
BLOCK = re.compile(r"(?<=<!-- table: )(\w+)( -->\n).*?(?=<!-- end -->)", re.DOTALL)


def copy_made(folder: Path) -> None:
    """Copy tables and pictures of whole studies from a folder of results."""
    for path in sorted(folder.glob("*.csv")):
        if is_whole(path):
            shutil.copy(path, TABLES)
            if (picture := path.with_suffix(".png")).exists():
                shutil.copy(picture, ROOT / "docs" / "pictures")


def is_whole(path: Path) -> bool:
    """Whether a table was made without a further word in the command."""
    foot = tables.read(path)[1]
    return foot[5] == f"python -m studies {foot[6]}"


def shown(page: str) -> str:
    """Return the text of a page with its tables as they are in the files."""
    return BLOCK.sub(
        lambda block: f"{block[1]}{block[2]}\n{tables.markdown(TABLES / f'{block[1]}.csv')}\n", page
    )


if __name__ == "__main__":
    copy_made(Path("results/studies"))
    for page in PAGES:
        page.write_text(shown(page.read_text(encoding="utf-8")), encoding="utf-8")
