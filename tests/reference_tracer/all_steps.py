"""The literal search of the oracle with all steps of a ray looked at in one go: the same answers, in less time."""

from __future__ import annotations

import numpy as np

from reference_tracer.recursive import LiteralSearch


class AllSteps(LiteralSearch):
    """Samples at t = h, 2 h, ... up to the end of the ray, then the first change of sign, as in sections 4.1 and 4.2.

    NumPy is slow by the call, not by the number: the loop over steps of `LiteralSearch` becomes an axis of an array.
    """

    def _signs_at(self, o, d, t):
        """f < 0 of every object at every sample, (n, steps, objects); t is (n, steps)."""
        steps = t.shape[1]
        return self._signs(np.repeat(o, steps, axis=0), np.repeat(d, steps, axis=0), t.ravel()).reshape(*t.shape, -1)

    def _samples(self, end):
        """(n, steps): k h, the last one moved to the end of each ray."""
        h = self.tracing.step_size
        return np.minimum(h * np.arange(1, 2 + int(np.max(end, initial=0) / h)), end[:, None])

    def first_hit(self, o, d, inside):
        t_hit, index = np.full(len(d), np.inf), np.full(len(d), -1)
        if not len(d):
            return t_hit, index
        t = self._samples(np.full(len(d), self.tracing.max_distance))
        changed = self._signs_at(o, d, t) != inside[:, None]
        ray = np.flatnonzero(changed.any(axis=(1, 2)))
        step = np.argmax(changed.any(axis=2), axis=1)[ray]
        middle = 0.5 * (step * self.tracing.step_size + t[ray, step])
        for k in range(inside.shape[1]):
            here = changed[ray, step, k]
            root = self._newton(k, o[ray[here]], d[ray[here]], middle[here])
            closer = root < t_hit[ray[here]]
            t_hit[ray[here][closer]], index[ray[here][closer]] = root[closer], k
        return t_hit, index

    def light_through(self, o, d, inside, distance):
        if not len(d):
            return np.ones(0)
        signs = np.concatenate([inside[:, None], self._signs_at(o, d, self._samples(distance))], axis=1)
        crossings = np.sum(signs[:, 1:] != signs[:, :-1], axis=1)
        return np.prod([obj.material.transparency for obj in self.scene.objects] ** crossings, axis=-1)
