#!/usr/bin/env python3
"""Writes libcpm/medium/catalogue_data.h from data/dispersion.toml, for C; Python reads the table itself.

python spectral/generate_catalogue.py [--check]      --check: exit status 1 where the file is not current
"""

import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCE = HERE / "data" / "dispersion.toml"
TARGET = HERE.parent / "libcpm" / "medium" / "catalogue_data.h"


def coefficients(entry):
    """In the order of cpm_dispersion: pairs; of a gas after the four numbers of its polynomial."""
    if entry["formula"] == "refractivity":
        return "CPM_DISPERSION_GAS", [0.0] * 4 + [v for pair in zip(entry["B"], entry["C"], strict=True) for v in pair]
    poles = entry["C"] if "C" in entry else [resonance * resonance for resonance in entry["resonance"]]
    return "CPM_DISPERSION_SELLMEIER", [v for pair in zip(entry["B"], poles, strict=True) for v in pair]


def text():
    entries = tomllib.loads(SOURCE.read_text("utf-8"))["material"]
    lines = [
        "/* medium/catalogue_data.h: made by spectral/generate_catalogue.py from spectral/data/dispersion.toml, which",
        " * has the sources. Names folded: lower case, no blanks, hyphens or underscores; after the first, aliases. */",
        '#include "dispersion.h"',
        "",
        "static const struct {",
        "    const char *names[4];",
        "    const char *label;",
        "    int32_t kind, count;",
        "    double coefficients[8];",
        "    double low, high;",
        "} published[] = {",
    ]
    for entry in entries:
        kind, values = coefficients(entry)
        names = [
            "".join(c for c in name.lower() if c not in " -_") for name in (entry["name"], *entry.get("aliases", []))
        ]
        assert len(names) <= 4 and len(values) <= 8
        quoted = ", ".join(f'"{name}"' for name in names)
        lines += [
            f"    {{{{{quoted}}},",
            f'     "{entry["name"]}",',
            f"     {kind},",
            f"     {len(values)},",
            "     {" + ", ".join(repr(float(value)) for value in values) + "},",
            f"     {float(entry['range'][0])!r},",
            f"     {float(entry['range'][1])!r}}},",
        ]
    return "/* clang-format off */\n" + "\n".join([*lines, "};"]) + "\n"


if __name__ == "__main__":
    if sys.argv[1:] == ["--check"]:
        sys.exit(
            0 if TARGET.is_file() and TARGET.read_text("utf-8") == text() else f"{TARGET}: not current; run {__file__}"
        )
    TARGET.write_text(text(), "utf-8")
