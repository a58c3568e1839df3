"""Radiosonde files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from .. import air
from ._profile import geometric
from .table import Table

# A column's name in the header, in capitals, to what it is.
_NAMES = {
    "PRES": "p",
    "PRESSURE": "p",
    "P": "p",
    "HGHT": "h",
    "HEIGHT": "h",
    "H": "h",
    "TEMP": "T",
    "TEMPERATURE": "T",
    "T": "T",
    "DWPT": "dew",
    "DEWPT": "dew",
    "TD": "dew",
    "RELH": "rh",
    "RH": "rh",
}


def read_sounding(path: str | os.PathLike[str], interpolation: str = "linear") -> Table:
    """Reads a radiosonde's levels from a text file.

    Parameters
    ----------
    path : path
        The University of Wyoming's text list (weather.uwyo.edu, "Text: List"), or any table with a line of column
        names: PRES (hPa), HGHT (m, geopotential), TEMP (°C), and DWPT (dew point, °C) or RELH (%); others are ignored.
        Columns are separated by blanks or commas; in Wyoming's lists, which leave fields blank, by their width.
    interpolation : {"linear", "monotone"}
        See :class:`Table`.

    Returns
    -------
    Table
        Levels without a temperature are left out, so are levels at the height of the one before. Levels without
        humidity are dry. Heights are converted from geopotential to geometric ones.

    Raises
    ------
    ValueError
        One line with the file, the line's number and what is wrong there.
    """
    path = Path(path)
    try:
        lines = path.read_text("utf-8", errors="replace").splitlines()
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from None
    number, columns, ends = _header(path, lines)
    rows = _rows(path, lines, number, columns, ends)
    if len(rows) < 2:
        raise ValueError(f"{path}: {len(rows)} levels with pressure, height and temperature; at least 2 are needed")
    table = np.array([row[1] for row in rows])
    kept = np.concatenate([[True], np.diff(table[:, 1]) != 0])
    p, h, celsius, humidity = table[kept].T
    where = [row[0] for row, keep in zip(rows, kept, strict=True) if keep]
    for values, name, direction in ((h, "height", 1), (p, "pressure", -1)):
        wrong = np.flatnonzero(~(direction * np.diff(values) > 0))
        if wrong.size:
            i = int(wrong[0]) + 1
            raise ValueError(
                f"{path}, line {where[i]}: {name} is {values[i]:g} after {values[i - 1]:g}; "
                f"it must {'rise' if direction > 0 else 'fall'} from level to level"
            )
    try:
        return Table(geometric(h), celsius + 273.15, 100.0 * p, humidity, interpolation)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def _header(path: Path, lines: list[str]) -> tuple[int, list[str], list[int] | None]:
    """Line index of the column names, what each column is, and their ends where they are columns of fixed width."""
    for number, line in enumerate(lines):
        words = line.replace(",", " ").upper().split()
        columns = [_NAMES.get(word, "") for word in words]
        if {"p", "h", "T"} <= set(columns):
            fixed = "," not in line and number + 1 < len(lines) and "hpa" in lines[number + 1].lower().split()
            ends = None
            if fixed:
                position, ends = 0, []
                for word in words:
                    position = line.upper().index(word, position) + len(word)
                    ends.append(position)
            return number, columns, ends
    raise ValueError(f"{path}: no line names the columns PRES, HGHT and TEMP")


def _rows(
    path: Path, lines: list[str], header: int, columns: list[str], ends: list[int] | None
) -> list[tuple[int, tuple[float, float, float, float]]]:
    """(line number, (p hPa, h m, T °C, relative humidity)) of each level that has the first three."""
    rows = []
    for number, line in enumerate(lines[header + 1 :], start=header + 2):
        text = line.split("#")[0].rstrip()
        if not text.strip() or set(text.strip()) <= set("-= "):
            continue
        if text.lower().replace(",", " ").split()[0] == "hpa":
            continue
        if not (text.strip()[0].isdigit() or text.strip()[0] in "-+.,"):
            break  # what follows the table: indices, the end of the HTML element
        if ends is not None:
            fields = [text[start:end].strip() for start, end in zip([0, *ends[:-1]], ends, strict=True)]
        else:
            fields = text.split(",") if "," in text else text.split()
        values = {}
        for column, field in zip(columns, fields, strict=False):
            if column and field.strip():
                try:
                    values[column] = float(field)
                except ValueError:
                    raise ValueError(f"{path}, line {number}: {field.strip()!r} is not a number") from None
        if not {"p", "h", "T"} <= set(values):
            continue
        rows.append((number, (values["p"], values["h"], values["T"], _humidity(values))))
    return rows


def _humidity(values: dict[str, float]) -> float:
    """From the dew point where there is one, as it has more digits."""
    if "dew" in values:
        t = np.array([values["dew"], values["T"]]) + 273.15
        vapour = air.saturation_pressure(t)
        return float(vapour[0] / vapour[1])
    return 0.01 * values.get("rh", 0.0)
