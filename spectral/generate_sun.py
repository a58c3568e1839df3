"""Averages a table of solar irradiance for spectral/data/sun.toml: python generate_sun.py e490-00a_2014_hires.csv

The table has two columns, micrometres and W/m2/um; what is printed are W/m2/nm, means over 5 nm of the line that joins
its points, at 250 to 1300 nm.
"""

import sys

import numpy as np

STEP = 5.0


def averaged(wavelengths, values, centres):
    """Means of a piecewise linear function over STEP about each centre."""
    knots = np.unique(np.concatenate([wavelengths, centres - 0.5 * STEP, centres + 0.5 * STEP]))
    y = np.interp(knots, wavelengths, values)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(knots))])
    ends = [np.searchsorted(knots, centres + side * STEP) for side in (-0.5, 0.5)]
    return (area[ends[1]] - area[ends[0]]) / STEP


if __name__ == "__main__":
    with open(sys.argv[1]) as file:
        table = np.array([line.split() for line in file if line[0].isdigit()], dtype=float)
    values = averaged(1e3 * table[:, 0], 1e-3 * table[:, 1], np.arange(250.0, 1301.0, STEP))
    for i in range(0, values.size, 12):
        print("    " + ", ".join(f"{value:.4f}" for value in values[i : i + 12]) + ",")
