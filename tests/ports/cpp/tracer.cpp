// A port of the document's ray tracer as a user would write it: one file, scalar, no intrinsics, no bounding boxes.
//
//   g++ -std=c++17 -O3 -march=native -pthread tracer.cpp -o tracer
//   python -m raytruth.converters.plain figure-17-scene1 scene.txt && ./tracer scene.txt picture.raw 2
//   raytruth check-port -- ./tracer --serve          (or --serve-exact: no root is missed that can be seen, the model's truth)
//
// Written from the document (sections in brackets) and reference_tracer/DECISIONS.md (ids such as M3), independently of
// the Python tracer, which it checks and is timed against. It reads the plain text of converters/plain.py. It writes,
// rows from the top and each in one block, colour (3 doubles a pixel), object (int32, -1 for none) and distance
// (double) of the pixel's centre, in the machine's byte order, and prints the seconds of rendering alone as JSON.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

const double PI = 3.14159265358979323846;

struct Vec {
    double x = 0, y = 0, z = 0;
};
Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec operator-(Vec a) { return {-a.x, -a.y, -a.z}; }
Vec operator*(Vec a, double s) { return {a.x * s, a.y * s, a.z * s}; }
Vec operator*(Vec a, Vec b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }  // colours
double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
double length(Vec a) { return std::sqrt(dot(a, a)); }
Vec normalize(Vec a) { return a * (1 / length(a)); }

// --- objects [3, 7.1] ------------------------------------------------------------------------------------------------
// f and its gradient in the surface's own frame. The normal is the gradient, but for the heart (O5).

struct Surface {
    virtual ~Surface() = default;
    virtual double f(Vec p) const = 0;
    virtual Vec gradient(Vec p) const = 0;
    virtual Vec normal(Vec p) const { return gradient(p); }
    virtual double regular(Vec p) const { return f(p); }  // of the same zeros, and the gradient `normal`
};

struct Plane : Surface {
    double a, b, c;
    double f(Vec p) const override { return p.x * a + p.y * b + p.z * c; }
    Vec gradient(Vec) const override { return {a, b, c}; }
};

struct Sphere : Surface {
    double r;
    double f(Vec p) const override { return p.x * p.x + p.y * p.y + p.z * p.z - r * r; }
    Vec gradient(Vec p) const override { return p * 2; }
};

struct Ellipsoid : Surface {
    double a, b, c;
    double f(Vec p) const override { return p.x * p.x / (a * a) + p.y * p.y / (b * b) + p.z * p.z / (c * c) - 1; }
    Vec gradient(Vec p) const override { return {2 * p.x / (a * a), 2 * p.y / (b * b), 2 * p.z / (c * c)}; }
};

struct Torus : Surface {
    double R, r;
    double f(Vec p) const override {
        double q = std::sqrt(p.x * p.x + p.y * p.y) - R;
        return q * q + p.z * p.z - r * r;
    }
    Vec gradient(Vec p) const override {
        double s = std::sqrt(p.x * p.x + p.y * p.y);
        double k = 2 * (s - R) / s;
        return {k * p.x, k * p.y, 2 * p.z};
    }
};

struct Paraboloid : Surface {
    double a, b;
    double f(Vec p) const override { return p.x * p.x / (a * a) + p.y * p.y / (b * b) - p.z; }
    Vec gradient(Vec p) const override { return {2 * p.x / (a * a), 2 * p.y / (b * b), -1}; }
};

struct Heart : Surface {
    double f(Vec p) const override {
        double x2 = p.x * p.x, y2 = p.y * p.y, z2 = p.z * p.z, y3 = y2 * p.y;
        double A = x2 + 9.0 / 4.0 * z2 + y2 - 1;
        return A * A * A - x2 * y3 - 9.0 / 80.0 * z2 * y3;
    }
    Vec gradient(Vec p) const override {
        double x2 = p.x * p.x, y2 = p.y * p.y, z2 = p.z * p.z, y3 = y2 * p.y;
        double A = x2 + 9.0 / 4.0 * z2 + y2 - 1;
        double k = 3 * A * A;
        return {k * 2 * p.x - 2 * p.x * y3,
                k * 2 * p.y - 3 * x2 * y2 - 27.0 / 80.0 * z2 * y2,
                k * 4.5 * p.z - 9.0 / 40.0 * p.z * y3};
    }
    // grad f vanishes on an ellipse (O5): the normal comes from A - y cbrt(B), B = x^2 + 9/80 z^2, of the same zeros
    Vec normal(Vec p) const override {
        double root = std::cbrt(p.x * p.x + 9.0 / 80.0 * p.z * p.z);
        double k = p.y / (3 * root * root);
        return {2 * p.x - k * 2 * p.x, 2 * p.y - root, 4.5 * p.z - k * 9.0 / 40.0 * p.z};
    }
    double regular(Vec p) const override {
        double x2 = p.x * p.x, z2 = p.z * p.z;
        return x2 + 9.0 / 4.0 * z2 + p.y * p.y - 1 - p.y * std::cbrt(x2 + 9.0 / 80.0 * z2);
    }
};

