// The document's ray tracer in Go, one file, and raytruth's protocol: the trial whether the bundle of `raytruth truth` alone
// is enough to write a port from. README.md beside it says what was unclear.
//
//	go build tracer.go && raytruth check-port -- ./tracer
package main

import (
	"bufio"
	"bytes"
	"encoding/binary"
	"encoding/json"
	"fmt"
	"io"
	"math"
	"os"
	"strconv"
	"strings"
)

type V struct{ X, Y, Z float64 }

func (a V) Add(b V) V       { return V{a.X + b.X, a.Y + b.Y, a.Z + b.Z} }
func (a V) Sub(b V) V       { return V{a.X - b.X, a.Y - b.Y, a.Z - b.Z} }
func (a V) Mul(s float64) V { return V{a.X * s, a.Y * s, a.Z * s} }
func (a V) Times(b V) V     { return V{a.X * b.X, a.Y * b.Y, a.Z * b.Z} }
func (a V) Dot(b V) float64 { return a.X*b.X + a.Y*b.Y + a.Z*b.Z }
func (a V) Cross(b V) V     { return V{a.Y*b.Z - a.Z*b.Y, a.Z*b.X - a.X*b.Z, a.X*b.Y - a.Y*b.X} }
func (a V) Len() float64    { return math.Sqrt(a.Dot(a)) }
func (a V) Unit() V         { return a.Mul(1 / a.Len()) }
func finite(x float64) bool { return !math.IsNaN(x) && !math.IsInf(x, 0) }
func grey(x float64) V      { return V{x, x, x} }

// --- surfaces --------------------------------------------------------------------------------------------------------------

type Object struct {
	kind       string
	p          []float64 // parameters, in the order of the specification's table
	sign       float64
	center     V
	axes       [3]V
	color      V
	r, t, n    float64
	shadowless bool
}

func (o *Object) local(v V) V { return V{o.axes[0].Dot(v), o.axes[1].Dot(v), o.axes[2].Dot(v)} }
func (o *Object) world(v V) V {
	return o.axes[0].Mul(v.X).Add(o.axes[1].Mul(v.Y)).Add(o.axes[2].Mul(v.Z))
}

func (o *Object) f(point V) float64 {
	l := o.local(point.Sub(o.center))
	x, y, z, p := l.X, l.Y, l.Z, o.p
	switch o.kind {
	case "plane":
		return o.sign * (p[0]*x + p[1]*y + p[2]*z)
	case "sphere":
		return o.sign * (x*x + y*y + z*z - p[0]*p[0])
	case "ellipsoid":
		return o.sign * (x*x/(p[0]*p[0]) + y*y/(p[1]*p[1]) + z*z/(p[2]*p[2]) - 1)
	case "torus":
		q := math.Sqrt(x*x+y*y) - p[0]
		return o.sign * (q*q + z*z - p[1]*p[1])
	case "paraboloid":
		return o.sign * (x*x/(p[0]*p[0]) + y*y/(p[1]*p[1]) - z)
	case "heart":
		a := x*x + 2.25*z*z + y*y - 1
		return o.sign * (a*a*a - x*x*y*y*y - 9.0/80*z*z*y*y*y)
	}
	panic("unknown surface " + o.kind)
}

// The gradient of f; with `regular`, of the form that normals are taken from.
func (o *Object) gradient(point V, regular bool) V {
	l := o.local(point.Sub(o.center))
	x, y, z, p := l.X, l.Y, l.Z, o.p
	var g V
	switch o.kind {
	case "plane":
		g = V{p[0], p[1], p[2]}
	case "sphere":
		g = V{2 * x, 2 * y, 2 * z}
	case "ellipsoid":
		g = V{2 * x / (p[0] * p[0]), 2 * y / (p[1] * p[1]), 2 * z / (p[2] * p[2])}
	case "torus":
		s := math.Sqrt(x*x + y*y)
		g = V{2 * (s - p[0]) / s * x, 2 * (s - p[0]) / s * y, 2 * z}
	case "paraboloid":
		g = V{2 * x / (p[0] * p[0]), 2 * y / (p[1] * p[1]), -1}
	case "heart":
		if regular {
			q := math.Cbrt(x*x + 9.0/80*z*z)
			g = V{2*x - 2*x*y/(3*q*q), 2*y - q, 4.5*z - 9.0/40*z*y/(3*q*q)}
		} else {
			a := x*x + 2.25*z*z + y*y - 1
			g = V{6*a*a*x - 2*x*y*y*y, 6*a*a*y - 3*x*x*y*y - 27.0/80*z*z*y*y, 13.5*a*a*z - 9.0/40*z*y*y*y}
		}
	}
	return o.world(g).Mul(o.sign)
}

