"""Print what building the wheel needs, one requirement a line: [build-system] of pyproject.toml is the only list."""

import tomllib
from pathlib import Path

pyproject = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text(encoding="utf-8"))
print(*pyproject["build-system"]["requires"], sep="\n")