struct Object {
    std::unique_ptr<Surface> surface;
    double sign = 1;  // -1 where f > 0 is the inside (O1)
    Vec center;
    bool rotated = false;
    Vec column_x, column_y, column_z;  // of the rotation matrix (O3): the surface's axes in the world
    bool shadow = true;
    Vec color;
    double reflection = 0, transparency = 0, refractive_index = 1;

    Vec to_local(Vec direction) const {
        return rotated ? Vec{dot(column_x, direction), dot(column_y, direction), dot(column_z, direction)} : direction;
    }
    Vec to_world(Vec direction) const {
        return rotated ? column_x * direction.x + column_y * direction.y + column_z * direction.z : direction;
    }
    double f(Vec point) const { return sign * surface->f(to_local(point - center)); }
    Vec gradient(Vec point) const { return to_world(surface->gradient(to_local(point - center))) * sign; }
    Vec normal(Vec point) const { return normalize(to_world(surface->normal(to_local(point - center)))); }
    double regular(Vec point) const { return sign * surface->regular(to_local(point - center)); }
    double slope(Vec point, Vec d) const { return sign * dot(to_world(surface->normal(to_local(point - center))), d); }
    bool is_inside(Vec point) const {  // 0 and what is not finite are outside (O1, M7)
        double value = f(point);
        return value < 0 && std::isfinite(value);
    }
    void rotate(Vec axis, double degrees) {  // Rodrigues' formula; quarter turns exactly
        rotated = true;
        Vec k = normalize(axis);
        double quarter = degrees / 90, angle = degrees * PI / 180;
        double c = std::cos(angle), s = std::sin(angle);
        if (quarter == std::floor(quarter)) {
            int turns = static_cast<int>(quarter - 4 * std::floor(quarter / 4));
            c = (turns == 0) - (turns == 2);
            s = (turns == 1) - (turns == 3);
        }
        auto turned = [&](Vec v) { return v * c + cross(k, v) * s + k * (dot(k, v) * (1 - c)); };
        column_x = turned({1, 0, 0});
        column_y = turned({0, 1, 0});
        column_z = turned({0, 0, 1});
    }
};

struct Light {
    Vec position, brightness;
};

struct GivenRay {
    Vec origin, direction;
};

using Sides = std::vector<char>;  // for every object, whether a ray runs inside it

struct Hit {
    double t = std::numeric_limits<double>::infinity();
    int index = -1;
    double used = 0;  // of the ray's range: whole steps, in the model t
};

struct Scene {
    Vec position, direction, up;
    bool has_axes = false;  // of its own, v_x and v_y (F5)
    Vec v_x, v_y;
    double fov = 60;
    int width = 0, height = 0;
    double step_size = 0.1, tolerance = 1e-12, max_distance = 30;
    int max_iterations = 20, max_depth = 8, samples = 1;
    bool balanced = false, opaque_only = false, shared_range = false;  // F1, F3, F4
    bool as_printed = false;  // E1
    bool exact = false;       // the model's truth
    double ambient = 0;  // F2
    Vec background;
    std::vector<Object> objects;
    std::vector<Light> lights;
    std::vector<GivenRay> rays;  // to trace in place of the camera's

