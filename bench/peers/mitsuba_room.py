#!/usr/bin/env python3
"""Error against run time of Mitsuba 3's path tracer in the homogeneous cross room.

The straight-ray peer of ``bench room``: geometry, light, camera and paints of the design's
section "The cross room", one wavelength (620 nm), so that its radiance compares with one
spectral bin of ours.  There is no peer for the curved room: Mitsuba has no curved rays.

What it writes
--------------
One JSON object a line.  First the reference (file, samples per pixel, seconds, and its own noise by
region), then one line for each picture: samples per pixel, seed, seconds, relative RMSE by region
(see regions.py; the reference's noise is taken out in quadrature) and mean radiance.
Seconds are wall clock with kernels compiled and scene built beforehand.

The reference file
------------------
Made when it is not there, about eight minutes on two cores.  A NumPy .npz of ``mean`` (H, W) radiance in
W/m²/sr/nm, ``variance`` (H, W) of that mean, from the scatter of its chunks, ``spp``, ``chunks``,
``seconds``, ``renderer``, ``wavelength`` (nm), ``source``, and ``halves``: the mean square of half the
difference between the first and the second half of the chunks, over the mean of ``variance``.  That is
1 if the chunks are independent.

Installing it on Debian 12
--------------------------
    python3 -m venv venv && venv/bin/pip install mitsuba numpy scipy
    apt-get install libllvm19

The wheel has no LLVM: Dr.Jit loads libLLVM at run time (19, where it was tried beside 14 and 15).  The
version matters.  Debian 12 also has 14, 15 and 16: Dr.Jit 1.5 refuses 14, and 15 and 16 abort with this scene
on CPUs with AVX-512 ("Cannot select: fminimum").  19 and 22 run, within 4 % as fast.  If the right one is not
found, DRJIT_LIBLLVM_PATH names it.

Examples
--------
    mitsuba_room.py --reference room.npz --spp                      # make the reference, nothing else
    mitsuba_room.py --reference room.npz --spp 4 16 64 --seeds 3    # three pictures for each
"""
import argparse
import json
import os
import sys
import time
import zipfile
from pathlib import Path

try:
    import numpy as np

    from regions import NAMES, reference_noise, regions, relative_rmse
except ImportError as missing:
    sys.exit(f"mitsuba_room: {missing.name} is not installed: pip install mitsuba numpy scipy")

WIDTH, HEIGHT = 400, 300
WAVELENGTH = 620.0                                   # nm, where the paints are specified
WHITE, RED, GREEN = 0.75, 0.60, 0.15                 # reflectance there
OLDEST_LLVM = 17                                     # tried: 15 and 16 abort, 19 and 22 run
REFERENCE_SEED = 1_000_000                           # far from the sweep's 0, 1, …: no shared random numbers
REFERENCE_KEYS = ("mean", "variance", "spp", "chunks", "seconds", "halves", "renderer", "wavelength")


def cross_wall():
    """Rectangles (y0, y1, z0, z1) in metres that tile the left wall around its cross-shaped hole."""
    # Bottom to top, (y0, y1, half-width of the hole in z); no hole below 0.8 m and above 3.2 m.
    bands = [(0.0, 0.8, 0.0), (0.8, 1.7, 0.3), (1.7, 2.3, 1.2), (2.3, 3.2, 0.3), (3.2, 4.0, 0.0)]
    for y0, y1, hole in bands:
        if hole == 0.0:
            yield y0, y1, -2.0, 2.0
        else:
            yield y0, y1, -2.0, -hole
            yield y0, y1, hole, 2.0


def room():
    """Corners of the room's quads, (N, 4, 3) in metres with y up, by reflectance."""
    low, high = -2.0, 2.0
    floor, ceiling = ([(low, y, low), (low, y, high), (high, y, high), (high, y, low)] for y in (0.0, 4.0))
    right = [(high, 0, low), (high, 0, high), (high, 4, high), (high, 4, low)]
    back, front = ([(low, 0, z), (high, 0, z), (high, 4, z), (low, 4, z)] for z in (low, high))
    left = [[(low, y0, z0), (low, y1, z0), (low, y1, z1), (low, y0, z1)] for y0, y1, z0, z1 in cross_wall()]
    quads = {WHITE: [floor, ceiling, right, *left], RED: [back], GREEN: [front]}
    return {reflectance: np.array(corners, dtype=np.float32) for reflectance, corners in quads.items()}


def load_mitsuba(threads=None):
    """Import Mitsuba with its vectorised one-wavelength variant, or exit with one line that says what to do."""
    try:
        import drjit
        import mitsuba
    except ImportError as error:
        sys.exit(f"mitsuba_room: {error.name or error} is not installed: pip install mitsuba")
    try:
        mitsuba.set_variant("llvm_ad_mono")
    except ImportError:
        sys.exit("mitsuba_room: no usable libLLVM: install libllvm19 (Debian 12), or set DRJIT_LIBLLVM_PATH")
    version = drjit.detail.llvm_version()
    # Refused here because the abort that would follow says nothing that helps.
    if version[0] < OLDEST_LLVM:
        sys.exit(f"mitsuba_room: LLVM {version[0]} is too old (needs {OLDEST_LLVM}): install libllvm19 (Debian 12)")
    if threads is not None:
        drjit.set_thread_count(threads)
    return mitsuba, drjit


