// The document's ray tracer in Rust, one file, no crates, and raytruth's protocol. Start your own port here.
//
//   rustc --edition 2021 -O tracer.rs && raytruth check-port -- ./tracer
//   raytruth check-port -- ./tracer exact       with a root finder that misses no root it can see: the model's truth
//
// Written from docs/ports/specification.md and docs/ports/protocol.md; ids such as M3 are those of its decisions.

use std::io::{self, BufRead, Read, Write};
use std::ops::{Add, Mul, Neg, Sub};

#[derive(Clone, Copy, Default)]
struct Vec3 {
    x: f64,
    y: f64,
    z: f64,
}

fn vec3(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3 { x, y, z }
}

impl Add for Vec3 {
    type Output = Vec3;
    fn add(self, b: Vec3) -> Vec3 {
        vec3(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}
impl Sub for Vec3 {
    type Output = Vec3;
    fn sub(self, b: Vec3) -> Vec3 {
        vec3(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}
impl Neg for Vec3 {
    type Output = Vec3;
    fn neg(self) -> Vec3 {
        vec3(-self.x, -self.y, -self.z)
    }
}
impl Mul<f64> for Vec3 {
    type Output = Vec3;
    fn mul(self, s: f64) -> Vec3 {
        vec3(self.x * s, self.y * s, self.z * s)
    }
}
impl Mul for Vec3 {
    type Output = Vec3; // of colours
    fn mul(self, b: Vec3) -> Vec3 {
        vec3(self.x * b.x, self.y * b.y, self.z * b.z)
    }
}

fn dot(a: Vec3, b: Vec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}
fn cross(a: Vec3, b: Vec3) -> Vec3 {
    vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}
fn unit(a: Vec3) -> Vec3 {
    a * (1.0 / dot(a, a).sqrt())
}

// --- surfaces, in their own frame ---------------------------------------------------------------------------------------

enum Surface {
    Plane(f64, f64, f64),
    Sphere(f64),
    Ellipsoid(f64, f64, f64),
    Torus(f64, f64),
    Paraboloid(f64, f64),
    Heart,
}

impl Surface {
    fn f(&self, p: Vec3) -> f64 {
        let (x, y, z) = (p.x, p.y, p.z);
        match *self {
            Surface::Plane(a, b, c) => a * x + b * y + c * z,
            Surface::Sphere(r) => x * x + y * y + z * z - r * r,
            Surface::Ellipsoid(a, b, c) => x * x / (a * a) + y * y / (b * b) + z * z / (c * c) - 1.0,
            Surface::Torus(big, r) => ((x * x + y * y).sqrt() - big).powi(2) + z * z - r * r,
            Surface::Paraboloid(a, b) => x * x / (a * a) + y * y / (b * b) - z,
            Surface::Heart => {
                let (x2, z2, y3) = (x * x, z * z, y * y * y);
                (x2 + 2.25 * z2 + y * y - 1.0).powi(3) - x2 * y3 - 9.0 / 80.0 * z2 * y3
            }
        }
    }

    fn gradient(&self, p: Vec3) -> Vec3 {
        let (x, y, z) = (p.x, p.y, p.z);
        match *self {
            Surface::Plane(a, b, c) => vec3(a, b, c),
            Surface::Sphere(_) => p * 2.0,
            Surface::Ellipsoid(a, b, c) => vec3(2.0 * x / (a * a), 2.0 * y / (b * b), 2.0 * z / (c * c)),
            Surface::Torus(big, _) => {
                let s = (x * x + y * y).sqrt();
                vec3(2.0 * (s - big) / s * x, 2.0 * (s - big) / s * y, 2.0 * z)
            }
            Surface::Paraboloid(a, b) => vec3(2.0 * x / (a * a), 2.0 * y / (b * b), -1.0),
            Surface::Heart => {
                let (x2, y2, z2) = (x * x, y * y, z * z);
                let k = 3.0 * (x2 + 2.25 * z2 + y2 - 1.0).powi(2);
                vec3(
                    k * 2.0 * x - 2.0 * x * y2 * y,
                    k * 2.0 * y - 3.0 * x2 * y2 - 27.0 / 80.0 * z2 * y2,
                    k * 4.5 * z - 9.0 / 40.0 * z * y2 * y,
                )
            }
        }
    }

    // A form with the same zeros and signs whose gradient does not vanish (O5): normals come from it
    fn regular(&self, p: Vec3) -> f64 {
        match *self {
            Surface::Heart => {
                let root = (p.x * p.x + 9.0 / 80.0 * p.z * p.z).cbrt();
                p.x * p.x + 2.25 * p.z * p.z + p.y * p.y - 1.0 - p.y * root
            }
            _ => self.f(p),
        }
    }

    fn regular_gradient(&self, p: Vec3) -> Vec3 {
        match *self {
            Surface::Heart => {
                let root = (p.x * p.x + 9.0 / 80.0 * p.z * p.z).cbrt();
                let k = p.y / (3.0 * root * root);
                vec3(2.0 * p.x - 2.0 * k * p.x, 2.0 * p.y - root, 4.5 * p.z - 9.0 / 40.0 * k * p.z)
            }
            _ => self.gradient(p),
        }
    }
}

struct Object {
    surface: Surface,
    sign: f64, // -1 where f > 0 is inside (O1)
    center: Vec3,
    axes: [Vec3; 3], // the surface's own axes in the world (O3)
    color: Vec3,
    reflection: f64,
    transparency: f64,
    index: f64,
    shadow: bool,
}

impl Object {
    fn local(&self, v: Vec3) -> Vec3 {
        vec3(dot(self.axes[0], v), dot(self.axes[1], v), dot(self.axes[2], v))
    }
    fn world(&self, v: Vec3) -> Vec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }
    fn f(&self, p: Vec3) -> f64 {
        self.sign * self.surface.f(self.local(p - self.center))
    }
    fn gradient(&self, p: Vec3) -> Vec3 {
        self.world(self.surface.gradient(self.local(p - self.center))) * self.sign
    }
    fn regular(&self, p: Vec3) -> f64 {
        self.sign * self.surface.regular(self.local(p - self.center))
    }
    fn regular_gradient(&self, p: Vec3) -> Vec3 {
        self.world(self.surface.regular_gradient(self.local(p - self.center))) * self.sign
    }
    // g(t) = a t^2 + b t + c, where f is a quadric
    fn parabola(&self, o: Vec3, d: Vec3) -> Option<[f64; 3]> {
        let (p, v) = (self.local(o - self.center), self.local(d));
        let (square, linear, constant) = match self.surface {
            Surface::Plane(a, b, c) => (vec3(0.0, 0.0, 0.0), vec3(a, b, c), 0.0),
            Surface::Sphere(r) => (vec3(1.0, 1.0, 1.0), vec3(0.0, 0.0, 0.0), -r * r),
            Surface::Ellipsoid(a, b, c) => (vec3(1.0 / (a * a), 1.0 / (b * b), 1.0 / (c * c)), vec3(0.0, 0.0, 0.0), -1.0),
            Surface::Paraboloid(a, b) => (vec3(1.0 / (a * a), 1.0 / (b * b), 0.0), vec3(0.0, 0.0, -1.0), 0.0),
            _ => return None,
        };
        let a = dot(square * v, v);
        let b = 2.0 * dot(square * p, v) + dot(linear, v);
        let c = dot(square * p, p) + dot(linear, p) + constant;
        Some([a * self.sign, b * self.sign, c * self.sign])
    }
    fn is_inside(&self, p: Vec3) -> bool {
        let f = self.f(p); // zero and what is not finite are outside (O1, M7)
        f < 0.0 && f.is_finite()
    }
}

// Where a t^2 + b t + c changes to the other side than the ray's, and back, within (0, range). The ray may begin on the
// surface: of its roots only those count after which the sign is another than before.
fn parabola_crossings(a: f64, b: f64, c: f64, side: bool, range: f64) -> Vec<f64> {
    let mut roots = Vec::new();
    if a.abs() < 1e-300 {
        if b != 0.0 {
            roots.push(-c / b);
        }
    } else {
        let square = b * b - 4.0 * a * c;
        if square > 0.0 {
            let q = -0.5 * (b + b.signum() * square.sqrt());
            roots.extend([q / a, c / q]);
        }
    }
    roots.sort_by(|x, y| x.total_cmp(y));
    let (mut found, mut inside) = (Vec::new(), side);
    for t in roots {
        let falls = 2.0 * a * t + b < 0.0; // from outside to inside
        if t > 0.0 && t < range && falls != inside {
            found.push(t);
            inside = !inside;
        }
    }
    found
}

type Sides = Vec<bool>; // for every object, whether the ray runs inside it (M3)

#[derive(Default)]
struct Scene {
    position: Vec3,
    direction: Vec3,
    up: Vec3,
    axes: Option<(Vec3, Vec3)>,
    fov: f64,
    width: usize,
    height: usize,
    h: f64,
    tolerance: f64,
    max_iterations: usize,
    max_distance: f64,
    max_depth: usize,
    samples: usize,
    background: Vec3,
    objects: Vec<Object>,
    lights: Vec<(Vec3, Vec3)>,
    rays: Vec<(Vec3, Vec3)>,
    balanced: bool,
    ambient: f64,
    opaque_only: bool,
    shared_range: bool,
    misprint: bool,
    exact: bool,
}

struct Hit {
    t: f64,
    object: Option<usize>,
    used: f64, // of the ray's range: whole steps, in the model t
}

impl Scene {
    // --- sections 4.1 and 4.2 ---
    fn first_hit(&self, o: Vec3, d: Vec3, sides: &Sides, range: f64) -> Hit {
        let mut hit = Hit { t: f64::INFINITY, object: None, used: 0.0 };
        if !dot(d, d).is_finite() {
            return hit;
        }
        if self.exact {
            for k in 0..self.objects.len() {
                if let Some(t) = self.crossings(k, o, d, sides[k], range).first() {
                    if *t < hit.t {
                        hit = Hit { t: *t, object: Some(k), used: *t };
                    }
                }
            }
            return hit;
        }
        let (mut step, mut t) = (0, 0.0);
        while t < range && hit.object.is_none() {
            step += 1;
            let before = (step - 1) as f64 * self.h;
            t = (step as f64 * self.h).min(range); // M2, M5
            for (k, object) in self.objects.iter().enumerate() {
                if object.is_inside(o + d * t) != sides[k] {
                    let root = self.newton(object, o, d, 0.5 * (before + t)); // M4
                    if root < hit.t {
                        hit = Hit { t: root, object: Some(k), used: t };
                    }
                }
            }
        }
        hit
    }

    fn newton(&self, object: &Object, o: Vec3, d: Vec3, start: f64) -> f64 {
        let mut t = start;
        for _ in 0..self.max_iterations {
            let p = o + d * t;
            let dt = object.f(p) / dot(object.gradient(p), d);
            if !dt.is_finite() {
                break;
            }
            t -= dt;
            if dt.abs() <= self.tolerance * t.abs().max(1.0) {
                break; // M6
            }
        }
        t
    }

    // Every change of sign up to `range`, for the model's truth. A quadric has closed forms; else, within a fine step g is looked at where its slope
    // vanishes too, so that two roots in one step are seen; each root is then bisected to the last digit.
    fn crossings(&self, k: usize, o: Vec3, d: Vec3, side: bool, range: f64) -> Vec<f64> {
        let object = &self.objects[k];
        if let Some([a, b, c]) = object.parabola(o, d) {
            return parabola_crossings(a, b, c, side, range);
        }
        let g = |t: f64| object.regular(o + d * t);
        let slope = |t: f64| dot(object.regular_gradient(o + d * t), d);
        let (mut found, mut inside, mut before) = (Vec::new(), side, 0.0);
        let fine = 0.02_f64;
        let mut visit = |from: f64, to: f64, inside: &mut bool| {
            if (g(to) < 0.0) != *inside {
                let (mut low, mut high) = (from, to);
                while high - low > 1e-16 * high.max(1e-3) {
                    let middle = 0.5 * (low + high);
                    if middle <= low || middle >= high {
                        break;
                    }
                    if (g(middle) < 0.0) == *inside {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                found.push(0.5 * (low + high));
                *inside = !*inside;
            }
        };
        let mut step = 0;
        while before < range {
            step += 1;
            let t = (step as f64 * fine).min(range);
            // towards zero at the start of the step, away from it at its end: there is an extremum between
            let towards = if inside { 1.0 } else { -1.0 };
            if (g(t) < 0.0) == inside && slope(before) * towards > 0.0 && slope(t) * towards < 0.0 {
                let (mut low, mut high) = (before, t);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if slope(middle) * towards > 0.0 {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                if low > 0.0 {
                    visit(before, low, &mut inside);
                    before = low;
                }
            }
            visit(before, t, &mut inside);
            before = t;
        }
        found
    }

    // --- shadow ray, section 4.3.1 ---
    fn light_through(&self, o: Vec3, d: Vec3, distance: f64, sides: &Sides) -> f64 {
        let (mut intensity, mut sides) = (1.0, sides.clone());
        let casts = |k: usize| self.objects[k].shadow && !(self.opaque_only && self.objects[k].transparency > 0.0);
        if self.exact {
            for k in (0..self.objects.len()).filter(|&k| casts(k)) {
                let count = self.crossings(k, o, d, sides[k], distance).len();
                intensity *= self.objects[k].transparency.powi(count as i32);
            }
            return intensity;
        }
        let (mut step, mut t) = (0, 0.0);
        while t < distance && intensity > 0.0 {
            step += 1;
            t = (step as f64 * self.h).min(distance);
            for (k, object) in self.objects.iter().enumerate().filter(|(k, _)| casts(*k)) {
                let inside = object.is_inside(o + d * t);
                if inside != sides[k] {
                    intensity *= object.transparency; // at every crossing (L3)
                    sides[k] = inside;
                }
            }
        }
        intensity
    }

    // --- section 4.3 ---
    fn trace(&self, o: Vec3, d: Vec3, sides: &Sides, range: f64, depth: usize) -> Vec3 {
        if depth > self.max_depth {
            return self.background; // D1
        }
        let hit = self.first_hit(o, d, sides, range);
        self.shade(o, d, sides, range, &hit, depth)
    }

    fn normal(&self, k: usize, o: Vec3, d: Vec3, t: f64) -> Vec3 {
        let normal = unit(self.objects[k].regular_gradient(o + d * t));
        if dot(d, normal) > 0.0 {
            -normal // N1
        } else {
            normal
        }
    }

    fn shade(&self, o: Vec3, d: Vec3, sides: &Sides, range: f64, hit: &Hit, depth: usize) -> Vec3 {
        let k = match hit.object {
            Some(k) => k,
            None => return self.background, // D2
        };
        let (object, point, normal) = (&self.objects[k], o + d * hit.t, self.normal(k, o, d, hit.t));
        let cos1 = (-dot(d, normal)).min(1.0);
        let left = if self.shared_range { range - hit.used } else { self.max_distance }; // F4, M5
        let left = if left < 1e-12 * self.max_distance { 0.0 } else { left };

        let one = vec3(1.0, 1.0, 1.0);
        let mut illumination = one * self.ambient; // F2
        for &(position, brightness) in &self.lights {
            let way = position - point;
            let distance = dot(way, way).sqrt();
            let shadow_dir = way * (1.0 / distance);
            let cos = dot(shadow_dir, normal);
            if cos > 0.0 {
                // L2
                let more = brightness * (cos * self.light_through(point, shadow_dir, distance, sides));
                illumination = if self.balanced { one - (one - illumination) * (one - more) } else { illumination + more };
            }
        }
        let visible = object.color * illumination;

        let reflection_dir = unit(d + normal * (2.0 * cos1)); // R4
        let (mut reflected, mut refracted) = (Vec3::default(), Vec3::default());
        if object.reflection > 0.0 {
            reflected = self.trace(point, reflection_dir, sides, left, depth + 1);
        }
        if object.transparency > 0.0 {
            let (n1, n2) = if sides[k] { (object.index, 1.0) } else { (1.0, object.index) }; // R1
            let sin1 = (1.0 - cos1 * cos1).max(0.0).sqrt();
            if sin1 > n2 / n1 {
                // R2, R3
                refracted = if object.reflection > 0.0 {
                    reflected
                } else {
                    self.trace(point, reflection_dir, sides, left, depth + 1)
                };
            } else {
                let sin2 = if self.misprint { sin1 * n2 / n1 } else { sin1 * n1 / n2 }; // E1
                let square = 1.0 - sin2 * sin2;
                let cos2 = if self.misprint { square.sqrt() } else { square.max(0.0).sqrt() };
                let direction = unit((d + normal * cos1) * (n1 / n2) - normal * cos2);
                let mut through = sides.clone();
                through[k] = !through[k]; // M3
                refracted = self.trace(point, direction, &through, left, depth + 1);
            }
        }
        let (r, t) = (object.reflection, object.transparency);
        (visible * (1.0 - r) + reflected * r) * (1.0 - t) + refracted * t
    }

    // --- sections 2 and 5 ---
    fn camera_ray(&self, row: f64, col: f64) -> Vec3 {
        let v_dir = unit(self.direction);
        let (v_x, v_y) = match self.axes {
            Some((x, y)) => (unit(x), unit(y)), // F5
            None => {
                let v_x = unit(cross(self.up, v_dir)); // C1
                (v_x, cross(v_dir, v_x))
            }
        };
        let span = 2.0 * (std::f64::consts::PI * self.fov / 360.0).tan();
        let ratio = span / self.width.max(self.height) as f64;
        let x = ratio * (col - self.width as f64 * 0.5);
        let y = ratio * (-row + self.height as f64 * 0.5);
        unit(v_x * x + v_y * y + v_dir)
    }

    fn sides(&self, point: Vec3) -> Sides {
        let inside = |o: &Object| if self.exact { o.regular(point) < 0.0 } else { o.is_inside(point) };
        self.objects.iter().map(inside).collect()
    }
}

#[derive(Default)]
struct Answer {
    color: Vec<f64>,
    index: Vec<i32>,
    t: Vec<f64>,
    normal: Vec<f64>,
}

impl Answer {
    fn push(&mut self, scene: &Scene, o: Vec3, d: Vec3, sides: &Sides, samples: &[Vec3]) {
        let hit = scene.first_hit(o, d, sides, scene.max_distance);
        let mut sum = Vec3::default();
        for sample in samples {
            sum = sum + scene.trace(o, *sample, sides, scene.max_distance, 0);
        }
        let color = sum * (1.0 / samples.len() as f64);
        let normal = hit.object.map_or(Vec3::default(), |k| scene.normal(k, o, d, hit.t));
        self.color.extend([color.x, color.y, color.z]);
        self.normal.extend([normal.x, normal.y, normal.z]);
        self.index.push(hit.object.map_or(-1, |k| k as i32));
        self.t.push(hit.t);
    }
}

fn answer(scene: &Scene) -> (Answer, Vec<usize>) {
    let mut found = Answer::default();
    if !scene.rays.is_empty() {
        for &(o, d) in &scene.rays {
            found.push(scene, o, d, &scene.sides(o), &[d]);
        }
        return (found, vec![scene.rays.len()]);
    }
    let (n, sides) = (scene.samples, scene.sides(scene.position));
    for row in 0..scene.height {
        for col in 0..scene.width {
            let mut samples = Vec::new();
            for k in 0..n * n {
                let (i, j) = ((k / n) as f64, (k % n) as f64); // C2
                samples.push(scene.camera_ray(row as f64 + (i + 0.5) / n as f64, col as f64 + (j + 0.5) / n as f64));
            }
            let d = scene.camera_ray(row as f64 + 0.5, col as f64 + 0.5);
            found.push(scene, scene.position, d, &sides, &samples);
        }
    }
    (found, vec![scene.height, scene.width])
}

// --- a scene as text ----------------------------------------------------------------------------------------------------

struct Words<'a>(std::str::SplitWhitespace<'a>);

impl Words<'_> {
    fn word(&mut self) -> &str {
        self.0.next().expect("a line is too short")
    }
    fn number(&mut self) -> f64 {
        self.word().parse().expect("not a number")
    }
    fn count(&mut self) -> usize {
        self.word().parse().expect("not a whole number")
    }
    fn vec3(&mut self) -> Vec3 {
        vec3(self.number(), self.number(), self.number())
    }
}

fn read_object(w: &mut Words) -> Object {
    let (color, reflection, transparency, index) = (w.vec3(), w.number(), w.number(), w.number());
    let (center, axis, degrees, sign) = (w.vec3(), unit(w.vec3()), w.number(), w.number());
    let surface = match w.word() {
        "plane" => Surface::Plane(w.number(), w.number(), w.number()),
        "sphere" => Surface::Sphere(w.number()),
        "ellipsoid" => Surface::Ellipsoid(w.number(), w.number(), w.number()),
        "torus" => Surface::Torus(w.number(), w.number()),
        "paraboloid" => Surface::Paraboloid(w.number(), w.number()),
        "heart" => Surface::Heart,
        other => panic!("unknown surface {other}"),
    };
    let (mut cos, mut sin) = (degrees.to_radians().cos(), degrees.to_radians().sin());
    if degrees % 90.0 == 0.0 {
        (cos, sin) = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][(degrees / 90.0).rem_euclid(4.0) as usize];
    }
    let turned = |v: Vec3| v * cos + cross(axis, v) * sin + axis * (dot(axis, v) * (1.0 - cos));
    let axes = [turned(vec3(1.0, 0.0, 0.0)), turned(vec3(0.0, 1.0, 0.0)), turned(vec3(0.0, 0.0, 1.0))];
    Object { surface, sign, center, axes, color, reflection, transparency, index, shadow: true }
}

fn read_scene(text: &str, exact: bool) -> Scene {
    let mut s = Scene { exact, ..Scene::default() };
    for line in text.lines() {
        let mut w = Words(line.split_whitespace());
        match w.word() {
            "camera" => {
                (s.position, s.direction, s.up, s.fov) = (w.vec3(), w.vec3(), w.vec3(), w.number());
                (s.width, s.height) = (w.count(), w.count());
            }
            "axes" => s.axes = Some((w.vec3(), w.vec3())),
            "tracing" => {
                (s.h, s.tolerance, s.max_iterations) = (w.number(), w.number(), w.count());
                (s.max_distance, s.max_depth, s.samples) = (w.number(), w.count(), w.count());
            }
            "figures" => {
                s.balanced = w.word() == "balanced";
                s.ambient = w.number();
                s.opaque_only = w.word() == "opaque_only";
                s.shared_range = w.word() == "path";
            }
            "background" => s.background = w.vec3(),
            "light" => s.lights.push((w.vec3(), w.vec3())),
            "object" => s.objects.push(read_object(&mut w)),
            "shadowless" => {
                let k = w.count();
                s.objects[k].shadow = false;
            }
            "misprint" => s.misprint = true,
            "ray" => s.rays.push((w.vec3(), w.vec3())),
            other => panic!("unknown line {other}"),
        }
    }
    s
}

// --- the protocol -------------------------------------------------------------------------------------------------------

fn field<'a>(line: &'a str, name: &str) -> &'a str {
    let key = format!("\"{name}\": ");
    let start = line.find(&key).expect("not a request") + key.len();
    let end = line[start..].find([',', '}']).expect("not a request") + start;
    line[start..end].trim_matches('"')
}

fn main() -> io::Result<()> {
    let exact = std::env::args().any(|word| word == "exact");
    let (mut input, mut output) = (io::stdin().lock(), io::stdout().lock());
    let mut line = String::new();
    while input.read_line(&mut line)? > 0 {
        if field(&line, "op") == "hello" {
            let level = if exact { "model" } else { "algorithm" };
            writeln!(
                output,
                "{{\"protocol\": 1, \"name\": \"raytruth Rust example\", \"levels\": [\"{level}\"], \"precision\": 64, \
                 \"switches\": [\"E1\", \"F1\", \"F2\", \"F3\", \"F4\", \"F5\"]}}"
            )?;
        } else {
            let mut text = vec![0; field(&line, "bytes").parse().expect("not a size")];
            input.read_exact(&mut text)?;
            let scene = read_scene(std::str::from_utf8(&text).expect("not text"), exact);
            let (found, shape) = answer(&scene);
            let shape = shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
            let mut body = Vec::new();
            found.color.iter().for_each(|v| body.extend(v.to_le_bytes()));
            found.index.iter().for_each(|v| body.extend(v.to_le_bytes()));
            found.t.iter().for_each(|v| body.extend(v.to_le_bytes()));
            found.normal.iter().for_each(|v| body.extend(v.to_le_bytes()));
            writeln!(
                output,
                "{{\"seq\": {}, \"state\": \"ok\", \"bytes\": {}, \"arrays\": [\
                 {{\"name\": \"color\", \"dtype\": \"float64\", \"shape\": [{shape}, 3]}}, \
                 {{\"name\": \"index\", \"dtype\": \"int32\", \"shape\": [{shape}]}}, \
                 {{\"name\": \"t\", \"dtype\": \"float64\", \"shape\": [{shape}]}}, \
                 {{\"name\": \"normal\", \"dtype\": \"float64\", \"shape\": [{shape}, 3]}}]}}",
                field(&line, "seq"),
                body.len()
            )?;
            output.write_all(&body)?;
        }
        output.flush()?;
        line.clear();
    }
    Ok(())
}