    // --- tracing the light rays [4.1, 4.2] ---
    Hit first_hit(Vec o, Vec d, const Sides& sides, double range) const {
        Hit hit;
        if (!std::isfinite(dot(d, d))) return hit;  // the misprint makes directions of NaN (E1)
        if (exact) {
            for (size_t k = 0; k < objects.size(); k++) {
                double root = crossing(objects[k], o, d, sides[k], 0, std::min(range, hit.t));
                if (root < hit.t) hit = {root, static_cast<int>(k), root};
            }
            return hit;
        }
        double t = 0;
        for (int step = 1; t < range && hit.index < 0; step++) {
            double before = (step - 1) * step_size;
            t = std::min(step * step_size, range);
            Vec point = o + d * t;
            for (size_t k = 0; k < objects.size(); k++) {
                if (objects[k].is_inside(point) != static_cast<bool>(sides[k])) {
                    double root = newton(objects[k], o, d, 0.5 * (before + t));
                    if (root < hit.t) hit = {root, static_cast<int>(k), t};  // refine each, the smallest t wins (M4)
                }
            }
        }
        return hit;
    }

    // The model's truth: the first t in (from, range) at which the ray is no longer `inside`, or no longer outside. Steps are
    // cut where g has an extremum, so that two roots in one step are seen; roots are bisected.
    double crossing(const Object& object, Vec o, Vec d, bool inside, double from, double range) const {
        const double fine = 0.02, towards = inside ? 1 : -1;
        auto crossed = [&](double t) { return (object.regular(o + d * t) < 0) != inside; };
        auto nears = [&](double t) { return object.slope(o + d * t, d) * towards > 0; };
        for (double t = from; t < range;) {
            double next = std::min(t + fine, range), low = t, high = next;
            if (!crossed(high) && nears(low) && !nears(high)) {
                double a = low;
                for (int i = 0; i < 60; i++) (nears(0.5 * (a + high)) ? a : high) = 0.5 * (a + high);
            }
            if (crossed(high)) {
                for (double m = 0.5 * (low + high); m > low && m < high; m = 0.5 * (low + high)) (crossed(m) ? high : low) = m;
                return high;
            }
            t = next;
        }
        return std::numeric_limits<double>::infinity();
    }

    double newton(const Object& object, Vec o, Vec d, double t) const {
        for (int i = 0; i < max_iterations; i++) {
            Vec point = o + d * t;
            double dt = object.f(point) / dot(object.gradient(point), d);
            if (!std::isfinite(dt)) break;
            t -= dt;
            if (std::abs(dt) <= tolerance * std::max(1.0, std::abs(t))) break;  // M6
        }
        return t;
    }

    // --- shadow ray [4.3.1] ---
    double light_through(Vec o, Vec d, double distance, Sides sides) const {
        double intensity = 1, t = 0;
        for (size_t k = 0; exact && k < objects.size(); k++) {
            if (!objects[k].shadow || (opaque_only && objects[k].transparency > 0)) continue;
            double from = 0;
            while (intensity > 0 && (from = crossing(objects[k], o, d, sides[k], from, distance)) < distance) {
                intensity *= objects[k].transparency;
                sides[k] = !sides[k];
            }
        }
        if (exact) return intensity;
        for (int step = 1; t < distance && intensity > 0; step++) {
            t = std::min(step * step_size, distance);
            Vec point = o + d * t;
            for (size_t k = 0; k < objects.size(); k++) {
                if (!objects[k].shadow || (opaque_only && objects[k].transparency > 0)) continue;  // F3
                char inside = objects[k].is_inside(point);
                if (inside != sides[k]) {
                    intensity *= objects[k].transparency;  // at every crossing (L3)
                    sides[k] = inside;
                }
            }
        }
        return intensity;
    }

    // --- simulating the collision [4.3] ---
    Vec trace(Vec o, Vec d, const Sides& sides, double range, int depth) const {
        if (depth > max_depth) return background;  // D1
        return shade(o, d, sides, range, first_hit(o, d, sides, range), depth);
    }

