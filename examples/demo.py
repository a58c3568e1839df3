"""The paper's room, homogeneous and curved: pictures, photon maps, curved rays, and a table of what it cost.

    python examples/demo.py [--output FOLDER] [--photons N] [--size WxH]

Writes, for each of the two rooms, NAME.exr (16 spectral bins) and NAME.png, NAME_photons.png (figures 2 and 4 of the
paper) and NAME_rays.png (paths from the spot in a section of the room).
"""
from __future__ import annotations

import argparse
import resource
from pathlib import Path

import cpm
from cpm.image import auto_exposure
from cpm.photon_picture import photon_picture
from cpm.ray_picture import ray_picture

HERE = Path(__file__).resolve().parent
ROOMS = ("cross_room_homogeneous", "cross_room_curved")
EXPOSURE = 0.7  # of the default: the lit cross just below white, so that its grain shows

STAGES = ("prepare", "project", "trace", "map", "gather", "total")
COUNTS = ("photons_emitted", "photons_stored_direct", "photons_stored_later", "photons_stored_caustic", "eye_rays")


def render_room(name: str, output: Path, options: dict[str, object],
                exposure: float | None) -> tuple[dict[str, object], float]:
    """Render one room with everything drawn beside it; its stats and exposure."""
    scene = cpm.load_scene(HERE / f"{name}.toml")
    print(f"{name}: photons and picture")
    image = cpm.render(scene, progress=True, **options)
    image.save(output / f"{name}.exr")
    exposure = exposure or EXPOSURE * auto_exposure(image.to_xyz()[..., 1])
    image.save(output / f"{name}.png", exposure=exposure, white="E")
    print(f"{name}: photon map and rays")
    dots = {key: value for key, value in options.items() if key == "size"}
    photon_picture(scene, progress=True, **dots).save(output / f"{name}_photons.png")
    ray_picture(scene, rays=31, title=name).savefig(output / f"{name}_rays.png", dpi=110)
    return image.stats, exposure


def table(columns: dict[str, dict[str, object]]) -> str:
    """Seconds a stage, work done, what was left out."""
    rows = [("", *columns)]
    rows += [(f"{stage}, s", *(f"{s[f'seconds_{stage}']:.3f}" for s in columns.values())) for stage in STAGES]
    rows += [(key.replace("_", " "), *(f"{s[key]:,}" for s in columns.values())) for key in COUNTS]
    rows.append(("gradient evaluations", *(f"{s['photon_evaluations'] + s['eye_evaluations']:,}"
                                           for s in columns.values())))
    rows.append(("caustic map, bytes", *(f"{s['bytes_caustic']:,}" for s in columns.values())))
    width = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(width[i]) if i == 0 else cell.rjust(width[i]) for i, cell in enumerate(row))
             for row in rows]
    lines += [f"left out of {name}: {', '.join(s['left_out']) or 'nothing'}" for name, s in columns.items()]
    return "\n".join(lines)


def size(text: str) -> tuple[int, int]:
    """400x300 as (400, 300); argparse says what is wrong."""
    try:
        width, height = map(int, text.lower().split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a size such as 400x300") from None
    return width, height


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("build/demo"), help="folder for the pictures (default: build/demo)")
    parser.add_argument("--photons", type=int, help="paths emitted (default: the scenes', 3 000 000)")
    parser.add_argument("--size", type=size, help="pixels, 400x300")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    options = {key: value for key, value in (("photons", args.photons), ("size", args.size)) if value is not None}
    stats: dict[str, dict[str, object]] = {}
    exposure = None  # the first room's serves both
    for name in ROOMS:
        stats[name], exposure = render_room(name, args.output, options, exposure)
    print("\n" + table(stats))
    ratio = stats[ROOMS[1]]["seconds_total"] / stats[ROOMS[0]]["seconds_total"]
    print(f"curved over homogeneous: {ratio:.2f} (the paper: 1.85)")
    print(f"peak memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GiB")
    print(f"pictures in {args.output}/")


if __name__ == "__main__":
    main()
