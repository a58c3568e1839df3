#!/usr/bin/env python3
"""Background-oriented schlieren of a density field: dots behind a hot plume, their displacements, a knife-edge picture.

    python examples/bos.py [--density FILE.npy --origin X Y Z --spacing D] [--size 480x360] [-o FOLDER]

Any CFD result on a regular grid serves: an array (nx, ny, nz) in kg/m³, the corner of its first sample and the distance
between samples in metres. Without one, a plume of our own making. Writes bos.png (the dots, as the camera sees them),
bos_displacement.png and bos_schlieren.png.
"""
import argparse
from pathlib import Path

import numpy as np

import cpm

AMBIENT = 1.204            # kg/m³, air at 20 °C and 101325 Pa
EYE, WALL = 2.0, -2.0      # z of the camera and of the dots, metres; the flow is about the origin
WIDTH = 0.8                # of the field of dots, metres
COLUMNS, ROWS = 32, 24


def plume(x, y, z):
    """Density of a plume that rises along y, sways and widens: 1300 K hotter than the room on its axis; kg/m³."""
    height = y + 0.18
    sway_x, sway_z = 0.012 * np.sin(18 * height), 0.012 * np.sin(14 * height + 1)
    radius = 0.018 + 0.05 * height
    excess = 1300 * np.exp(-((x - sway_x) ** 2 + (z - sway_z) ** 2) / (2 * radius**2))
    return AMBIENT * 293 / (293 + excess)


def plume_grid(shape=(33, 37, 33), spacing=0.01):
    """The plume's samples, and the corner where they begin."""
    origin = -0.5 * spacing * (np.array(shape) - 1)
    axes = [o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True)]
    return plume(*np.meshgrid(*axes, indexing="ij")), origin, spacing


def dot_centers():
    """Where the dots are on their wall, (ROWS * COLUMNS, 2), metres."""
    pitch = WIDTH / COLUMNS
    x, y = np.meshgrid(pitch * (np.arange(COLUMNS) + 0.5) - WIDTH / 2, pitch * (np.arange(ROWS) + 0.5 - ROWS / 2))
    return np.stack([x.ravel(), y.ravel()], axis=1)


def stage(flow=None):
    """Glowing dots, a camera, and the flow between them."""
    scene = cpm.Scene(1 + cpm.media.AIR_GLADSTONE_DALE * AMBIENT)
    if flow is not None:
        scene.add_medium(flow)
    side = 0.4 * WIDTH / COLUMNS
    corners = dot_centers()[:, None] + 0.5 * side * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    vertices = np.column_stack([corners.reshape(-1, 2), np.full(4 * len(corners), WALL)])
    faces = (4 * np.arange(len(corners))[:, None, None] + [(0, 1, 2), (0, 2, 3)]).reshape(-1, 3)
    dots = scene.add_mesh(vertices, faces, cpm.materials.Black())
    scene.add_light(cpm.lights.Area(dots, 1.0))
    fov = 2 * np.degrees(np.arctan(0.5 * WIDTH / (EYE - WALL)))
    scene.camera = cpm.Camera.look_at((0, 0, EYE), (0, 0, WALL), fov=fov)
    return scene


def picture(flow=None, size=(480, 360), samples=36):
    """The dots at one wavelength; they glow, so no photons are needed."""
    return cpm.render(stage(flow), size=size, photons=1, samples=samples, wavelengths=[550.0])


def centroids(image):
    """Each dot's centre of light, (ROWS, COLUMNS, 2), pixels right and down: one window a dot."""
    height, width = image.data.shape[:2]
    rows, columns = height // ROWS, width // COLUMNS
    windows = image.data[..., 0].reshape(ROWS, rows, COLUMNS, columns).transpose(0, 2, 1, 3).astype(float)
    light = windows.sum(axis=(2, 3))
    right = (windows.sum(axis=2) @ (np.arange(columns) + 0.5)) / light + columns * np.arange(COLUMNS)
    down = (windows.sum(axis=3) @ (np.arange(rows) + 0.5)) / light + (rows * np.arange(ROWS))[:, None]
    return np.stack([right, down], axis=-1)


def schlieren(flow, size=(240, 180), cut_off=4e-4):
    """A knife edge that hides light bent to the left: brightness 0 to 1, ½ where nothing bends.

    The lens and the knife are ideal: what counts is the direction in which each ray leaves the flow. ``cut_off`` is the
    angle, rad, that takes all light away or lets all of it pass.
    """
    scene = stage(flow)
    x = ((np.arange(size[0]) + 0.5) / size[0] - 0.5) * WIDTH
    y = (0.5 - (np.arange(size[1]) + 0.5) / size[1]) * WIDTH * size[1] / size[0]
    ahead = np.stack([*np.broadcast_arrays(x, y[:, None]), np.full(size[::-1], WALL - EYE)], axis=-1).reshape(-1, 3)
    rays = cpm.trace(scene, np.broadcast_to((0, 0, EYE), ahead.shape), ahead, wavelength=550.0, rtol=1e-9,
                     until=((0, 0, WALL + 0.01), (0, 0, 1)))
    bent = rays.direction[:, 0] - ahead[:, 0] / np.linalg.norm(ahead, axis=1)
    return np.clip(0.5 + 0.5 * bent / cut_off, 0, 1).reshape(size[::-1])


def draw(displacement, path):
    """Arrows on the length of the displacement, in pixels."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4.6), layout="constrained")
    axes = figure.add_subplot()
    length = np.hypot(*np.moveaxis(displacement, -1, 0))
    shown = axes.imshow(length, cmap="viridis")
    axes.quiver(displacement[..., 0], displacement[..., 1], angles="xy", color="white", width=0.002)
    axes.set(title="where the dots went", xlabel="column of dots", ylabel="row of dots")
    figure.colorbar(shown, label="displacement, pixels")
    figure.savefig(path, dpi=100)


def main():
    def size(text):
        width, _, height = text.partition("x")
        if not (width.isdigit() and height.isdigit() and int(width) % COLUMNS == int(height) % ROWS == 0):
            raise argparse.ArgumentTypeError(f"'{text}': multiples of {COLUMNS}x{ROWS} are needed, such as 480x360")
        return int(width), int(height)

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--density", type=Path, help="kg/m³, a .npy file (nx, ny, nz)")
    parser.add_argument("--origin", type=float, nargs=3, help="of its first sample, m (default: centred)")
    parser.add_argument("--spacing", type=float, default=0.01, help="of its samples, m")
    parser.add_argument("--size", type=size, default=(480, 360))
    parser.add_argument("-o", "--output", type=Path, default=Path(), help="folder")
    options = parser.parse_args()

    density, origin, spacing = plume_grid()
    if options.density:
        density, spacing = np.load(options.density), options.spacing
        origin = options.origin or -0.5 * spacing * (np.array(density.shape) - 1)
    flow = cpm.media.Grid(density, origin, spacing, quantity="density")

    with_flow = picture(flow, options.size)
    displacement = centroids(with_flow) - centroids(picture(size=options.size))

    from matplotlib.image import imsave

    with_flow.save(options.output / "bos.png")
    draw(displacement, options.output / "bos_displacement.png")
    imsave(options.output / "bos_schlieren.png", schlieren(flow), cmap="gray", vmin=0, vmax=1)
    print(f"dots moved by up to {np.hypot(*np.moveaxis(displacement, -1, 0)).max():.2f} pixels")


if __name__ == "__main__":
    main()
