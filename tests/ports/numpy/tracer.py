"""The document's ray tracer in NumPy, all rays at a time, and raytruth's protocol. Start your own port here.

    raytruth check-port -- python tracer.py

Written from docs/ports/specification.md and docs/ports/protocol.md; ids such as M3 are those of its decisions. Points and
directions are arrays (n, 3); `inside` (n, objects) says for each ray and object whether the ray runs inside it.
"""

import json
import sys

import numpy as np

# --- surfaces: f and its gradient in the surface's own frame, p is (3, n) -------------------------------------------------


def heart(p):
    x, y, z = p
    return (x**2 + 9 / 4 * z**2 + y**2 - 1) ** 3 - x**2 * y**3 - 9 / 80 * z**2 * y**3


def heart_gradient(p):
    x, y, z = p
    k = 3 * (x**2 + 9 / 4 * z**2 + y**2 - 1) ** 2
    return k * 2 * x - 2 * x * y**3, k * 2 * y - 3 * x**2 * y**2 - 27 / 80 * z**2 * y**2, k * 4.5 * z - 9 / 40 * z * y**3


def heart_normal(p):  # O5: the gradient above vanishes on an ellipse, that of A - y cbrt(B) does not
    x, y, z = p
    root = np.cbrt(x**2 + 9 / 80 * z**2)
    k = y / (3 * root**2)
    return 2 * x - 2 * k * x, 2 * y - root, 4.5 * z - 9 / 40 * k * z


def torus_gradient(p, R, r):
    x, y, z = p
    s = np.sqrt(x**2 + y**2)
    return 2 * (s - R) / s * x, 2 * (s - R) / s * y, 2 * z


SURFACES = {
    "plane": (lambda p, a, b, c: a * p[0] + b * p[1] + c * p[2],
              lambda p, a, b, c: (a + 0 * p[0], b + 0 * p[0], c + 0 * p[0])),
    "sphere": (lambda p, r: p[0] ** 2 + p[1] ** 2 + p[2] ** 2 - r**2, lambda p, r: 2 * p),
    "ellipsoid": (lambda p, a, b, c: p[0] ** 2 / a**2 + p[1] ** 2 / b**2 + p[2] ** 2 / c**2 - 1,
                  lambda p, a, b, c: (2 * p[0] / a**2, 2 * p[1] / b**2, 2 * p[2] / c**2)),
    "torus": (lambda p, R, r: (np.sqrt(p[0] ** 2 + p[1] ** 2) - R) ** 2 + p[2] ** 2 - r**2, torus_gradient),
    "paraboloid": (lambda p, a, b: p[0] ** 2 / a**2 + p[1] ** 2 / b**2 - p[2],
                   lambda p, a, b: (2 * p[0] / a**2, 2 * p[1] / b**2, -1 + 0 * p[2])),
    "heart": (heart, heart_gradient),
}