func (o *Object) inside(point V) bool {
	f := o.f(point)
	return f < 0 && finite(f)
}

// --- the scene -------------------------------------------------------------------------------------------------------------

type Ray struct {
	o, d  V
	sides []bool
	left  float64 // its range
}

type Scene struct {
	position, direction, up, vx, vy     V
	hasAxes                             bool
	fov                                 float64
	width, height                       int
	h, tolerance, maxDistance           float64
	maxIterations, maxDepth, samples    int
	background                          V
	lights, brightness                  []V
	objects                             []*Object
	rays                                []Ray
	balanced, opaqueOnly, path, printed bool
	ambient                             float64
}

type words []string

func (w *words) word() string {
	first := (*w)[0]
	*w = (*w)[1:]
	return first
}
func (w *words) number() float64 {
	x, err := strconv.ParseFloat(w.word(), 64)
	if err != nil {
		panic(err)
	}
	return x
}
func (w *words) count() int { return int(w.number()) }
func (w *words) vector() V  { return V{w.number(), w.number(), w.number()} }

func readScene(text string) *Scene {
	s := &Scene{}
	for _, line := range strings.Split(strings.TrimSpace(text), "\n") {
		w := words(strings.Fields(line))
		switch key := w.word(); key {
		case "camera":
			s.position, s.direction, s.up, s.fov = w.vector(), w.vector(), w.vector(), w.number()
			s.width, s.height = w.count(), w.count()
		case "axes":
			s.vx, s.vy, s.hasAxes = w.vector(), w.vector(), true
		case "tracing":
			s.h, s.tolerance, s.maxIterations = w.number(), w.number(), w.count()
			s.maxDistance, s.maxDepth, s.samples = w.number(), w.count(), w.count()
		case "figures":
			s.balanced = w.word() == "balanced"
			s.ambient = w.number()
			s.opaqueOnly = w.word() == "opaque_only"
			s.path = w.word() == "path"
		case "background":
			s.background = w.vector()
		case "light":
			s.lights, s.brightness = append(s.lights, w.vector()), append(s.brightness, w.vector())
		case "object":
			o := &Object{color: w.vector(), r: w.number(), t: w.number(), n: w.number(), center: w.vector()}
			k, degrees := w.vector().Unit(), w.number()
			o.sign, o.kind = w.number(), w.word()
			for len(w) > 0 {
				o.p = append(o.p, w.number())
			}
			sin, cos := math.Sincos(degrees * math.Pi / 180)
			if math.Mod(degrees, 90) == 0 {
				sin, cos = math.Round(sin), math.Round(cos)
			}
			for j, v := range [3]V{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}} {
				o.axes[j] = v.Mul(cos).Add(k.Cross(v).Mul(sin)).Add(k.Mul(k.Dot(v) * (1 - cos)))
			}
			s.objects = append(s.objects, o)
		case "shadowless":
			s.objects[w.count()].shadowless = true
		case "misprint":
			s.printed = true
		case "ray":
			s.rays = append(s.rays, Ray{o: w.vector(), d: w.vector()})
		default:
			panic("unknown line " + key)
		}
	}
	return s
}

// A ray without a parent: its sides are those of its origin.
func (s *Scene) begin(o, d V) Ray {
	sides := make([]bool, len(s.objects))
	for k, object := range s.objects {
		sides[k] = object.inside(o)
	}
	return Ray{o, d, sides, s.maxDistance}
}

// --- tracing ---------------------------------------------------------------------------------------------------------------

