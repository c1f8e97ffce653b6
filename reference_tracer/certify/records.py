"""Rays and what two methods say of them, as rows of NumPy tables."""

from __future__ import annotations

import numpy as np

KINDS = ("primary", "reflection", "refraction", "shadow")
PRIMARY, REFLECTION, REFRACTION, SHADOW = range(4)
NOTHING = -1  # the index of a ray that met no object
LAST_STEP = 2.0**-50  # 8 units of rounding: where first_hit.refine stops
# What rounding adds to a ray's origin in an object's frame, relative to |o| + |c| + t: the parent's and the ray's own
# difference to the center c, product with the rotation (rows of absolute sum up to sqrt(3), three terms each) and
# o + t d, at most 4 sqrt(3) + 4 sqrt(3) + 3 sqrt(3) + 3 < 32 half units.
ROUNDING = 2.0**-48

# one method's answer: of a first hit t and index, of a shadow ray the part of the light that arrives
ANSWER = [("t", "f8"), ("index", "i4"), ("light", "f8"), ("undecided", "?")]


def row_type(words: int) -> np.dtype:
    """A ray in world space, where it comes from, and the answers of the audited method and of the proofs.

    `words` is the number of 64-bit words that hold its sides; `limit` is its range, or the distance to the light;
    `towards` is the light of a shadow ray; `reach` is how far its origin may be off the surface it starts on (infinite
    where the audited method does not vouch for it); `radius` encloses the proven t; `rivalled` says that another object
    may be crossed there as well; `smooth` that the gradient exists there; `edge` marks a pixel on an edge.
    """
    return np.dtype([("o", "f8", 3), ("d", "f8", 3), ("sides", "u8", (words,)), ("limit", "f8"),
                     ("kind", "u1"), ("generation", "u1"), ("pixel", "i8"), ("towards", "i2"), ("edge", "?"),
                     ("reach", "f8"), ("smooth", "?"), ("rivalled", "?"), ("audited", ANSWER), ("proven", ANSWER),
                     ("radius", "f8")])


def numpy(array, count: int) -> np.ndarray:
    """A Dr.Jit array or vector as NumPy, rays first; constants are repeated for each of `count` rays."""
    values = array.numpy().T
    return np.broadcast_to(values, (count, *values.shape[1:]))


def is_inside(rows: np.ndarray, index: int) -> np.ndarray:
    """Whether each ray is inside object `index` at its start (rays.Sides)."""
    from ..tracer.rays import BITS

    return (rows["sides"][:, index // BITS] >> np.uint64(index % BITS)) & np.uint64(1) != 0


def hit_faults(rows: np.ndarray) -> dict[str, np.ndarray]:
    """Which first hits of the audited method are wrong by proof, as masks by the kind of fault."""
    a, p = rows["audited"], rows["proven"]
    claimed = ~undecided(rows) & ~a["undecided"]
    met_a, met_p = a["index"] != NOTHING, p["index"] != NOTHING
    same = met_a & met_p & (a["index"] == p["index"])
    with np.errstate(invalid="ignore"):
        apart = np.abs(a["t"] - p["t"]) > allowance(rows)
    return {"missed hit": claimed & ~met_a & met_p, "false hit": claimed & met_a & ~met_p,
            "wrong object": claimed & met_a & met_p & ~same, "wrong distance": claimed & same & apart}


def shadow_faults(rows: np.ndarray) -> dict[str, np.ndarray]:
    """Which shadow verdicts are wrong by proof."""
    a, p = rows["audited"], rows["proven"]
    return {"wrong shadow": ~a["undecided"] & ~p["undecided"] & (a["light"] != p["light"])}


def allowance(rows: np.ndarray) -> np.ndarray:
    """How far the audited t may be off the proven one: its enclosure, and the last step of the search (decision M6)."""
    return rows["radius"] + LAST_STEP * np.maximum(1, np.abs(rows["proven"]["t"]))


def settled_within(rows: np.ndarray) -> np.ndarray:
    """How far the audited t may be off the exact one where no proof encloses it: what first_hit.segments makes sure of."""
    return 2.0**-26 * np.maximum(1, np.abs(rows["audited"]["t"]))


def undecided(rows: np.ndarray) -> np.ndarray:
    """Where the proofs decide nothing, or less than a picture needs; reasons.py tells why."""
    return rows["proven"]["undecided"] | ~rows["smooth"] | unenclosed(rows) | rows["rivalled"]


def unenclosed(rows: np.ndarray) -> np.ndarray:
    """A crossing is proven, but no radius about its t."""
    return (rows["proven"]["index"] != NOTHING) & np.isinf(rows["radius"])