def quads_mesh(mitsuba, name, corners, reflectance):
    """One two-triangle-per-quad mesh with a diffuse paint on both sides."""
    paint = mitsuba.load_dict({"type": "twosided", "paint": {"type": "diffuse", "reflectance": reflectance}})
    properties = mitsuba.Properties()
    properties["mesh_bsdf"] = paint
    mesh = mitsuba.Mesh(name, vertex_count=4 * len(corners), face_count=2 * len(corners), props=properties)
    first = 4 * np.arange(len(corners), dtype=np.uint32)[:, None]
    faces = np.concatenate([first + np.uint32([0, 1, 2]), first + np.uint32([0, 2, 3])])
    buffers = mitsuba.traverse(mesh)
    buffers["vertex_positions"] = corners.ravel()
    buffers["faces"] = faces.ravel()
    buffers.update()
    return mesh


def build_scene(mitsuba):
    """The room, its spot and its camera as a Mitsuba scene."""
    def look_at(origin, target):
        return mitsuba.ScalarTransform4f().look_at(origin=origin, target=target, up=[0, 1, 0])

    meshes = {f"quads{i}": quads_mesh(mitsuba, f"quads{i}", corners, reflectance)
              for i, (reflectance, corners) in enumerate(room().items())}
    return mitsuba.load_dict({
        "type": "scene",
        # Sixty-four bounces leave 0.75^64 = 1e-8 of the light out: nothing beside the noise.
        "integrator": {"type": "path", "max_depth": 64, "rr_depth": 16},
        # beam_width = cutoff_angle: uniform inside the cone, no fall-off.
        "spot": {"type": "spot", "intensity": 100.0, "cutoff_angle": 14.0, "beam_width": 14.0,
                 "to_world": look_at([-5, 6.5, 0], [-2, 2.35, 0])},
        "camera": {"type": "perspective", "fov": 70.0, "fov_axis": "x",
                   "to_world": look_at([1.85, 3.0, 1.85], [-1.2, 0.6, -0.9]),
                   "sampler": {"type": "independent"},
                   # The box filter keeps pixels independent; a pixel is the mean over its square, as ours is.
                   "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"},
                            "pixel_format": "luminance", "component_format": "float32"}},
        **meshes,
    })


def render(mitsuba, scene, spp, seed):
    """Radiance (H, W) in W/m²/sr/nm, row 0 on top, and the seconds it took."""
    start = time.perf_counter()
    image = np.array(mitsuba.render(scene, spp=spp, seed=seed))[..., 0]   # np.array waits for the kernel
    return image, time.perf_counter() - start