type Hit struct {
	t      float64
	index  int
	used   float64 // of the ray's range: whole steps
	normal V
}

func (s *Scene) firstHit(ray Ray) Hit {
	hit := Hit{t: math.Inf(1), index: -1}
	if !(ray.left > 0) || !finite(ray.d.Dot(ray.d)) {
		return hit
	}
	for step := 1; hit.index < 0; step++ {
		t := math.Min(float64(step)*s.h, ray.left)
		for k, object := range s.objects {
			if object.inside(ray.o.Add(ray.d.Mul(t))) != ray.sides[k] {
				if root := s.newton(object, ray, (float64(step-1)*s.h+t)/2); root < hit.t {
					hit.t, hit.index, hit.used = root, k, t
				}
			}
		}
		if t == ray.left {
			break
		}
	}
	if hit.index >= 0 {
		hit.normal = s.objects[hit.index].gradient(ray.o.Add(ray.d.Mul(hit.t)), true).Unit()
		if ray.d.Dot(hit.normal) > 0 {
			hit.normal = hit.normal.Mul(-1)
		}
	}
	return hit
}

func (s *Scene) newton(object *Object, ray Ray, t float64) float64 {
	for i := 0; i < s.maxIterations; i++ {
		point := ray.o.Add(ray.d.Mul(t))
		dt := object.f(point) / object.gradient(point, false).Dot(ray.d)
		if !finite(dt) {
			break
		}
		t -= dt
		if math.Abs(dt) <= s.tolerance*math.Max(1, math.Abs(t)) {
			break
		}
	}
	return t
}

func (s *Scene) intensity(point, direction V, distance float64, sides []bool) float64 {
	now, intensity := append([]bool(nil), sides...), 1.0
	for step := 1; ; step++ {
		t := math.Min(float64(step)*s.h, distance)
		for k, object := range s.objects {
			if object.shadowless || (s.opaqueOnly && object.t > 0) {
				continue
			}
			if inside := object.inside(point.Add(direction.Mul(t))); inside != now[k] {
				now[k] = inside
				intensity *= object.t
			}
		}
		if t == distance || intensity == 0 {
			return intensity
		}
	}
}

func (s *Scene) trace(ray Ray, generation int) V {
	if generation > s.maxDepth {
		return s.background
	}
	return s.shade(ray, s.firstHit(ray), generation)
}

func (s *Scene) shade(ray Ray, hit Hit, generation int) V {
	if hit.index < 0 {
		return s.background
	}
	object, normal, d := s.objects[hit.index], hit.normal, ray.d
	point := ray.o.Add(d.Mul(hit.t))
	cos1 := math.Min(-d.Dot(normal), 1)
	left := s.maxDistance
	if s.path {
		if left = ray.left - hit.used; left < 1e-12*s.maxDistance {
			left = 0
		}
	}

	illumination := grey(s.ambient)
	for j, light := range s.lights {
		way := light.Sub(point)
		distance := way.Len()
		direction := way.Mul(1 / distance)
		c := direction.Dot(normal)
		if !(c > 0) {
			continue
		}
		more := s.brightness[j].Mul(c * s.intensity(point, direction, distance, ray.sides))
		if s.balanced {
			illumination = grey(1).Sub(grey(1).Sub(illumination).Times(grey(1).Sub(more)))
		} else {
			illumination = illumination.Add(more)
		}
	}
	visible := object.color.Times(illumination)

	reflection := Ray{point, d.Add(normal.Mul(2 * cos1)).Unit(), ray.sides, left}
	var reflected, refracted V
	if object.r > 0 {
		reflected = s.trace(reflection, generation+1)
	}
	if object.t > 0 {
		n1, n2 := 1.0, object.n
		if ray.sides[hit.index] {
			n1, n2 = object.n, 1.0
		}
		sin1 := math.Sqrt(math.Max(1-cos1*cos1, 0))
		if sin1 > n2/n1 {
			refracted = reflected
			if !(object.r > 0) {
				refracted = s.trace(reflection, generation+1)
			}
		} else {
			sin2 := sin1 * n1 / n2
			cos2 := math.Sqrt(math.Max(1-sin2*sin2, 0))
			if s.printed {
				sin2 = sin1 * n2 / n1
				cos2 = math.Sqrt(1 - sin2*sin2)
			}
			sides := append([]bool(nil), ray.sides...)
			sides[hit.index] = !sides[hit.index]
			direction := d.Add(normal.Mul(cos1)).Mul(n1 / n2).Sub(normal.Mul(cos2)).Unit()
			refracted = s.trace(Ray{point, direction, sides, left}, generation+1)
		}
	}
	own := visible.Mul(1 - object.r).Add(reflected.Mul(object.r))
	return own.Mul(1 - object.t).Add(refracted.Mul(object.t))
}