    Vec shade(Vec o, Vec d, const Sides& sides, double range, Hit hit, int depth) const {
        if (hit.index < 0) return background;  // D2
        const Object& object = objects[hit.index];
        Vec point = o + d * hit.t;
        Vec normal = object.normal(point);
        if (dot(d, normal) > 0) normal = -normal;  // turned against the ray (N1)
        double cos1 = std::min(-dot(d, normal), 1.0);

        // every ray has max_distance of its own (M5), or shares it with those that follow (F4)
        double left = shared_range ? range - hit.used : max_distance;
        if (left < 1e-12 * max_distance) left = 0;

        Vec illumination = Vec{1, 1, 1} * ambient;  // F2
        for (const Light& light : lights) {
            double distance = length(light.position - point);
            Vec shadow_dir = (light.position - point) * (1 / distance);
            double cos = dot(shadow_dir, normal);
            if (!(cos > 0)) continue;  // L2
            double intensity = light_through(point, shadow_dir, distance, sides);
            Vec more = light.brightness * (cos * intensity), one{1, 1, 1};
            illumination = balanced ? one - (one - illumination) * (one - more) : illumination + more;  // F1, L1
        }
        Vec visible = object.color * illumination;

        Vec reflection_dir = normalize(d + normal * (2 * cos1));  // [4.3.2], renormalised (R4)
        Vec reflected, refracted;
        if (object.reflection > 0) reflected = trace(point, reflection_dir, sides, left, depth + 1);

        if (object.transparency > 0) {  // [4.3.3]
            bool leaving = sides[hit.index];  // pairwise with air, by the side the ray is on (R1)
            double n1 = leaving ? object.refractive_index : 1, n2 = leaving ? 1 : object.refractive_index;
            double sin1 = std::sqrt(std::max(1 - cos1 * cos1, 0.0));
            if (sin1 > n2 / n1) {  // total internal reflection: the shared direction is traced once (R3)
                refracted = object.reflection > 0 ? reflected : trace(point, reflection_dir, sides, left, depth + 1);
            } else {
                double sin2 = sin1 * (as_printed ? n2 / n1 : n1 / n2);  // E1
                double cos2 = std::sqrt(as_printed ? 1 - sin2 * sin2 : std::max(1 - sin2 * sin2, 0.0));
                Vec refraction_dir = normalize((d + normal * cos1) * (n1 / n2) - normal * cos2);
                Sides through = sides;
                through[hit.index] = !through[hit.index];  // M3
                refracted = trace(point, refraction_dir, through, left, depth + 1);
            }
        }
        double R = object.reflection, T = object.transparency;  // [4.3.4]
        return (visible * (1 - R) + reflected * R) * (1 - T) + refracted * T;
    }
};

// --- the picture [2, 5, 6] -------------------------------------------------------------------------------------------

struct Picture {
    std::vector<Vec> color;
    std::vector<int32_t> index;
    std::vector<double> t;
    std::vector<Vec> normal;
};

struct Camera {  // C1, F5
    Vec v_dir, v_x, v_y;
    double ratio;
    explicit Camera(const Scene& scene) {
        v_dir = normalize(scene.direction);
        v_x = normalize(scene.has_axes ? scene.v_x : cross(scene.up, v_dir));
        v_y = scene.has_axes ? normalize(scene.v_y) : cross(v_dir, v_x);
        ratio = 2 * std::tan(PI * scene.fov / 360) / std::max(scene.width, scene.height);
    }
    Vec ray(const Scene& scene, double row, double col) const {
        double x = ratio * (col - scene.width * 0.5);
        double y = ratio * (-row + scene.height * 0.5);
        return normalize(v_x * x + v_y * y + v_dir);
    }
};

// what the ray through a pixel's centre met
void store_hit(const Scene& scene, Vec o, Vec d, Hit hit, size_t pixel, Picture& picture) {
    picture.index[pixel] = hit.index;
    picture.t[pixel] = hit.t;
    Vec normal;
    if (hit.index >= 0) normal = scene.objects[hit.index].normal(o + d * hit.t);
    picture.normal[pixel] = dot(d, normal) > 0 ? -normal : normal;
}

void render_row(const Scene& scene, const Camera& camera, const Sides& sides, int row, Picture& picture) {
    int n = scene.samples;
    for (int col = 0; col < scene.width; col++) {
        Vec d = camera.ray(scene, row + 0.5, col + 0.5);
        Hit centre = scene.first_hit(scene.position, d, sides, scene.max_distance);
        Vec sum;
        if (n == 1) sum = scene.shade(scene.position, d, sides, scene.max_distance, centre, 0);
        for (int i = 0; i < n && n > 1; i++)  // sub-pixel centres, plain mean (C2)
            for (int j = 0; j < n; j++) {
                Vec sample = camera.ray(scene, row + (i + 0.5) / n, col + (j + 0.5) / n);
                sum = sum + scene.trace(scene.position, sample, sides, scene.max_distance, 0);
            }
        size_t pixel = static_cast<size_t>(row) * scene.width + col;
        picture.color[pixel] = sum * (1.0 / (n * n));
        store_hit(scene, scene.position, d, centre, pixel, picture);
    }
}

