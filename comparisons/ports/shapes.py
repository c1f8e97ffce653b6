"""Where rays of many tracers cross one object, in NumPy: exactly where f is quadratic, by samples and bisection elsewhere, and
as the document's steps see it for those tracers that take steps."""

from __future__ import annotations

import numpy as np

from raytruth.reference_tracer.oracle.literal import Tangent
from raytruth.reference_tracer.scene.model import Object
from raytruth.reference_tracer.scene.placement import rotation_matrix

MOST_SAMPLES = 192  # of f along a ray
PIECES = 40  # into which the way through a box is cut where that is finer than the scene's step
HALVINGS = 34


class Shape:
    """One object: its f along rays."""

    def __init__(self, obj: Object):
        self.material, self.surface = obj.material, obj.surface
        self.axes = rotation_matrix(obj.rotation)
        self.turned = obj.rotation is not None
        self.center = np.array(obj.surface.center)[:, None]
        self.box = obj.surface.box()
        self.quadric = _quadric(obj.surface)

    def into(self, v):
        return self.axes.T @ v if self.turned else v

    def value(self, o, d, t):
        """f at o + t d in the own frame; t may have more axes than rays."""
        with np.errstate(all="ignore"):
            return self.surface.regular(*(p.reshape(-1, *[1] * (t.ndim - 1)) + t * v.reshape(-1, *[1] * (t.ndim - 1))
                                          for p, v in zip(o, d)))

    def slope(self, o, d, t):
        with np.errstate(all="ignore"):
            g = self.surface(*(Tangent(p + t * v, v[None]) for p, v in zip(o, d)))
        return g.value, g.slopes[0]

    def gradient(self, point, printed=None):
        """grad f in the world, (3, n); that of the `printed` form where so asked (n,)."""
        p = self.into(point - self.center)
        slopes = np.eye(3)[..., None] + np.zeros(p.shape[1])
        with np.errstate(all="ignore"):
            g = self.surface.regular(*map(Tangent, p, slopes)).slopes
            if printed is not None and printed.any():
                g = np.where(printed, self.surface(*map(Tangent, p, slopes)).slopes, g)
        return self.axes @ g if self.turned else g

    def is_inside(self, point):
        with np.errstate(all="ignore"):
            f = self.surface(*self.into(point - self.center))
        return (f < 0) & (f > -np.inf)

    # --- crossings -------------------------------------------------------------------------------------------------
    def first(self, o, d, inside, limit, h, tracing):
        """The distance of the first change of sign from `inside` (n,), infinity where there is none.

        Where `h` (n,) is not 0, it is the literal step: two changes of sign in one go unseen, and the root is Newton's.
        """
        o, d, literal = self.into(o - self.center), self.into(d), np.flatnonzero(h > 0)
        if self.quadric is not None:
            first, second = self._roots(o, d, inside)
            found = np.where(first <= limit, first, np.inf)
            if len(literal):
                some = literal
                with np.errstate(invalid="ignore"):
                    unseen = np.ceil(first[some] / h[some]) == np.ceil(second[some] / h[some])
                found[some[unseen & np.isfinite(second[some])]] = np.inf
                self._at_once(found, o, d, inside, limit, h, some, tracing)
            return found
        found = np.full(len(limit), np.inf)
        low, high = self._span(o, d, limit)
        rays = np.flatnonzero(low < high)
        if len(rays):
            t, signs = self._signs(o[:, rays], d[:, rays], low[rays], high[rays], h[rays], tracing.step_size)
            changed = signs != inside[rays][:, None]
            hit = np.flatnonzero(changed.any(axis=1))
            k = changed[hit].argmax(axis=1)
            before = np.where(k > 0, t[hit, np.maximum(k - 1, 0)], np.maximum(low[rays[hit]], 0))
            rays, after = rays[hit], t[hit, k]
            found[rays] = self._bisected(o[:, rays], d[:, rays], before, after, inside[rays])
            if len(some := np.flatnonzero(h[rays] > 0)):
                rays, step = rays[some], h[rays[some]]
                middle = 0.5 * ((np.ceil(after[some] / step - 1e-9) - 1) * step + after[some])
                found[rays] = self.newton(o[:, rays], d[:, rays], middle, tracing)
        if len(literal):
            self._at_once(found, o, d, inside, limit, h, literal, tracing)
        return found

    def _at_once(self, found, o, d, inside, limit, h, some, tracing) -> None:
        """A ray that is not on the side where it is thought to be: the first sample differs, and Newton starts before it."""
        end = np.minimum(h[some], limit[some])
        with np.errstate(all="ignore"):
            f = self.surface(*(o[:, some] + end * d[:, some]))
        some, end = (v[((f < 0) & (f > -np.inf)) != inside[some]] for v in (some, end))
        usable = limit[some] > 0
        some, end = some[usable], end[usable]
        if len(some):
            found[some] = self.newton(o[:, some], d[:, some], 0.5 * end, tracing)

    def newton(self, o, d, t, tracing):
        """Section 4.2: of f as printed, freely from t on (M6)."""
        active = np.ones(len(t), bool)
        for _ in range(tracing.max_iterations):
            g, slope = self.slope(o, d, t)
            with np.errstate(all="ignore"):
                dt = np.where(active, g / slope, 0.0)
            active &= np.isfinite(dt)
            t = np.where(active, t - dt, t)
            active &= np.abs(dt) > tracing.tolerance * np.maximum(1, np.abs(t))
            if not active.any():
                break
        return t

    def count(self, o, d, inside, limit, h, step):
        """How often f changes its sign before `limit` (n,)."""
        o, d = self.into(o - self.center), self.into(d)
        if self.quadric is not None:
            first, second = self._roots(o, d, inside)
            found = (first < limit).astype(np.int64) + (second < limit)
        else:
            found = np.zeros(len(limit), np.int64)
            low, high = self._span(o, d, limit)
            rays = np.flatnonzero(low < high)
            if len(rays):
                _, signs = self._signs(o[:, rays], d[:, rays], low[rays], high[rays], h[rays], step)
                signs = np.concatenate([inside[rays][:, None], signs], axis=1)
                found[rays] = (signs[:, 1:] != signs[:, :-1]).sum(axis=1)
        some = np.flatnonzero(h > 0)
        if len(some) and self.quadric is not None:
            with np.errstate(invalid="ignore", divide="ignore"):
                unseen = (found[some] == 2) & (np.ceil(first[some] / h[some]) == np.ceil(second[some] / h[some]))
            found[some[unseen]] = 0
        if len(some):  # see `_at_once`
            end = np.minimum(h[some], limit[some])
            with np.errstate(all="ignore"):
                f = self.surface(*(o[:, some] + end * d[:, some]))
            now = (f < 0) & (f > -np.inf)
            wrong = some[now != inside[some]]
            if len(wrong) and self.quadric is not None:
                end = np.minimum(h, limit)[wrong]
                first, second = self._roots(o[:, wrong] + end * d[:, wrong], d[:, wrong], ~inside[wrong])
                left = limit[wrong] - end
                found[wrong] = 1 + (first < left).astype(np.int64) + (second < left)
            elif len(wrong):
                found[wrong] = np.maximum(found[wrong], 1)
        return found

    def _roots(self, o, d, inside):
        """Of f = a t^2 + 2 b t + c: the root at which a ray on the side `inside` crosses, and the one after it; a root of the
        wrong slope is the surface that the ray has just left."""
        Q, q, c0 = self.quadric
        Qd = Q @ d
        a, b = (d * Qd).sum(axis=0), (o * Qd).sum(axis=0) + q @ d
        c = (o * (Q @ o)).sum(axis=0) + 2 * (q @ o) + c0
        with np.errstate(all="ignore"):
            root = np.sqrt(b * b - a * c)
            s = -(b + np.copysign(root, b))  # no difference of equal numbers
            flat = np.abs(a) < 1e-14 * np.abs(b)
            t1, t2 = np.where(flat, -0.5 * c / b, s / a), np.where(flat, np.nan, c / s)
            up1 = np.where(flat, b > 0, a * t1 + b > 0)
            up2 = a * t2 + b > 0
        wanted1 = (up1 == inside) & np.isfinite(t1)
        wanted2 = (up2 == inside) & np.isfinite(t2)
        first = np.where(wanted1, t1, np.where(wanted2, t2, np.inf))
        other = np.where(wanted1, t2, np.where(wanted2, t1, np.inf))
        first = np.where(first > 0, first, np.inf)
        return first, np.where((other > first) & np.isfinite(other), other, np.inf)

    def _span(self, o, d, limit):
        if self.box is None:
            return np.zeros(len(limit)), limit
        with np.errstate(all="ignore"):
            low, high = ((np.array(corner)[:, None] - o) / d for corner in self.box)
        near, far = np.fmin(low, high).max(axis=0), np.fmax(low, high).min(axis=0)
        return np.maximum(near, 0), np.minimum(far, limit)

    def _signs(self, o, d, low, high, h, step):
        literal = h > 0
        spacing = np.where(literal, h, np.minimum(step, np.maximum((high - low) / PIECES, 1e-9)))
        spacing = np.maximum(spacing, (high - low).max() / MOST_SAMPLES)
        start = np.floor(low / spacing) * spacing
        samples = int(np.ceil(((high - start) / spacing).max()))
        t = np.minimum(start[:, None] + spacing[:, None] * np.arange(1, samples + 1), high[:, None])
        f = self.value(o, d, t)
        return t, (f < 0) & (f > -np.inf)

    def _bisected(self, o, d, low, high, inside):
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            same = (self.value(o, d, middle) < 0) == inside
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return 0.5 * (low + high)


def _quadric(surface):
    """(Q, q, c) of f = p.Qp + 2 q.p + c, or None where f is no such polynomial: read off f, and tried at other points."""
    f = lambda *p: float(np.ravel(surface(*(np.array([float(c)]) for c in p)))[0])
    e = np.eye(3)
    with np.errstate(all="ignore"):
        c = f(0, 0, 0)
        plus, minus = np.array([f(*v) for v in e]), np.array([f(*-v) for v in e])
        q, Q = (plus - minus) / 4, np.diag((plus + minus) / 2 - c)
        for i, j in ((0, 1), (0, 2), (1, 2)):
            Q[i, j] = Q[j, i] = (f(*(e[i] + e[j])) - plus[i] - plus[j] + c) / 2
        points = np.random.default_rng(1).uniform(-3, 3, (3, 12))
        values = np.ravel(surface(*points))
        guess = (points * (Q @ points)).sum(axis=0) + 2 * q @ points + c
        scale = 1 + np.abs(values).max()
    return (Q, q, c) if np.all(np.abs(values - guess) <= 1e-12 * scale) else None
