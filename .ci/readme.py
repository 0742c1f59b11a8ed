"""Run the README in the clone of the current folder, from top to bottom, as a newcomer would.

Its commands run in full, but for the tests, which CI runs apart; its Python runs in the clone, and
its config with the device of config/config.yaml. What pip installs gets an environment of its own.
"""

import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

COMMAND = re.compile(r"^    ((?:\./run|/path/to/run|pip|snapmap) .*?)(?:  +#.*)?$", re.M)
BLOCK = re.compile(r"^```(python|yaml)\n(.*?)^```", re.M | re.S)
DEVICE = re.compile(r"^device:.*\n(?:[ #].*\n)*", re.M)


def main():
    """Run each command and block; ends with status 1 at the first that fails."""
    clone, readme = Path.cwd(), Path("README.md").read_text(encoding="utf-8")
    blocks = dict(BLOCK.findall(readme))
    with TemporaryDirectory() as folder:
        study, venv = Path(folder, "a study"), Path(folder, "venv")
        study.mkdir()
        device = DEVICE.search(Path("config/config.yaml").read_text(encoding="utf-8"))[0]
        config = DEVICE.sub(lambda _: device, blocks["yaml"], count=1)
        (study / "mine.yaml").write_text(config, encoding="utf-8")
        run([sys.executable, "-m", "venv", venv], folder)
        pip = {"PATH": f"{venv}/bin{os.pathsep}{os.environ['PATH']}"}
        for command in COMMAND.findall(readme):
            if command == "./run pytest":
                continue
            place = study if "/path/to/" in command else clone
            quoted = f"'{clone}'/"
            run(["sh", "-c", command.replace("/path/to/", quoted)], place, pip)
        run(["./run", "python", "-c", blocks["python"]], clone)


def run(command, folder, variables=()):
    """Run a command in a folder, with environment variables of its own; exits if it fails."""
    print("README:", *command, flush=True)
    if done := subprocess.run(command, cwd=folder, env=os.environ | dict(variables)).returncode:
        sys.exit(f"README: {command[-1]}: status {done}")


if __name__ == "__main__":
    main()