Picture blank(size_t pixels) {
    return {std::vector<Vec>(pixels), std::vector<int32_t>(pixels), std::vector<double>(pixels), std::vector<Vec>(pixels)};
}

Sides sides_at(const Scene& scene, Vec point) {  // M3: where a ray begins that has no parent
    Sides sides;
    for (const Object& object : scene.objects)
        sides.push_back(scene.exact ? object.regular(point) < 0 : object.is_inside(point));
    return sides;
}

Picture trace_given(const Scene& scene) {
    Picture picture = blank(scene.rays.size());
    for (size_t k = 0; k < scene.rays.size(); k++) {
        Vec o = scene.rays[k].origin, d = scene.rays[k].direction;
        Sides sides = sides_at(scene, o);
        Hit hit = scene.first_hit(o, d, sides, scene.max_distance);
        picture.color[k] = scene.shade(o, d, sides, scene.max_distance, hit, 0);
        store_hit(scene, o, d, hit, k, picture);
    }
    return picture;
}

Picture render(const Scene& scene, int threads) {
    Camera camera(scene);
    Sides sides = sides_at(scene, scene.position);
    Picture picture = blank(static_cast<size_t>(scene.width) * scene.height);
    std::vector<std::thread> workers;
    for (int k = 0; k < threads; k++)
        workers.emplace_back([&, k] {
            for (int row = k; row < scene.height; row += threads) render_row(scene, camera, sides, row, picture);
        });
    for (std::thread& worker : workers) worker.join();
    return picture;
}

// --- files -----------------------------------------------------------------------------------------------------------

std::istream& operator>>(std::istream& in, Vec& v) { return in >> v.x >> v.y >> v.z; }

std::unique_ptr<Surface> read_surface(std::istream& in, const std::string& kind) {
    if (kind == "plane") { auto s = std::make_unique<Plane>(); in >> s->a >> s->b >> s->c; return s; }
    if (kind == "sphere") { auto s = std::make_unique<Sphere>(); in >> s->r; return s; }
    if (kind == "ellipsoid") { auto s = std::make_unique<Ellipsoid>(); in >> s->a >> s->b >> s->c; return s; }
    if (kind == "torus") { auto s = std::make_unique<Torus>(); in >> s->R >> s->r; return s; }
    if (kind == "paraboloid") { auto s = std::make_unique<Paraboloid>(); in >> s->a >> s->b; return s; }
    if (kind == "heart") return std::make_unique<Heart>();
    throw std::runtime_error("unknown surface " + kind);
}

bool either(const std::string& word, const char* yes, const char* no) {
    if (word != yes && word != no) throw std::runtime_error("unknown word " + word);
    return word == yes;
}

Scene read_scene(std::istream& file) {
    Scene scene;
    std::string line, key, kind;
    while (std::getline(file, line)) {
        std::istringstream in(line);
        in >> key;
        if (key == "camera") {
            in >> scene.position >> scene.direction >> scene.up >> scene.fov >> scene.width >> scene.height;
        } else if (key == "tracing") {
            in >> scene.step_size >> scene.tolerance >> scene.max_iterations;
            in >> scene.max_distance >> scene.max_depth >> scene.samples;
        } else if (key == "axes") {
            in >> scene.v_x >> scene.v_y;
            scene.has_axes = true;
        } else if (key == "figures") {
            std::string lights, shadows, range;
            if (!(in >> lights >> scene.ambient >> shadows >> range)) throw std::runtime_error("incomplete line: " + line);
            scene.balanced = either(lights, "balanced", "sum");
            scene.opaque_only = either(shadows, "opaque_only", "attenuate");
            scene.shared_range = either(range, "path", "ray");
        } else if (key == "shadowless") {
            size_t k;
            if (in >> k) scene.objects.at(k).shadow = false;
        } else if (key == "misprint") {
            scene.as_printed = true;
        } else if (key == "ray") {
            GivenRay ray;
            in >> ray.origin >> ray.direction;
            scene.rays.push_back(ray);
        } else if (key == "background") {
            in >> scene.background;
        } else if (key == "light") {
            Light light;
            in >> light.position >> light.brightness;
            scene.lights.push_back(light);
        } else if (key == "object") {
            Object object;
            Vec axis;
            double degrees;
            in >> object.color >> object.reflection >> object.transparency >> object.refractive_index;
            in >> object.center >> axis >> degrees >> object.sign >> kind;
            object.surface = read_surface(in, kind);
            if (degrees != 0) object.rotate(axis, degrees);
            scene.objects.push_back(std::move(object));
        } else {
            throw std::runtime_error("unknown line " + key);
        }
        if (!in) throw std::runtime_error("incomplete line: " + line);
    }
    return scene;
}

