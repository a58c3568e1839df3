"""Regions of the cross-room picture, and the relative error inside each.

One number for a whole picture hides what matters here: the lit cross has most of the
energy, so its noise decides the picture's error, while the eye (and a photon map's bias)
dwells on the shade and on the outline of the light.  So the picture is split by the
*reference*, never by the image under test, and every renderer is judged on the same pixels:

========  ====================================================================
picture   every pixel
lit       reference radiance above 0.15 W/m²/sr/nm: reached by the spot itself
edge      not black, not lit, within 5 pixels of a lit pixel
shade     the other pixels that are not black: light that has bounced
========  ====================================================================

Black pixels (at most 1e-6) look out through the hole in the wall.  They count in the
picture alone, where a renderer that leaks light through the wall is caught.
"""
import numpy as np
from scipy import ndimage

LIT_ABOVE = 0.15       # W/m²/sr/nm; between the brightest shade (0.056) and the dimmest whole lit pixel (0.24)
BLACK_BELOW = 1e-6     # W/m²/sr/nm
EDGE_PIXELS = 5        # Euclidean distance between pixel centres, at 400x300

NAMES = ("picture", "lit", "shade", "edge")


def regions(reference):
    """Split a picture of the cross room.

    Parameters
    ----------
    reference : array_like, shape (H, W)
        Radiance of a converged picture in W/m²/sr/nm, one wavelength.

    Returns
    -------
    dict of str to ndarray of bool, shape (H, W)
        The masks ``picture``, ``lit``, ``shade`` and ``edge``.  The last three share no pixel.

    Raises
    ------
    ValueError
        If the reference is not a finite two-dimensional picture, or nothing in it is lit.
    """
    reference = np.asarray(reference, dtype=float)
    if reference.ndim != 2 or not np.isfinite(reference).all():
        raise ValueError(f"reference must be a finite (height, width) picture, got shape {reference.shape}")
    lit = reference > LIT_ABOVE
    if not lit.any():
        raise ValueError(f"nothing in the reference is brighter than {LIT_ABOVE} W/m²/sr/nm: "
                         "is it the cross room, in the units of the design?")
    dim = (reference > BLACK_BELOW) & ~lit
    near_lit = ndimage.distance_transform_edt(~lit) <= EDGE_PIXELS
    return {"picture": np.ones_like(lit), "lit": lit, "shade": dim & ~near_lit, "edge": dim & near_lit}


def relative_rmse(image, reference, mask, reference_variance=None):
    """Root-mean-square error over a region, relative to the region's mean radiance.

    The reference is noisy too.  Its noise and the image's are independent, so the squares
    add, and the known part is subtracted: error² = mean((image − reference)² − variance) / mean².
    The image must therefore not share random numbers with the reference.

    Parameters
    ----------
    image, reference : array_like, shape (H, W)
        Radiance in W/m²/sr/nm.
    mask : array_like of bool, shape (H, W)
        One of `regions`.
    reference_variance : array_like, shape (H, W), optional
        Variance of the reference's value in each pixel (of the mean, not of one sample).
        None: the reference is taken as exact.

    Returns
    -------
    float
        Zero where the image differs from the reference by no more than the reference's own noise:
        read it as "below what this reference can resolve", see `reference_noise`.
    """
    image, reference = np.asarray(image, dtype=float), np.asarray(reference, dtype=float)
    mask = np.asarray(mask, dtype=bool)
    if not image.shape == reference.shape == mask.shape:
        raise ValueError("image, reference and mask must have one shape, got "
                         f"{image.shape}, {reference.shape} and {mask.shape}")
    if not mask.any():
        raise ValueError("the mask selects no pixel")
    square = np.mean((image[mask] - reference[mask]) ** 2)
    if reference_variance is not None:
        square -= np.mean(np.asarray(reference_variance, dtype=float)[mask])
    return float(np.sqrt(max(square, 0.0)) / reference[mask].mean())


def reference_noise(reference, mask, reference_variance):
    """Relative RMS noise of the reference itself over a region.

    It averages out over the region's pixels: `relative_rmse` tells an error from it down to about
    this × (2 / pixels)^¼, which is a sixth in the edge and less elsewhere.
    """
    reference, mask = np.asarray(reference, dtype=float), np.asarray(mask, dtype=bool)
    return float(np.sqrt(np.mean(np.asarray(reference_variance, dtype=float)[mask])) / reference[mask].mean())
