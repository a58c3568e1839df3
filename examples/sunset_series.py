"""The Sun goes down: a scene file rendered again and again as its Sun sinks, and the pictures put together as one strip.

    python examples/sunset_series.py examples/green_flash.toml --from -0.908 --to -0.932 --frames 7 -o green_flash.png

All frames share one exposure, so that the strip shows how fast the light goes.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from matplotlib.image import imsave

import cpm


def load_at(path, elevation):
    """The scene file with another elevation of its sun: the file is data, so its text is changed."""
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    changed = [f"elevation = {elevation:.6f}" if line.startswith("elevation") else line for line in lines]
    beside = Path(path).with_name(f".{Path(path).stem}_{elevation:+.4f}.toml")
    try:
        beside.write_text("\n".join(changed), encoding="utf-8")
        return cpm.load_scene(beside)
    finally:
        beside.unlink(missing_ok=True)


def strip(pictures, exposure, gap=4):
    """One above the other, with dark lines between; (height, width, 3) in 8 bits."""
    rgb = [np.round(255 * picture.to_rgb(exposure=exposure)).astype(np.uint8) for picture in pictures]
    line = np.full((gap, rgb[0].shape[1], 3), 48, dtype=np.uint8)
    return np.concatenate([part for picture in rgb for part in (picture, line)][:-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene")
    parser.add_argument("--from", dest="first", type=float, required=True, help="elevation of the first frame, degrees")
    parser.add_argument("--to", dest="last", type=float, required=True, help="of the last one")
    parser.add_argument("--frames", type=int, default=7)
    parser.add_argument("--size", type=lambda text: tuple(int(part) for part in text.split("x")))
    parser.add_argument("--percentile", type=float, default=90.0, help="of the lit pixels of the middle frame that is white")
    parser.add_argument("-o", "--output", default="sunset_series.png")
    asked = parser.parse_args()
    pictures = []
    for elevation in np.linspace(asked.first, asked.last, asked.frames):
        start = time.perf_counter()
        pictures.append(cpm.render(load_at(asked.scene, elevation), size=asked.size, progress=False))
        print(f"elevation {elevation:+.4f} degrees: {time.perf_counter() - start:.1f} s", file=sys.stderr)
    luminance = pictures[len(pictures) // 2].to_xyz()[..., 1]
    exposure = 1.0 / np.percentile(luminance[luminance > 0], asked.percentile)
    imsave(asked.output, strip(pictures, exposure))


if __name__ == "__main__":
    main()