def make_reference(mitsuba, scene, spp, chunk_spp):
    """Render a reference in chunks of ``chunk_spp`` with a seed each; returns what the .npz file holds."""
    chunks = max(4, -(-spp // chunk_spp))
    chunks += chunks % 2                              # two halves of one size
    half_sums = np.zeros((2, HEIGHT, WIDTH))
    squares = np.zeros((HEIGHT, WIDTH))
    start = time.perf_counter()
    for i in range(chunks):
        image = render(mitsuba, scene, chunk_spp, REFERENCE_SEED + i)[0].astype(float)
        half_sums[2 * i // chunks] += image
        squares += image ** 2
        if sys.stderr.isatty():
            print(f"\rreference: {(i + 1) * chunk_spp} of {chunks * chunk_spp} samples per pixel, "
                  f"{time.perf_counter() - start:.0f} s", end="\n" if i == chunks - 1 else "",
                  file=sys.stderr, flush=True)
    mean = half_sums.sum(axis=0) / chunks
    # float64 sums of a few dozen float32 values with 1 % scatter: the textbook formula loses nothing that counts.
    variance = np.maximum(squares / chunks - mean ** 2, 0.0) / (chunks - 1)
    half_difference = (half_sums[0] - half_sums[1]) / chunks
    return {"mean": mean.astype(np.float32), "variance": variance.astype(np.float32),
            "spp": chunks * chunk_spp, "chunks": chunks, "seconds": time.perf_counter() - start,
            "halves": np.mean(half_difference ** 2) / np.mean(variance),
            "renderer": f"mitsuba {mitsuba.__version__} path llvm_ad_mono", "wavelength": WAVELENGTH,
            "source": "made by bench/peers/mitsuba_room.py; Apache-2.0"}


def load_reference(path):
    """The reference in a file as a dict, 0-d arrays as scalars; exits with one line if it is not one."""
    try:
        with np.load(path) as file:
            reference = {key: file[key] if file[key].ndim else file[key].item() for key in file.files}
        missing = [key for key in REFERENCE_KEYS if key not in reference]
        if missing:
            raise ValueError(f"it has no {', '.join(missing)}")
        if not reference["mean"].shape == reference["variance"].shape == (HEIGHT, WIDTH):
            raise ValueError(f"mean has shape {reference['mean'].shape}, not {(HEIGHT, WIDTH)}")
    except (OSError, EOFError, AttributeError, TypeError, ValueError, zipfile.BadZipFile) as error:
        sys.exit(f"mitsuba_room: {path} is not a reference picture: {error}")
    return reference


def save_reference(path, reference):
    """Write beside, then rename: an interrupted run leaves no half a file behind."""
    beside = path.with_name(f".{path.stem}.{os.getpid()}.npz")
    try:
        np.savez_compressed(beside, **reference)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def rounded(value):
    """Five significant digits: more than the noise leaves, and lines that can be read."""
    return float(f"{value:.5g}")


def describe_reference(path, reference, masks):
    """The JSON line of the reference."""
    value, variance = reference["mean"], reference["variance"]
    noise = {name: rounded(reference_noise(value, masks[name], variance)) for name in NAMES}
    mean = {name: rounded(value[masks[name]].mean(dtype=float)) for name in NAMES}
    share = {name: rounded(masks[name].mean()) for name in NAMES}
    facts = {key: reference[key] for key in ("renderer", "wavelength", "spp", "chunks")}
    return {"reference": path.name, **facts,
            "seconds": rounded(reference["seconds"]), "halves": rounded(reference["halves"]), "noise": noise,
            "mean": mean, "share": share}


def sweep(mitsuba, drjit, scene, reference, masks, spps, seeds):
    """Yield the JSON line of each picture."""
    llvm = ".".join(map(str, drjit.detail.llvm_version()))
    render(mitsuba, scene, 1, seed=seeds)             # compiles the kernel, the same one for every sample count
    for spp in spps:
        for seed in range(seeds):
            image, seconds = render(mitsuba, scene, spp, seed)
            error = {name: rounded(relative_rmse(image, reference["mean"], masks[name], reference["variance"]))
                     for name in NAMES}
            yield {"peer": "mitsuba path", "version": mitsuba.__version__, "llvm": llvm,
                   "threads": drjit.thread_count(), "spp": spp, "seed": seed, "seconds": rounded(seconds),
                   "relative_rmse": error, "mean": rounded(image.mean(dtype=float))}


def positive(text):
    """An argparse type: an integer of at least 1."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{value} is not at least 1")
    return value


def parse_arguments(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--reference", type=Path, required=True, metavar="FILE.npz",
                        help="the converged picture; made first if it is not there")
    parser.add_argument("--reference-spp", type=positive, default=8192, metavar="N",
                        help="samples per pixel of a reference to be made (default: %(default)s)")
    parser.add_argument("--chunk-spp", type=positive, default=256, metavar="N",
                        help="samples per pixel of the reference rendered at once (default: %(default)s)")
    parser.add_argument("--spp", type=positive, nargs="*", default=[1, 4, 16, 64, 256], metavar="N",
                        help="samples per pixel of the pictures to time; none: reference only "
                             "(default: 1 4 16 64 256)")
    parser.add_argument("--seeds", type=positive, default=1, metavar="N",
                        help="pictures for each sample count, with seeds 0 to N-1 (default: %(default)s)")
    parser.add_argument("--threads", type=positive, metavar="N",
                        help="threads of the renderer (default: all cores)")
    parser.add_argument("--output", type=Path, metavar="FILE",
                        help="write the JSON lines here (default: standard output)")
    options = parser.parse_args(arguments)
    if options.reference.suffix != ".npz":
        parser.error(f"argument --reference: {options.reference} must end in .npz")
    # Found out now, not after ten minutes of rendering.
    for path in (options.reference, options.output):
        if path is not None and not path.parent.is_dir():
            parser.error(f"{path}: there is no folder {path.parent}")
    return options


def main():
    options = parse_arguments()
    # Read before Mitsuba is loaded: a bad file should not cost seconds.
    reference = load_reference(options.reference) if options.reference.exists() else None
    mitsuba, drjit = load_mitsuba(options.threads)
    scene = build_scene(mitsuba)
    if reference is None:
        reference = make_reference(mitsuba, scene, options.reference_spp, options.chunk_spp)
        save_reference(options.reference, reference)
    masks = regions(reference["mean"])
    output = options.output.open("w", encoding="utf-8") if options.output else sys.stdout
    print(json.dumps(describe_reference(options.reference, reference, masks)), file=output, flush=True)
    for line in sweep(mitsuba, drjit, scene, reference, masks, options.spp, options.seeds):
        print(json.dumps(line), file=output, flush=True)


if __name__ == "__main__":
    main()