class Object:
    def __init__(self, words):
        numbers = [float(w) for w in words[:14]]
        self.color, (self.R, self.T, self.n) = np.array(numbers[:3]), numbers[3:6]
        self.center, axis, degrees, self.sign = np.array(numbers[6:9]), np.array(numbers[9:12]), numbers[12], numbers[13]
        self.kind, self.parameters, self.shadow = words[14], [float(w) for w in words[15:]], True
        k, angle = axis / np.linalg.norm(axis), np.radians(degrees)
        cos, sin = np.cos(angle), np.sin(angle)
        if degrees % 90 == 0:  # exactly
            cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[int(degrees // 90) % 4]
        # the columns are the turned axes (O3)
        self.axes = np.stack([v * cos + np.cross(k, v) * sin + k * (k @ v) * (1 - cos) for v in np.eye(3)], axis=1)

    def local(self, point):
        return np.moveaxis((point - self.center) @ self.axes, -1, 0)

    def f(self, point):
        return self.sign * SURFACES[self.kind][0](self.local(point), *self.parameters)

    def is_inside(self, point):  # O1, M7
        f = self.f(point)
        return (f < 0) & np.isfinite(f)

    def gradient(self, point):
        return self.sign * np.stack(SURFACES[self.kind][1](self.local(point), *self.parameters), axis=-1) @ self.axes.T

    def normal(self, point):
        if self.kind != "heart":
            return unit(self.gradient(point))
        return unit(np.stack(heart_normal(self.local(point)), axis=-1) @ self.axes.T)


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def dot(a, b):
    return np.sum(a * b, axis=-1, keepdims=True)


class Scene:
    """The lines of a scene: docs/ports/specification.md, "A scene as text"."""

    def __init__(self, text):
        self.objects, self.lights, self.rays, self.v_x = [], [], [], None
        self.sum_of_lights, self.ambient, self.shadows, self.range, self.misprint = "sum", 0.0, "attenuate", "ray", False
        for line in text.splitlines():
            word, *words = line.split()
            if word == "camera":
                numbers = np.array([float(w) for w in words[:10]])
                self.position, self.direction, self.up, self.fov = numbers[:3], numbers[3:6], numbers[6:9], numbers[9]
                self.width, self.height = int(words[10]), int(words[11])
            elif word == "axes":
                self.v_x, self.v_y = np.array([float(w) for w in words]).reshape(2, 3)
            elif word == "tracing":
                self.h, self.tolerance, self.max_distance = float(words[0]), float(words[1]), float(words[3])
                self.max_iterations, self.max_depth, self.samples = int(words[2]), int(words[4]), int(words[5])
            elif word == "figures":
                self.sum_of_lights, self.ambient, self.shadows, self.range = words[0], float(words[1]), words[2], words[3]
            elif word == "background":
                self.background = np.array([float(w) for w in words])
            elif word == "light":
                self.lights.append(np.array([float(w) for w in words]).reshape(2, 3))
            elif word == "object":
                self.objects.append(Object(words))
            elif word == "shadowless":
                self.objects[int(words[0])].shadow = False
            elif word == "misprint":
                self.misprint = True
            elif word == "ray":
                self.rays.append([float(w) for w in words])
            else:
                raise ValueError(f"unknown line {word}")
        self.dims = [self.shadow_of(obj) for obj in self.objects]

    def shadow_of(self, obj):  # L3, F3: what light is multiplied by at each crossing
        casts = obj.shadow and not (self.shadows == "opaque_only" and obj.T > 0)
        return obj.T if casts else 1.0

    def sides(self, point):  # M3
        return np.stack([obj.is_inside(point) for obj in self.objects], axis=-1)


# --- sections 4.1 and 4.2 -------------------------------------------------------------------------------------------------


AT_ONCE = 64  # steps


def sides_along(scene, o, d, steps, limit):
    """t and the sides, (n, steps) and (n, steps, objects), after each step of every ray; it goes no further than `limit`."""
    t = np.minimum(steps * scene.h, limit[:, None])  # M2
    return t, scene.sides(o[:, None] + t[..., None] * d[:, None])


def first_hit(scene, o, d, inside, limit):
    t_hit, index, used = np.full(len(d), np.inf), np.full(len(d), -1), np.full(len(d), np.inf)
    waiting = np.flatnonzero((limit > 0) & np.isfinite(d).all(axis=-1))
    steps = 1 + np.arange(AT_ONCE)
    while len(waiting):
        t, now = sides_along(scene, o[waiting], d[waiting], steps, limit[waiting])
        changed = now != inside[waiting][:, None]  # M1
        found, row = changed.any(axis=(1, 2)), np.arange(len(waiting))
        first = changed.any(axis=2).argmax(axis=1)
        middle = 0.5 * ((steps[first] - 1) * scene.h + t[row, first])
        for k in np.flatnonzero(changed.any(axis=(0, 1))):
            here = found & changed[row, first, k]
            rays = waiting[here]
            root = newton(scene, scene.objects[k], o[rays], d[rays], middle[here])
            closer = root < t_hit[rays]  # M4
            t_hit[rays[closer]], index[rays[closer]] = root[closer], k
        used[waiting] = t[row, first]
        waiting = waiting[~found & (t[:, -1] < limit[waiting])]
        steps = steps + AT_ONCE
    return t_hit, index, used


def newton(scene, obj, o, d, t):
    active = np.ones(len(t), bool)
    for _ in range(scene.max_iterations):
        point = o + t[:, None] * d
        dt = obj.f(point) / dot(obj.gradient(point), d)[:, 0]
        active &= np.isfinite(dt)
        t = np.where(active, t - dt, t)
        active &= np.abs(dt) > scene.tolerance * np.maximum(1, np.abs(t))  # M6
    return t


# --- section 4.3 ----------------------------------------------------------------------------------------------------------


def light_through(scene, o, d, inside, distance):
    crossings, steps = np.zeros(inside.shape, int), 1 + np.arange(AT_ONCE)
    while len(d) and (steps[0] - 1) * scene.h < distance.max():
        now = sides_along(scene, o, d, steps, distance)[1]
        before = np.concatenate([inside[:, None], now[:, :-1]], axis=1)
        crossings, inside, steps = crossings + (now != before).sum(axis=1), now[:, -1], steps + AT_ONCE
    return np.prod(np.array(scene.dims) ** crossings, axis=-1)  # L3


def trace(scene, o, d, inside, limit, depth):
    """The colour that each ray brings back, and what it met: t, index and normal."""
    t, index, used = first_hit(scene, o, d, inside, limit)
    color, normals = np.tile(scene.background, (len(d), 1)), np.zeros((len(d), 3))  # D2
    for k, obj in enumerate(scene.objects):
        hit = np.flatnonzero(index == k)
        if len(hit):
            color[hit], normals[hit] = shade(scene, obj, k, o[hit], d[hit], inside[hit], t[hit], (limit - used)[hit], depth)
    return color, t, index, normals


def shade(scene, obj, k, o, d, inside, t, left, depth):
    point = o + t[:, None] * d
    normal = obj.normal(point)
    normal = np.where(dot(d, normal) > 0, -normal, normal)  # N1
    cos1 = np.minimum(-dot(d, normal), 1)
    if scene.range == "path":  # F4
        limit = np.where(left > 1e-12 * scene.max_distance, left, 0)
    else:
        limit = np.full(len(t), scene.max_distance)  # M5

    illumination = np.full_like(point, scene.ambient)  # F2
    for position, brightness in scene.lights:
        distance = np.linalg.norm(position - point, axis=-1, keepdims=True)
        shadow_dir = (position - point) / distance
        cos = dot(shadow_dir, normal)
        lit = cos[:, 0] > 0  # L2
        intensity = light_through(scene, point[lit], shadow_dir[lit], inside[lit], distance[lit, 0])
        more = cos[lit] * brightness * intensity[:, None]
        if scene.sum_of_lights == "balanced":  # F1
            illumination[lit] = 1 - (1 - illumination[lit]) * (1 - more)
        else:
            illumination[lit] += more  # L1
    visible = obj.color * illumination

    def follow(which, direction, sides):
        if depth == scene.max_depth:  # D1
            return np.tile(scene.background, (which.sum(), 1))
        return trace(scene, point[which], unit(direction[which]), sides[which], limit[which], depth + 1)[0]  # R4

    reflection_dir = d + 2 * normal * cos1
    reflected, refracted = np.zeros_like(visible), np.zeros_like(visible)
    if obj.R > 0:
        reflected = follow(np.ones(len(d), bool), reflection_dir, inside)
    if obj.T > 0:
        leaving = inside[:, [k]]  # R1
        n1, n2 = np.where(leaving, obj.n, 1.0), np.where(leaving, 1.0, obj.n)
        sin1 = np.sqrt(np.maximum(1 - cos1**2, 0))
        total = (sin1 > n2 / n1)[:, 0]  # R2
        if total.any():  # R3
            refracted[total] = reflected[total] if obj.R > 0 else follow(total, reflection_dir, inside)
        sin2 = sin1 * n2 / n1 if scene.misprint else sin1 * n1 / n2  # E1
        cos2 = np.sqrt(1 - sin2**2 if scene.misprint else np.maximum(1 - sin2**2, 0))
        refraction_dir = (d + normal * cos1) * (n1 / n2) - normal * cos2
        through = inside.copy()
        through[:, k] ^= True  # M3
        if (~total).any():
            refracted[~total] = follow(~total, refraction_dir, through)
    return (visible * (1 - obj.R) + reflected * obj.R) * (1 - obj.T) + refracted * obj.T, normal


# --- sections 2 and 5 -----------------------------------------------------------------------------------------------------


def camera_rays(scene, n):
    """Origins and directions (h w n n, 3), the n x n samples of a pixel one after another."""
    v_dir = unit(scene.direction)
    v_x = unit(np.cross(scene.up, v_dir) if scene.v_x is None else scene.v_x)  # C1, F5
    v_y = np.cross(v_dir, v_x) if scene.v_x is None else unit(scene.v_y)
    ratio = 2 * np.tan(np.pi * scene.fov / 360) / max(scene.width, scene.height)
    row, col, i, j = np.mgrid[:scene.height, :scene.width, :n, :n].reshape(4, -1, 1)
    x = ratio * ((col + (j + 0.5) / n) - scene.width * 0.5)  # C2
    y = ratio * (-(row + (i + 0.5) / n) + scene.height * 0.5)
    d = unit(x * v_x + y * v_y + v_dir)
    return np.tile(scene.position, (len(d), 1)), d


def start(scene, o, d):
    return trace(scene, o, d, scene.sides(o), np.full(len(d), scene.max_distance), 0)


def answer(scene):
    """Arrays by name, and the shape of the picture or of the list of rays."""
    if scene.rays:
        o, d = np.array(scene.rays).reshape(-1, 2, 3).transpose(1, 0, 2)
        color, t, index, normal = start(scene, o, d)
        shape = [len(d)]
    else:
        n, shape = scene.samples, [scene.height, scene.width]
        color, t, index, normal = start(scene, *camera_rays(scene, 1))
        if n > 1:
            color = start(scene, *camera_rays(scene, n))[0].reshape(-1, n * n, 3).mean(axis=1)
    arrays = {"color": (color, "float64"), "index": (index, "int32"), "t": (t, "float64"), "normal": (normal, "float64")}
    return {name: (array.reshape(*shape, *array.shape[1:]), kind) for name, (array, kind) in arrays.items()}


# --- the protocol ---------------------------------------------------------------------------------------------------------


def serve():
    receive, send = sys.stdin.buffer, sys.stdout.buffer
    for line in receive:
        request = json.loads(line)
        if request["op"] == "hello":
            head, blocks = {"protocol": 1, "name": "raytruth NumPy example", "levels": ["algorithm"], "precision": 64,
                            "switches": ["E1", "F1", "F2", "F3", "F4", "F5"]}, []
        else:
            arrays = answer(Scene(receive.read(request["bytes"]).decode()))
            blocks = [np.ascontiguousarray(array, np.dtype(kind).newbyteorder("<")).tobytes() for array, kind in arrays.values()]
            head = {"seq": request["seq"], "state": "ok", "bytes": sum(map(len, blocks)),
                    "arrays": [{"name": name, "dtype": kind, "shape": array.shape}
                               for name, (array, kind) in arrays.items()]}
        send.write(json.dumps(head).encode() + b"\n" + b"".join(blocks))
        send.flush()


if __name__ == "__main__":
    np.seterr(all="ignore")
    serve()
