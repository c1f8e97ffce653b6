"""The census: every ray of a picture, decided once more by proof."""

from __future__ import annotations

from collections import Counter, defaultdict

import drjit as dr
import numpy as np

from ..tracer.compilation import announce
from ..tracer.shading import Interaction
from ..tracer.wavefront import Wave
from ..tracer.world import World
from .certificate import KindCount
from .objects import Radius, rivals
from .precise import Decision
from .records import (
    KINDS,
    NOTHING,
    PRIMARY,
    REFLECTION,
    REFRACTION,
    ROUNDING,
    SHADOW,
    allowance,
    hit_faults,
    numpy,
    row_type,
    shadow_faults,
    undecided,
)
from .sample import Reservoir
from .shadows import shadow_rays
from .sides import side_faults

MOST_KEPT = 2000  # rows of undecided rays, and of wrong rays of one fault, that are kept to be looked into


class Census:
    """Watches a trace (wavefront.trace) and re-decides each of its rays by proof: the same ray, so nothing drifts.

    `audited` and `proofs` are Worlds of one scene, the second with the method "proof". Memory is bounded by a wave.
    """

    def __init__(self, audited: World, proofs: World, edges: np.ndarray, room: int, watched: np.ndarray):
        """`edges` (pixels) marks edges, `watched` (pixels) those whose decisions are written down; `room` is the
        number of rays kept of every stratum."""
        self.audited, self.proofs, self.edges, self.watched = audited, proofs, edges, watched
        self.radius = Radius(proofs)
        self.type = row_type(len(audited.camera_sides().words))
        self.sample = Reservoir(room)
        self.kinds = {kind: KindCount() for kind in KINDS}
        self.wrong: dict[tuple[str, int, int], list[np.ndarray]] = defaultdict(list)  # (fault, kind, object) -> rows
        self.wrong_counts: Counter = Counter()
        self.unproven: list[np.ndarray] = []
        self.decisions: dict[int, Counter] = defaultdict(Counter)  # of watched pixels
        self.rays_of_pixel = np.zeros(len(edges), np.int64)
        self.proven_pixel = np.ones(len(edges), bool)
        self.reach = np.zeros(len(edges))  # of every pixel: how far off their surfaces its hits may be so far
        self.farthest = max((max(map(abs, o.surface.center)) for o in audited.scene.objects), default=0.0)
        self.largest_gap = self.largest_radius = 0.0
        self.announced = False  # how long the proofs' kernel takes to compile
        self.first_pixel = 0  # of the band being traced; the caller sets it

    def observe(self, wave: Wave, interaction: Interaction) -> None:
        """One wave and what the audited method found; see wavefront.trace."""
        proven = self.proofs.nearest(wave.ray)
        radius = self.radius.of(wave.ray, proven)
        rivalled = rivals(self.proofs, wave.ray, proven, radius)
        count = len(wave)
        rows = np.zeros(count, self.type)
        self._describe(rows, wave.ray, count)
        rows["pixel"] = numpy(wave.slot, count).astype(np.int64) + self.first_pixel
        rows["reach"] = self.reach[rows["pixel"]] + self._rounding(rows, 0)
        sides = side_faults(self.proofs, wave.ray, self.audited.arrays.Float(rows["reach"].copy()))
        if not self.announced:
            self.announced = True
            announce(1, self.audited.arrays)
        dr.eval(proven, radius, rivalled, sides)
        rows["generation"], rows["smooth"] = wave.generation, numpy(interaction.smooth, count)
        rows["edge"] = self.edges[rows["pixel"]]
        if wave.refracted is None:
            rows["kind"] = PRIMARY
        else:
            rows["kind"] = np.where(numpy(wave.refracted, count), REFRACTION, REFLECTION)
        # what the ray carries (decision F4), and not what the audited method makes of it
        left = wave.ray.left
        rows["limit"] = self.audited.scene.tracing.max_distance if left is None else numpy(left, count)
        for name, hit in (("audited", interaction.hit), ("proven", proven)):
            index = numpy(hit.index, count).astype(np.int64)
            met = index < self.audited.object_count
            rows[name]["index"] = np.where(met, index, NOTHING)
            rows[name]["t"] = np.where(met, numpy(hit.t, count), np.inf)
            rows[name]["undecided"] = numpy(hit.undecided, count)
        rows["radius"], rows["rivalled"] = numpy(radius, count), numpy(rivalled, count)
        active = numpy(wave.weight, count) > 0  # the others pad the wave
        own_reach = self._reach_of_hits(rows)
        np.maximum.at(self.reach, rows["pixel"][active], own_reach[active])
        self._count_hits(rows[active], numpy(sides.wrong, count)[active], numpy(sides.index, count)[active])
        lights = self._observe_shadows(wave, interaction, rows, active, own_reach)
        self._write_down(rows, lights, active)

    def _describe(self, rows: np.ndarray, ray, count: int) -> None:
        rows["o"], rows["d"] = numpy(ray.o, count), numpy(ray.d, count)
        for k, word in enumerate(ray.sides.words):
            rows["sides"][:, k] = numpy(word, count)

    def _rounding(self, rows: np.ndarray, t) -> np.ndarray:
        """What rounding may move a point o + t d of each ray by, in the frame of any object."""
        return ROUNDING * (np.abs(rows["o"]).max(axis=-1) + self.farthest + t)

    def _reach_of_hits(self, rows: np.ndarray) -> np.ndarray:
        """How far the point of each hit may be off its surface: 0 where nothing was met, infinite where not known."""
        a = rows["audited"]
        met = a["index"] != NOTHING
        t = np.where(met, a["t"], 0)
        lost = a["undecided"] | undecided(rows)
        return np.where(lost, np.inf, np.where(met, allowance(rows) + self._rounding(rows, t), 0))

    def _observe_shadows(self, wave, interaction, rows, active, reach) -> np.ndarray:
        """Re-decides the shadow rays of a wave. Returns the audited intensity of every light, (n, lights), NaN where
        no shadow ray was traced."""
        count, lights = len(wave), []
        for shadow in shadow_rays(self.audited, wave, interaction):
            verdicts = [world.transmittance(shadow.ray, shadow.distance, shadow.asked)
                        for world in (self.audited, self.proofs)]
            dr.eval(verdicts)
            own = rows.copy()
            self._describe(own, shadow.ray, count)
            own["kind"], own["towards"] = SHADOW, shadow.light
            own["smooth"], own["rivalled"], own["radius"], own["reach"] = True, False, 0, reach
            own["limit"] = numpy(shadow.distance, count)
            for name, (intensity, unsure) in zip(("audited", "proven"), verdicts):
                own[name]["light"], own[name]["undecided"] = numpy(intensity, count), numpy(unsure, count)
                own[name]["index"] = NOTHING
            asked = numpy(shadow.asked, count) & active
            self._count_shadows(own[asked])
            lights.append(np.where(asked, own["audited"]["light"], np.nan))
        seen = np.stack(lights, axis=-1) if lights else np.empty((count, 0))
        asked, reached = (numpy(n, count) for n in (interaction.lights_asked, interaction.lights_reached))
        other = active & (((~np.isnan(seen)).sum(axis=-1) != asked) | ((seen > 0).sum(axis=-1) != reached))
        if other.any():  # the tracer's own shadow rays are not those that its interactions call for
            self._keep_wrong(("shadow rays astray", int(SHADOW), NOTHING), rows[other])
            self.kinds["shadow"].wrong += int(other.sum())
        return seen

    # --- counting --------------------------------------------------------------------------------------------------
    def _count_hits(self, rows, side_wrong, side_index) -> None:
        p, sure = rows["proven"], ~undecided(rows)
        met = p["index"] != NOTHING
        both = sure & met & (rows["audited"]["index"] == p["index"])
        if both.any():
            gap = np.abs(rows["audited"]["t"][both] - p["t"][both])
            self.largest_gap = max(self.largest_gap, float(gap.max()))
            self.largest_radius = max(self.largest_radius, float(rows["radius"][both].max()))
        faults = hit_faults(rows)
        faults["wrong side"] = side_wrong
        blamed = np.where(met, p["index"], rows["audited"]["index"])
        self._count(rows, met, faults, lambda fault: np.where(fault == "wrong side", side_index, blamed))

    def _count_shadows(self, rows) -> None:
        self._count(rows, rows["proven"]["light"] < 1, shadow_faults(rows), lambda _: np.full(len(rows), NOTHING))

    def _count(self, rows, met, faults, blamed) -> None:
        unsure, wrong = undecided(rows), np.logical_or.reduce(list(faults.values()))
        self.sample.offer(rows)
        self.rays_of_pixel += np.bincount(rows["pixel"], minlength=len(self.rays_of_pixel))
        self.proven_pixel[rows["pixel"][unsure | rows["audited"]["undecided"]]] = False
        room = MOST_KEPT - sum(map(len, self.unproven))
        if room > 0 and unsure.any():
            self.unproven.append(rows[unsure][:room])
        for kind in np.unique(rows["kind"]):
            own = rows["kind"] == kind
            total = self.kinds[KINDS[kind]]
            for name, which in (("rays", own), ("hits", own & ~unsure & met), ("misses", own & ~unsure & ~met),
                                ("undecided", own & unsure), ("wrong", own & wrong),
                                ("refused", own & ~unsure & rows["audited"]["undecided"])):
                setattr(total, name, getattr(total, name) + int(which.sum()))
            for fault, mask in faults.items():
                index = blamed(fault)
                for k in np.unique(index[mask & own]):
                    self._keep_wrong((fault, int(kind), int(k)), rows[mask & own & (index == k)])

    def _keep_wrong(self, key: tuple[str, int, int], rows) -> None:
        self.wrong_counts[key] += len(rows)
        room = MOST_KEPT - sum(map(len, self.wrong[key]))
        if room > 0:
            self.wrong[key].append(rows[:room])

    def _write_down(self, rows, lights, active) -> None:
        """The decisions of watched pixels, as precise.py writes down its own."""
        for k in np.flatnonzero(active & self.watched[rows["pixel"]]):
            row = rows[k]
            index = int(row["audited"]["index"])
            seen = tuple(None if np.isnan(v) else round(float(v), 12) for v in lights[k]) if index != NOTHING else ()
            self.decisions[int(row["pixel"])][Decision(int(row["generation"]), int(row["kind"]), index, seen)] += 1