func (s *Scene) cameraRay(row, col, i, j, n int) V {
	vdir := s.direction.Unit()
	vx := s.up.Cross(vdir).Unit()
	vy := vdir.Cross(vx)
	if s.hasAxes {
		vx, vy = s.vx.Unit(), s.vy.Unit()
	}
	ratio := 2 * math.Tan(math.Pi*s.fov/360) / math.Max(float64(s.width), float64(s.height))
	x := ratio * (float64(col) + (float64(j)+0.5)/float64(n) - float64(s.width)/2)
	y := ratio * (-(float64(row) + (float64(i)+0.5)/float64(n)) + float64(s.height)/2)
	return vx.Mul(x).Add(vy.Mul(y)).Add(vdir).Unit()
}

// --- the protocol ----------------------------------------------------------------------------------------------------------

type Array struct {
	Name  string `json:"name"`
	Dtype string `json:"dtype"`
	Shape []int  `json:"shape"`
}

func answer(s *Scene) ([]Array, []byte) {
	var color, normal []V
	var t []float64
	var index []int32
	take := func(c V, hit Hit) {
		color, normal = append(color, c), append(normal, hit.normal)
		t, index = append(t, hit.t), append(index, int32(hit.index))
	}
	shape := []int{len(s.rays)}
	for _, given := range s.rays {
		ray := s.begin(given.o, given.d)
		hit := s.firstHit(ray)
		take(s.shade(ray, hit, 0), hit)
	}
	if len(s.rays) == 0 {
		shape = []int{s.height, s.width}
		ray, n := s.begin(s.position, V{}), s.samples
		for row := 0; row < s.height; row++ {
			for col := 0; col < s.width; col++ {
				var sum V
				for k := 0; k < n*n; k++ {
					ray.d = s.cameraRay(row, col, k/n, k%n, n)
					sum = sum.Add(s.trace(ray, 0))
				}
				ray.d = s.cameraRay(row, col, 0, 0, 1)
				take(sum.Mul(1/float64(n*n)), s.firstHit(ray))
			}
		}
	}
	var body bytes.Buffer
	for _, values := range []any{color, index, t, normal} {
		binary.Write(&body, binary.LittleEndian, values)
	}
	vector := append(append([]int(nil), shape...), 3)
	return []Array{{"color", "float64", vector}, {"index", "int32", shape}, {"t", "float64", shape},
		{"normal", "float64", vector}}, body.Bytes()
}

func main() {
	in, out := bufio.NewReader(os.Stdin), bufio.NewWriter(os.Stdout)
	for {
		line, err := in.ReadBytes('\n')
		if err != nil {
			return
		}
		var request struct {
			Seq, Bytes int
			Op         string
		}
		if err := json.Unmarshal(line, &request); err != nil {
			panic(err)
		}
		if request.Op == "hello" {
			fmt.Fprintln(out, `{"protocol": 1, "name": "raytruth Go example", "levels": ["algorithm"], "precision": 64, `+
				`"switches": ["E1", "F1", "F2", "F3", "F4", "F5"]}`)
		} else {
			text := make([]byte, request.Bytes)
			if _, err := io.ReadFull(in, text); err != nil {
				panic(err)
			}
			arrays, body := answer(readScene(string(text)))
			head, _ := json.Marshal(map[string]any{"seq": request.Seq, "state": "ok", "bytes": len(body), "arrays": arrays})
			out.Write(append(head, '\n'))
			out.Write(body)
		}
		out.Flush()
	}
}
