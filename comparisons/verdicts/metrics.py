"""How far two pictures are apart. Everything is NumPy fp64; finiteness is counted before anything else is computed.

Whole-image scores (SSIM, PSNR, FLIP) hide missed roots: they are shown, never gated on. What counts are maxima,
quantiles, failing pixels and mismatches of hit and object.
"""

from __future__ import annotations

import numpy as np

from raytruth.reference_tracer.tracer.render import UNDECIDED

VISIBLE = 1 / 255  # one step of an 8-bit picture
GRAZING = 0.2  # cosine between ray and normal below which a pixel belongs to a silhouette
WORST, APART = 10, 12  # worst pixels told of a picture, and how far they lie from each other in rows or columns
NEIGHBOURS = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]

Planes = dict[str, np.ndarray]


def interior(planes: Planes) -> np.ndarray:
    """Pixels away from silhouettes: one object fills their 3 x 3 neighbourhood, and no ray there grazes it. (h, w)

    There a renderer of finite precision or resolution has no excuse for another hit.
    """
    index, normal, position = planes["index"], planes["normal"], planes["position"]
    with np.errstate(invalid="ignore"):
        ray = position - planes["camera"]
        cosine = np.abs(np.sum(ray * normal, axis=-1)) / np.linalg.norm(ray, axis=-1)
        steep = ~(cosine <= GRAZING) | (index < 0)
    return everywhere_around(steep) & uniform_around(index)


def neighbours(plane: np.ndarray):
    """`plane` itself and moved by a pixel in each of eight directions: what stands around every pixel. 9 of (h, w)"""
    padded = np.pad(plane, 1, mode="edge")
    h, w = plane.shape
    for i, j in NEIGHBOURS:
        yield padded[1 + i:1 + i + h, 1 + j:1 + j + w]


def largest_around(plane: np.ndarray) -> np.ndarray:
    """The largest value in the 3 x 3 neighbourhood of every pixel. (h, w)"""
    return np.maximum.reduce(list(neighbours(plane)))


def everywhere_around(mask: np.ndarray) -> np.ndarray:
    return np.logical_and.reduce(list(neighbours(mask)))


def uniform_around(plane: np.ndarray) -> np.ndarray:
    """Pixels whose 3 x 3 neighbourhood has one value. (h, w)"""
    return np.logical_and.reduce([neighbour == plane for neighbour in neighbours(plane)])


def geometry(reference: Planes, test: Planes) -> dict[str, float | int | None]:
    """Hit/miss and object mismatches in pixels; depth errors relative to the depth, normals in degrees.

    Depth and normals are compared on interior pixels where both sides hit the same object.
    """
    inner = reference["interior"] if "interior" in reference else interior(reference)
    hit_reference, hit_test = reference["index"] >= 0, test["index"] >= 0
    same = reference["index"] == test["index"]
    both = inner & same & hit_reference
    depth = np.abs(test["t"][both] - reference["t"][both]) / reference["t"][both]
    # 2 asin(|a - b| / 2) keeps its digits for small angles, unlike acos of the dot product
    chord = np.linalg.norm(test["normal"][both] - reference["normal"][both], axis=-1)
    angle = np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1)))
    return {"pixels": int(inner.size), "interior pixels": int(inner.sum()),
            "hit pixels": int(hit_reference.sum()), "interior hit pixels": int((inner & hit_reference).sum()),
            "undecided pixels": int((reference["status"] == UNDECIDED).sum()),
            "hit/miss mismatches": int((hit_reference != hit_test).sum()),
            "object mismatches": int((~same).sum()),
            "interior mismatches": int((inner & ~same).sum()),
            "depth p99": _quantile(depth, 0.99), "depth max": _maximum(depth),
            "normal p99 degrees": _quantile(angle, 0.99), "normal max degrees": _maximum(angle)}


def picture(reference: Planes, test: Planes) -> dict[str, float | int | None]:
    """Differences of colour, and scores of the whole image."""
    a, b = reference["color"], test["color"]
    measured, finite = differences(reference, test), np.isfinite(a).all() and np.isfinite(b).all()
    return {**measured, **({"SSIM": _ssim(a, b), "FLIP mean": _flip(a, b)} if finite else {"SSIM": None, "FLIP mean": None})}


def differences(reference: Planes, test: Planes) -> dict[str, float | int | None]:
    """Differences of colour. A pixel's error is the largest over its channels."""
    a, b = reference["color"], test["color"]
    finite = np.isfinite(a).all(axis=-1) & np.isfinite(b).all(axis=-1)
    error = pixel_error(a, b)
    failing = ~(error <= VISIBLE)
    squared = (a[finite] - b[finite]) ** 2
    mse = float(squared.mean()) if squared.size else None
    return {"not finite": int((~finite).sum()),
            "color max": _maximum(error[finite]), "color p99": _quantile(error[finite], 0.99),
            "color mean": float(error[finite].mean()) if finite.any() else None,
            "failing pixels": int(failing.sum()), "clustered failing pixels": int(everywhere_around(failing).sum()),
            "MSE": mse, "PSNR": None if not mse else float(-10 * np.log10(mse))}


def pixel_error(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The largest absolute difference over the channels of every pixel; NaN where either is not finite. (h, w)"""
    with np.errstate(invalid="ignore"):
        error = np.abs(a - b).max(axis=-1)
    return np.where(np.isfinite(error), error, np.nan)


def worst_pixels(error: np.ndarray, count: int = WORST) -> list[dict[str, float | int]]:
    """The pixels of largest error, not finite ones first, none within APART of another: one a cluster."""
    left, found = np.where(np.isnan(error), np.inf, error), []
    while len(found) < count and left.max() > 0:
        row, col = (int(k) for k in np.unravel_index(np.argmax(left), left.shape))
        found.append({"row": row, "col": col, "error": float(error[row, col])})
        left[max(0, row - APART):row + APART + 1, max(0, col - APART):col + APART + 1] = 0
    return found


def _quantile(values: np.ndarray, q: float) -> float | None:
    return float(np.quantile(values, q)) if values.size else None


def _maximum(values: np.ndarray) -> float | None:
    return float(values.max()) if values.size else None


def _ssim(a: np.ndarray, b: np.ndarray) -> float | None:
    from skimage.metrics import structural_similarity

    if min(a.shape[:2]) < 7:  # the window of the index
        return None
    return float(structural_similarity(np.clip(a, 0, 1), np.clip(b, 0, 1), channel_axis=-1, data_range=1.0))


def _flip(a: np.ndarray, b: np.ndarray) -> float:
    """Mean of the LDR FLIP map (Andersson et al. 2020) by OpenImageIO."""
    import OpenImageIO as oiio

    buffer = lambda image: oiio.ImageBuf(np.ascontiguousarray(np.clip(image, 0, 1), dtype=np.float32))
    return float(oiio.ImageBufAlgo.FLIP_diff(buffer(a), buffer(b), hdr=0).get_pixels().mean())