Scene read_scene(const std::string& path) {
    std::ifstream file(path);
    if (!file) throw std::runtime_error(path + " cannot be read");
    return read_scene(file);
}

template <typename T>
void write_block(std::ostream& file, const std::vector<T>& block) {
    file.write(reinterpret_cast<const char*>(block.data()), static_cast<std::streamsize>(block.size() * sizeof(T)));
}

// --- raytruth's protocol: docs/ports/protocol.md ----------------------------------------------------------------------

void serve(int threads, bool exact) {
    std::string line;
    while (std::getline(std::cin, line)) {
        int seq = 0;
        size_t bytes = 0;
        char op[16] = "", level[16] = "";
        if (std::sscanf(line.c_str(), R"({"seq": %d, "op": "%15[a-z]", "level": "%15[a-z]", "bytes": %zu)", &seq, op, level,
                        &bytes) != 4)
            throw std::runtime_error("not a request: " + line);
        if (op == std::string("hello")) {
            std::cout << R"({"protocol": 1, "name": "raytruth C++ example", "version": "1", "levels": [")"
                      << (exact ? "model" : "algorithm") << R"("], )"
                      << R"("precision": 64, "switches": ["E1", "F1", "F2", "F3", "F4", "F5"]})" << std::endl;
            continue;
        }
        std::string text(bytes, ' ');
        std::cin.read(text.data(), static_cast<std::streamsize>(bytes));
        std::istringstream in(text);
        Scene scene = read_scene(in);
        scene.exact = exact;
        Picture picture = scene.rays.empty() ? render(scene, threads) : trace_given(scene);
        size_t n = picture.t.size();
        std::string shape = scene.rays.empty() ? std::to_string(scene.height) + ", " + std::to_string(scene.width)
                                               : std::to_string(n);
        std::cout << R"({"seq": )" << seq << R"(, "state": "ok", "bytes": )" << n * 60 << R"(, "arrays": [)"
                  << R"({"name": "color", "dtype": "float64", "shape": [)" << shape << ", 3]}, "
                  << R"({"name": "index", "dtype": "int32", "shape": [)" << shape << "]}, "
                  << R"({"name": "t", "dtype": "float64", "shape": [)" << shape << "]}, "
                  << R"({"name": "normal", "dtype": "float64", "shape": [)" << shape << ", 3]}]}\n";
        write_block(std::cout, picture.color);
        write_block(std::cout, picture.index);
        write_block(std::cout, picture.t);
        write_block(std::cout, picture.normal);
        std::cout.flush();
    }
}

int main(int argc, char** argv) try {
    std::string option = argc > 1 ? argv[1] : "";
    if (option == "--serve" || option == "--serve-exact") return serve(2, option == "--serve-exact"), 0;
    if (argc < 3 || argc > 4) throw std::runtime_error("usage: tracer SCENE.txt PICTURE.raw [THREADS]");
    Scene scene = read_scene(argv[1]);
    int threads = argc > 3 ? std::max(1, std::stoi(argv[3])) : 2;
    auto start = std::chrono::steady_clock::now();
    std::clock_t cpu = std::clock();
    Picture picture = render(scene, threads);
    std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    double cpu_seconds = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    std::ofstream file(argv[2], std::ios::binary);
    write_block(file, picture.color);
    write_block(file, picture.index);
    write_block(file, picture.t);
    if (!file) throw std::runtime_error(std::string(argv[2]) + " cannot be written");
    std::cout << "{\"seconds\": " << seconds.count() << ", \"cpu_seconds\": " << cpu_seconds
              << ", \"threads\": " << threads << "}\n";
} catch (const std::exception& error) {
    std::cerr << "tracer: " << error.what() << "\n";
    return 1;
}
