"""Formulas as people write them, each in the notation of where it comes from, and what it means, written a second time in
NumPy by hand. `size` is half the side of the cube that is looked at.

Equations of surfaces are facts; the origins tell in which notation they were met.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy import abs, arcsin, arctan2, cos, exp, floor, log, sin, sqrt, tan, tanh

pi = np.pi


@dataclass(frozen=True)
class Written:
    origin: str
    formula: str
    size: float
    means: Callable
    parameters: dict[str, float] = field(default_factory=dict)
    has_faces: bool = False  # where the function jumps across zero: no gradient, so that those pixels are undecided


def _max(*values):
    return np.maximum.reduce(np.broadcast_arrays(*values))


def _min(*values):
    return np.minimum.reduce(np.broadcast_arrays(*values))


# Herwig Hauser's gallery, as printed: imaginary.org, and github.com/jaanga/jaanga.github.io, 2-Algesurf
HAUSER = [
    ("x² + y²z³ = z⁴", 1, lambda x, y, z: x**2 + y**2 * z**3 - z**4),
    ("x² + y²z = z²", 2, lambda x, y, z: x**2 + y**2 * z - z**2),
    ("x³y + xz³ + y³z + z³ + 7z² + 5z = 0", 2, lambda x, y, z: x**3 * y + x * z**3 + y**3 * z + z**3 + 7 * z**2 + 5 * z),
    ("x⁶ + y⁶ + z⁶ = 1", 1.2, lambda x, y, z: x**6 + y**6 + z**6 - 1),
    ("3x² + 3y² + z² = 1", 1.2, lambda x, y, z: 3 * x**2 + 3 * y**2 + z**2 - 1),
    ("(x² − y³)² = (z² − y²)³", 1, lambda x, y, z: (x**2 - y**3)**2 - (z**2 - y**2)**3),
    ("x² + y² + z³ = z²", 1.2, lambda x, y, z: x**2 + y**2 + z**3 - z**2),
    ("x² + y² + z² + 1000(x² + y²)(x² + z²)(y² + z²) = 1", 1,
     lambda x, y, z: x**2 + y**2 + z**2 + 1000 * (x**2 + y**2) * (x**2 + z**2) * (y**2 + z**2) - 1),
    ("x³y + xz³ + y³z + z³ + 5z = 0", 2, lambda x, y, z: x**3 * y + x * z**3 + y**3 * z + z**3 + 5 * z),
    ("(x² + y²)³ = 4x²y²(z² + 1)", 2, lambda x, y, z: (x**2 + y**2)**3 - 4 * x**2 * y**2 * (z**2 + 1)),
    ("5x² + 2xz² + 5y⁶ + 15y⁴ + 5z² = 15y⁵ + 5y³", 1.5,
     lambda x, y, z: 5 * x**2 + 2 * x * z**2 + 5 * y**6 + 15 * y**4 + 5 * z**2 - 15 * y**5 - 5 * y**3),
    ("x²yz + x²z² = y³z + y³", 1, lambda x, y, z: x**2 * y * z + x**2 * z**2 - y**3 * z - y**3),
    ("6x² − 2x⁴ = y²z²", 2, lambda x, y, z: 6 * x**2 - 2 * x**4 - y**2 * z**2),
    ("y² + z³ − z⁴ − x²z² = 0", 1.2, lambda x, y, z: y**2 + z**3 - z**4 - x**2 * z**2),
    ("x² − y²z² = 0", 1, lambda x, y, z: x**2 - y**2 * z**2),
    ("x²y²z² + 3x² + 3y² + z² = 1", 1.1, lambda x, y, z: x**2 * y**2 * z**2 + 3 * x**2 + 3 * y**2 + z**2 - 1),
    ("(x² + 9/4y² + z² − 1)³ − x²z³ − 9/80y²z³ = 0", 1.3,
     lambda x, y, z: (x**2 + 2.25 * y**2 + z**2 - 1)**3 - x**2 * z**3 - 0.1125 * y**2 * z**3),
    ("256z³ − 128x²z² + 16x⁴z + 144xy²z − 4x³y² − 27y⁴ = 0", 2,
     lambda x, y, z: 256 * z**3 - 128 * x**2 * z**2 + 16 * x**4 * z + 144 * x * y**2 * z - 4 * x**3 * y**2 - 27 * y**4),
    ("(y³ − x² − z²)³ = 27x²y³z²", 1.5, lambda x, y, z: (y**3 - x**2 - z**2)**3 - 27 * x**2 * y**3 * z**2),
    ("x³ z + x² + yz³ + z⁴ = 3xyz", 1, lambda x, y, z: x**3 * z + x**2 + y * z**3 + z**4 - 3 * x * y * z),
    ("x³ = y (1 − z²)²", 1.2, lambda x, y, z: x**3 - y * (1 - z**2)**2),
    (" − x² + y⁴ + z⁴ − xyz = 100", 4, lambda x, y, z: -x**2 + y**4 + z**4 - x * y * z - 100),
    ("x² + z² = y³(1 − y)³", 1, lambda x, y, z: x**2 + z**2 - y**3 * (1 - y)**3),
    ("xyz + yz + 2z⁵ = 0", 1.2, lambda x, y, z: x * y * z + y * z + 2 * z**5),
    ("x²y² + y²z² + x²z² + 100 ( x² + y² + z² − 1)³ = 0", 1.1,
     lambda x, y, z: x**2 * y**2 + y**2 * z**2 + x**2 * z**2 + 100 * (x**2 + y**2 + z**2 - 1)**3),
    ("(xy − z³ − 1)² + (x² + y² − 1)³ = 0", 1.4, lambda x, y, z: (x * y - z**3 - 1)**2 + (x**2 + y**2 - 1)**3),
    ("(x³ − 1)² + (y³ − 1)² + (z² − 1)³ = 0", 1.7, lambda x, y, z: (x**3 - 1)**2 + (y**3 - 1)**2 + (z**2 - 1)**3),
    ("(y² + z² − 1)² + (x² + y² − 1)³ = 0", 1.5, lambda x, y, z: (y**2 + z**2 - 1)**2 + (x**2 + y**2 - 1)**3),
    ("yz(x² + y − z) = 0", 1, lambda x, y, z: y * z * (x**2 + y - z)),
    ("xyz = 0", 1, lambda x, y, z: x * y * z)]

# Harry Chen's grapher: github.com/harry7557558/spirulae, implicit3
SPIRULAE = [
    ("(x^2+9/4*y^2+z^2-1)^3=(x^2+9/80*y^2)*z^3", 1.3,
     lambda x, y, z: (x**2 + 9 / 4 * y**2 + z**2 - 1)**3 - (x**2 + 9 / 80 * y**2) * z**3),
    ("2(x^2+2y^2+z^2)^3-2(9x^2+y^2)z^3=1", 1.6,
     lambda x, y, z: 2 * (x**2 + 2 * y**2 + z**2)**3 - 2 * (9 * x**2 + y**2) * z**3 - 1),
    ("4(x^2+2y^2+z^2-1)^2-z(5x^4-10x^2z^2+z^4)=1", 1.6,
     lambda x, y, z: 4 * (x**2 + 2 * y**2 + z**2 - 1)**2 - z * (5 * x**4 - 10 * x**2 * z**2 + z**4) - 1),
    ("2y(y^2-3x^2)(1-z^2)+(x^2+y^2)^2-(9z^2-1)(1-z^2)", 2,
     lambda x, y, z: 2 * y * (y**2 - 3 * x**2) * (1 - z**2) + (x**2 + y**2)**2 - (9 * z**2 - 1) * (1 - z**2)),
    ("2(x^4+y^4+z^4)-3(x^2+y^2+z^2)+2", 1.3, lambda x, y, z: 2 * (x**4 + y**4 + z**4) - 3 * (x**2 + y**2 + z**2) + 2),
    ("(x^2-1)^2+(y^2-1)^2+(z^2-1)^2+4(x^2y^2+x^2z^2+y^2z^2)+8xyz-2(x^2+y^2+z^2)", 1.6,
     lambda x, y, z: (x**2 - 1)**2 + (y**2 - 1)**2 + (z**2 - 1)**2
     + 4 * (x**2 * y**2 + x**2 * z**2 + y**2 * z**2) + 8 * x * y * z - 2 * (x**2 + y**2 + z**2)),
    ("(x^2+y^2+z^2-2)^3+2000(x^2y^2+x^2z^2+y^2z^2)=10", 2,
     lambda x, y, z: (x**2 + y**2 + z**2 - 2)**3 + 2000 * (x**2 * y**2 + x**2 * z**2 + y**2 * z**2) - 10),
    ("z^6-5(x^2+y^2)z^4+5(x^2+y^2)^2z^2-2(x^4-10x^2y^2+5y^4)xz-1.002(x^2+y^2+z^2)^3+0.2", 1,
     lambda x, y, z: z**6 - 5 * (x**2 + y**2) * z**4 + 5 * (x**2 + y**2)**2 * z**2
     - 2 * (x**4 - 10 * x**2 * y**2 + 5 * y**4) * x * z - 1.002 * (x**2 + y**2 + z**2)**3 + 0.2),
    ("4(x^2-y^2)(y^2-z^2)(z^2-x^2)-3(x^2+y^2+z^2-1)^2", 1.8,
     lambda x, y, z: 4 * (x**2 - y**2) * (y**2 - z**2) * (z**2 - x**2) - 3 * (x**2 + y**2 + z**2 - 1)**2),
    ("x^2+y^2=(1-z)z^2", 1.1, lambda x, y, z: x**2 + y**2 - (1 - z) * z**2),
    ("x^2+y^2z+z^2=0.01", 1, lambda x, y, z: x**2 + y**2 * z + z**2 - 0.01),
    ("x^2+4y^2+(1.15z-0.6(2(x^2+.05y^2+.001)^0.7+y^2)^0.3+0.3)^2=1", 1.4,
     lambda x, y, z: x**2 + 4 * y**2 + (1.15 * z - 0.6 * (2 * (x**2 + 0.05 * y**2 + 0.001)**0.7 + y**2)**0.3 + 0.3)**2 - 1),
    ("(sin(2x)sin(2y)sin(2z)-0.9)e^(x+y)", 1.5, lambda x, y, z: (sin(2 * x) * sin(2 * y) * sin(2 * z) - 0.9) * np.e**(x + y)),
    ("x^2+y^2+z^2=1+0.1sin(10x)sin(10y)sin(10z)", 1.1,
     lambda x, y, z: x**2 + y**2 + z**2 - (1 + 0.1 * sin(10 * x) * sin(10 * y) * sin(10 * z))),
    ("abs(x)+abs(y)+abs(z)-1+0.7cos(10x)cos(10y)cos(10z)", 1.4,
     lambda x, y, z: abs(x) + abs(y) + abs(z) - 1 + 0.7 * cos(10 * x) * cos(10 * y) * cos(10 * z)),
    ("z=0.25round(4sin(x)sin(y))", 1.5, lambda x, y, z: z - 0.25 * floor(4 * sin(x) * sin(y) + 0.5)),
    ("z=1/((tan(x)tan(y))^2+1)-1/2", 1.2, lambda x, y, z: z - (1 / ((tan(x) * tan(y))**2 + 1) - 1 / 2)),
    ("z=.2tan(asin(cos(5x)cos(5y)))+.5sin(10z)", 0.5,
     lambda x, y, z: z - (0.2 * tan(arcsin(cos(5 * x) * cos(5 * y))) + 0.5 * sin(10 * z))),
    ("z=100sin(x-sqrt(x^2+y^2))^8sin(y+sqrt(x^2+y^2)-z)^8/(x^2+y^2+50)", 2,
     lambda x, y, z: z - 100 * sin(x - sqrt(x**2 + y**2))**8 * sin(y + sqrt(x**2 + y**2) - z)**8 / (x**2 + y**2 + 50)),
    ("max(cos(atan(y,x)-20e^((z-1)/4)),x^2+y^2+z/2-1)", 1.2,
     lambda x, y, z: np.maximum(cos(arctan2(y, x) - 20 * exp((z - 1) / 4)), x**2 + y**2 + z / 2 - 1)),
    ("(x^2+y^2+z^2+0.9)^2-4(x^2+z^2)=0.1asin(0.9sin(5atan(z,x)+40y))", 1.4,
     lambda x, y, z: (x**2 + y**2 + z**2 + 0.9)**2 - 4 * (x**2 + z**2) - 0.1 * arcsin(0.9 * sin(5 * arctan2(z, x) + 40 * y))),
    ("a=atan2(z,x)+1.571;(x^2+z^2)^2+16y^2=2(x^2+z^2)(sin(2.5a)^2+0.5sin(10a)^2)", 1.8,
     lambda x, y, z: (x**2 + z**2)**2 + 16 * y**2 - 2 * (x**2 + z**2) * (
         sin(2.5 * (arctan2(z, x) + 1.571))**2 + 0.5 * sin(10 * (arctan2(z, x) + 1.571))**2)),
    ("lerp(max(|x|,|y|,|z|),sqrt(x^2+y^2+z^2),-1)-0.3", 0.8,
     lambda x, y, z: 2 * _max(abs(x), abs(y), abs(z)) - sqrt(x**2 + y**2 + z**2) - 0.3),
    ("n=3ln((x^2+z^2)/(|x|+0.01));sqrt(x^2+z^2)sin(n)^2=10y^2+x^2+0.5z^2-0.3z", 1.5,
     lambda x, y, z: sqrt(x**2 + z**2) * sin(3 * log((x**2 + z**2) / (abs(x) + 0.01)))**2
     - (10 * y**2 + x**2 + 0.5 * z**2 - 0.3 * z)),
    ("a=3(z+x+1);b=3(z-x+1);sin(min(a*sin(b),b*sin(a)))-cos(max(a*cos(b),b*cos(a)))=(3-2z)/9+((2x^2+z^2)/6)^3+100y^2", 1,
     lambda x, y, z: sin(_min(3 * (z + x + 1) * sin(3 * (z - x + 1)), 3 * (z - x + 1) * sin(3 * (z + x + 1))))
     - cos(_max(3 * (z + x + 1) * cos(3 * (z - x + 1)), 3 * (z - x + 1) * cos(3 * (z + x + 1))))
     - ((3 - 2 * z) / 9 + ((2 * x**2 + z**2) / 6)**3 + 100 * y**2)),
    ("k=0.14;r=1/k*ln(sqrt(x^2+y^2));10((k(xcos(r)+ysin(r))-0.5^2(x^2+y^2))^2+z^2)=x^2+y^2", 1,
     lambda x, y, z: 10 * ((0.14 * (x * cos(1 / 0.14 * log(sqrt(x**2 + y**2))) + y * sin(1 / 0.14 * log(sqrt(x**2 + y**2))))
                            - 0.25 * (x**2 + y**2))**2 + z**2) - (x**2 + y**2)),
    ("k=0.3;r=1/k*ln(sqrt(x^2+y^2));(k*(xcos(r)+ysin(r)))^2+z^2=0.1tanh(x^2+y^2+0.3)-0.01(x^2+y^2)", 1.5,
     lambda x, y, z: (0.3 * (x * cos(log(sqrt(x**2 + y**2)) / 0.3) + y * sin(log(sqrt(x**2 + y**2)) / 0.3)))**2 + z**2
     - (0.1 * tanh(x**2 + y**2 + 0.3) - 0.01 * (x**2 + y**2)))]

# POV-Ray's scenes/objects/isosurfaces.pov (Chris Huff), Mike Williams's isosurface tutorial, f-lohmueller.de
POVRAY = [
    ("sqrt(x*x + z*z) - 1", 1.2, lambda x, y, z: sqrt(x * x + z * z) - 1),
    ("y - sin(x*4*pi)*0.1", 1, lambda x, y, z: y - sin(x * 4 * pi) * 0.1),
    ("sqrt(x*x + y*y + z*z) - 0.9\n\t\t+ sin(12*atan2(x, z))*0.1", 1.1,
     lambda x, y, z: sqrt(x * x + y * y + z * z) - 0.9 + sin(12 * arctan2(x, z)) * 0.1),
    ("y - cos(sqrt(x*x + z*z)*4*pi)*0.1", 1, lambda x, y, z: y - cos(sqrt(x * x + z * z) * 4 * pi) * 0.1),
    ("sqrt(x*x + y*y + z*z) - 0.9\n\t\t+ sin(12*atan2(x, z))*sin(8*atan2(y, sqrt(x*x + z*z)))*0.1", 1.1,
     lambda x, y, z: sqrt(x * x + y * y + z * z) - 0.9 + sin(12 * arctan2(x, z)) * sin(8 * arctan2(y, sqrt(x * x + z * z))) * 0.1),
    ("sqrt(x*x + z*z) - abs(y)", 1, lambda x, y, z: sqrt(x * x + z * z) - abs(y)),
    ("y - (x*x + z*z)*0.5", 1, lambda x, y, z: y - (x * x + z * z) * 0.5),
    ("y - x*x + z*z", 1, lambda x, y, z: y - x * x + z * z),
    ("x*x + z*z - y*y - 0.25", 1, lambda x, y, z: x * x + z * z - y * y - 0.25),
    ("abs(x)-1+y*y", 1.5, lambda x, y, z: abs(x) - 1 + y * y),
    ("max( ( sqrt(x^2+z^2)-.5 ), ( abs(x)+abs(y)-.5 ) )", 1,
     lambda x, y, z: np.maximum(sqrt(x**2 + z**2) - 0.5, abs(x) + abs(y) - 0.5)),
    ("pow(x,2) + pow(y,2) + pow(z,2) - pow(0.8,2)", 1, lambda x, y, z: x**2 + y**2 + z**2 - 0.64),
    ("mod(floor(x*2)+floor(y*2)+floor(z*2),2)-0.5", 0.9,
     lambda x, y, z: np.mod(floor(x * 2) + floor(y * 2) + floor(z * 2), 2) - 0.5, {}, True)]

# MathMod's collection: github.com/parisolab/mathmod
MATHMOD = [
    (" cos(x) + cos(y) + cos(z)", 4, lambda x, y, z: cos(x) + cos(y) + cos(z)),
    ("(x^2 + y ^2 - x^2 *z + y ^2 *z + z ^2 -1)", 2, lambda x, y, z: x**2 + y**2 - x**2 * z + y**2 * z + z**2 - 1),
    ("-5*(x*x*y + x*x*z + y*y*x + y*y*z + z*z*y + z*z*x)   +2*(x*y + x*z + y*z)", 1,
     lambda x, y, z: -5 * (x * x * y + x * x * z + y * y * x + y * y * z + z * z * y + z * z * x) + 2 * (x * y + x * z + y * z)),
    ("  25*(x^3*(y+z)+y^3*(x+z)+z^3*(x+y))+50*(x^2*y^2+x^2*z^2+y^2*z^2)-125*(x^2*y*z+y^2*x*z+z^2*x*y)+60*x*y*z-4*(x*y+x*z+y*z)",
     1, lambda x, y, z: 25 * (x**3 * (y + z) + y**3 * (x + z) + z**3 * (x + y)) + 50 * (x**2 * y**2 + x**2 * z**2 + y**2 * z**2)
     - 125 * (x**2 * y * z + y**2 * x * z + z**2 * x * y) + 60 * x * y * z - 4 * (x * y + x * z + y * z)),
    ("phi=(1/2)*(1+sqrt(5))\nw=1.0\n4*(phi^2*x^2-y^2)*(phi^2*y^2-z^2)*(phi^2*z^2-x^2)-(1+2*phi)*(x^2+y^2+z^2-w^2)^2*w^2", 2,
     lambda x, y, z: 4 * (2.618033988749895 * x**2 - y**2) * (2.618033988749895 * y**2 - z**2) * (2.618033988749895 * z**2 - x**2)
     - (2 + sqrt(5)) * (x**2 + y**2 + z**2 - 1)**2),
    ("r = (1/4)*(1+3*sqrt(5))\na = -(8/5)*(1+1/(sqrt(5)))*sqrt(5-sqrt(5))\nc = (1/2)*sqrt(5-sqrt(5))\n"
     " a*(x-z)*(cos((2*pi)/5)*x-sin((2*pi)/5)*y-z) *(cos((4*pi)/5)*x-sin((4*pi)/5)*y-z) *(cos((6*pi)/5)*x-sin((6*pi)/5)*y-z) "
     "*(cos((8*pi)/5)*x-sin((8*pi)/5)*y-z)  + (1-c*z)*(x^2+y^2-1+r*z^2)^2", 2,
     lambda x, y, z: -1.6 * (1 + 1 / sqrt(5)) * sqrt(5 - sqrt(5)) * np.prod(
         [cos(2 * pi * k / 5) * x - sin(2 * pi * k / 5) * y - z for k in range(5)], axis=0)
     + (1 - sqrt(5 - sqrt(5)) / 2 * z) * (x**2 + y**2 - 1 + (1 + 3 * sqrt(5)) / 4 * z**2)**2),
    ("64*(x -w)*(x^4 - 4*w*x^3 -10*x^2*y^2 - 4*x^2*w^2 + 16*w^3*x - 20*w*x*y^2 + 5*y^4 + 16*w^4 - 20*y^2*w^2) "
     "-5*sqrt(5 - sqrt(5))*(2*z - sqrt(5 - sqrt(5))*w)*(4*(x^2 + y^2 - z^2) + (1 + 3*sqrt(5))*w^2)^2", 6,
     lambda x, y, z: 64 * (x - 1.3) * (x**4 - 5.2 * x**3 - 10 * x**2 * y**2 - 4 * x**2 * 1.69 + 16 * 2.197 * x - 26 * x * y**2
                                       + 5 * y**4 + 16 * 2.8561 - 20 * y**2 * 1.69)
     - 5 * sqrt(5 - sqrt(5)) * (2 * z - sqrt(5 - sqrt(5)) * 1.3) * (4 * (x**2 + y**2 - z**2) + (1 + 3 * sqrt(5)) * 1.69)**2,
     {"w": 1.3})]

# a web gallery of algebraic surfaces (Cayley Cubic to DecoCube), 3D-XplorMath's notation
GALLERY = [
    ("4 * (x*x + y*y + z*z) + 16 * x * y * z - 1", 1, lambda x, y, z: 4 * (x * x + y * y + z * z) + 16 * x * y * z - 1),
    ("81 * (x^3 + y^3 + z^3) - 189 * (x*x * (y + z) + y*y * (z + x) + z*z * (x + y)) + 54 * x*y*z "
     "+ 126 * (x*y + y*z + z*x) - 9 * (x*x + x + y*y + y + z*z + z) + 1", 1.5,
     lambda x, y, z: 81 * (x**3 + y**3 + z**3) - 189 * (x**2 * (y + z) + y**2 * (z + x) + z**2 * (x + y)) + 54 * x * y * z
     + 126 * (x * y + y * z + z * x) - 9 * (x**2 + x + y**2 + y + z**2 + z) + 1),
    ("(x*x + y*y + z*z - 1.69)^2 - 3.11 * ((1 - z)^2 - 2 * x*x) * ((1 + z)^2 - 2*y*y)", 2,
     lambda x, y, z: (x**2 + y**2 + z**2 - 1.69)**2 - 3.11 * ((1 - z)**2 - 2 * x**2) * ((1 + z)**2 - 2 * y**2)),
    ("(((1 - x*x) * x*x - y*y)^2 + z*z / 2) / (1 + x*x + y*y + z*z) - 0.02", 1.4,
     lambda x, y, z: (((1 - x**2) * x**2 - y**2)**2 + z**2 / 2) / (1 + x**2 + y**2 + z**2) - 0.02),
    ("((x*x + y*y / 4 - 1) * (x*x / 4 + y*y - 1))^2 + z*z / 2 - 0.08", 2.4,
     lambda x, y, z: ((x**2 + y**2 / 4 - 1) * (x**2 / 4 + y**2 - 1))**2 + z**2 / 2 - 0.08),
    ("((x*x + y*y - 1)^2 + (z - 1)^2) * ((x^2 + (z - 0.3)^2 - 1)^2 + y*y) - 0.1", 1.8,
     lambda x, y, z: ((x**2 + y**2 - 1)**2 + (z - 1)**2) * ((x**2 + (z - 0.3)**2 - 1)**2 + y**2) - 0.1),
    ("((x*x + y*y - 1)^2 + z*z) * ((y*y + z*z - 1)^2 + x*x) * ((z*z + x*x - 1)^2 + y*y) - 0.02", 1.4,
     lambda x, y, z: ((x**2 + y**2 - 1)**2 + z**2) * ((y**2 + z**2 - 1)**2 + x**2) * ((z**2 + x**2 - 1)**2 + y**2) - 0.02),
    ("((x*x + y*y - 0.64)^2 + (z*z - 1)^2) * ((y*y + z*z - 0.64)^2 + (x*x - 1)^2) * ((z*z + x*x - 0.64)^2 + (y*y - 1)^2) - 0.04",
     1.4, lambda x, y, z: ((x**2 + y**2 - 0.64)**2 + (z**2 - 1)**2) * ((y**2 + z**2 - 0.64)**2 + (x**2 - 1)**2)
     * ((z**2 + x**2 - 0.64)**2 + (y**2 - 1)**2) - 0.04),
    ("x^2+y^2+z^2+sin(4*x)-cos(4*y)+sin(4*z)-1", 2, lambda x, y, z: x**2 + y**2 + z**2 + sin(4 * x) - cos(4 * y) + sin(4 * z) - 1),
    ("-5*[x^2*(y+z)+y^2*(x+z)+z^2*(x+y)]+2*(x*y+x*z+y*z)", 1,
     lambda x, y, z: -5 * (x**2 * (y + z) + y**2 * (x + z) + z**2 * (x + y)) + 2 * (x * y + x * z + y * z)),
    ("cos(k*x*pi)*[cos(l*y*pi)*cos(m*z*pi)+s*cos(m*y*pi)*cos(l*z*pi)]+\ncos(l*x*pi)*[cos(k*y*pi)*cos(m*z*pi)+s*cos(m*y*pi)*"
     "cos(k*z*pi)]+\ncos(m*x*pi)*[cos(k*y*pi)*cos(l*z*pi)+s*cos(l*y*pi)*cos(k*z*pi)]", 1,
     lambda x, y, z: cos(x * pi) * (cos(2 * y * pi) * cos(z * pi) + cos(y * pi) * cos(2 * z * pi))
     + cos(2 * x * pi) * (2 * cos(y * pi) * cos(z * pi)) + cos(x * pi) * (cos(y * pi) * cos(2 * z * pi)
                                                                         + cos(2 * y * pi) * cos(z * pi)),
     {"k": 1, "l": 2, "m": 1, "s": 1})]

# GLSL as on Shadertoy and in libraries of distance functions (iquilezles.org), HLSL, OpenCL
GLSL = [
    ("abs(sin(p.x)*cos(p.y) + sin(p.y)*cos(p.z) + sin(p.z)*cos(p.x)) - .16", 3,
     lambda x, y, z: abs(sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x)) - 0.16),
    ("float q = length(p.x, p.z) - 1.;\nreturn length(q, p.y) - .35;", 1.5,
     lambda x, y, z: sqrt((sqrt(x**2 + z**2) - 1)**2 + y**2) - 0.35),
    ("length(max(abs(x) - .6, 0.), max(abs(y) - .4, 0.), max(abs(z) - .5, 0.)) - .15", 1,
     lambda x, y, z: sqrt(np.maximum(abs(x) - 0.6, 0)**2 + np.maximum(abs(y) - 0.4, 0)**2 + np.maximum(abs(z) - 0.5, 0)**2) - 0.15),
    ("float a = length(x - .5, y, z) - .6;\nfloat b = length(x + .5, y, z) - .6;\nsmin(a, b, .4)", 1.3,
     lambda x, y, z: _min(sqrt((x - 0.5)**2 + y**2 + z**2) - 0.6, sqrt((x + 0.5)**2 + y**2 + z**2) - 0.6) - np.maximum(
         0.4 - abs(sqrt((x - 0.5)**2 + y**2 + z**2) - sqrt((x + 0.5)**2 + y**2 + z**2)), 0)**2 / 1.6),
    ("let a = max(abs(x), abs(y), abs(z)) - .7\nlet b = length(x, y, z) - .85\n"
     "let h = clamp(0.5 + 0.5*(b - a)/.1, 0., 1.)\nmix(b, a, h) - .1*h*(1. - h)", 1, None),
    ("length(mod(x + .5, 1.) - .5, mod(y + .5, 1.) - .5, mod(z + .5, 1.) - .5) - .3", 1,
     lambda x, y, z: sqrt((np.mod(x + 0.5, 1) - 0.5)**2 + (np.mod(y + 0.5, 1) - 0.5)**2 + (np.mod(z + 0.5, 1) - 0.5)**2) - 0.3),
    ("max(length(x, z) - .4, abs(y) - .9)", 1, lambda x, y, z: np.maximum(sqrt(x**2 + z**2) - 0.4, abs(y) - 0.9)),
    ("fabs((sin(4*x) * cos(4*y) + sin(4*y) * cos(4*z) + sin(4*z) * cos(4*x) - .1) / 4) - (.1)", 1,
     lambda x, y, z: abs((sin(4 * x) * cos(4 * y) + sin(4 * y) * cos(4 * z) + sin(4 * z) * cos(4 * x) - 0.1) / 4) - 0.1),
    ("smoothstep(-.5, .5, z) + x*x + y*y - .6", 1,
     lambda x, y, z: np.clip(z + 0.5, 0, 1)**2 * (3 - 2 * np.clip(z + 0.5, 0, 1)) + x * x + y * y - 0.6),
    ("step(0., x)*.5 + x*x + y*y + z*z - .8", 1, lambda x, y, z: np.where(x >= 0, 0.5, 0) + x * x + y * y + z * z - 0.8,
     {}, True),
    ("fract(2.*z)*.3 + length(x, y) - .6", 1, lambda x, y, z: (2 * z - floor(2 * z)) * 0.3 + sqrt(x * x + y * y) - 0.6,
     {}, True),
    ("sign(z)*x + y - 0.1", 1, lambda x, y, z: np.sign(z) * x + y - 0.1)]

# Wikipedia, MathWorld and MathOverflow; MATLAB's and Mathematica's notation; GeoGebra and Desmos
REFERENCE = [
    ("cos(2πx)sin(2πy) − cos(2πy)sin(2πz) + cos(2πz)sin(2πx) = 0", 0.5,
     lambda x, y, z: cos(2 * pi * x) * sin(2 * pi * y) - cos(2 * pi * y) * sin(2 * pi * z) + cos(2 * pi * z) * sin(2 * pi * x)),
    ("sin x cos y + sin y cos z + sin z cos x = 0", 3.2, lambda x, y, z: sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x)),
    ("(1/2)[sin(2x) cos(y)sin(z) + sin(2y)cos(z) sin(x) + sin(2z)cos(x) sin(y)] "
     "- (1/2)[cos(2x)cos(2y) + cos(2y)cos(2z) + cos(2z)cos(2x)] + 0.15 = 0", 3,
     lambda x, y, z: 0.5 * (sin(2 * x) * cos(y) * sin(z) + sin(2 * y) * cos(z) * sin(x) + sin(2 * z) * cos(x) * sin(y))
     - 0.5 * (cos(2 * x) * cos(2 * y) + cos(2 * y) * cos(2 * z) + cos(2 * z) * cos(2 * x)) + 0.15),
    ("3(cos x + cos y + cos z) + 4 cos x cos y cos z = 0", 3,
     lambda x, y, z: 3 * (cos(x) + cos(y) + cos(z)) + 4 * cos(x) * cos(y) * cos(z)),
    ("sin x sin y sin z + sin x cos y cos z + cos x sin y cos z + cos x cos y sin z = 0", 3,
     lambda x, y, z: sin(x) * sin(y) * sin(z) + sin(x) * cos(y) * cos(z) + cos(x) * sin(y) * cos(z) + cos(x) * cos(y) * sin(z)),
    ("2(cos x cos y + cos y cos z + cos z cos x) - (cos 2x + cos 2y + cos 2z) = 0", 3,
     lambda x, y, z: 2 * (cos(x) * cos(y) + cos(y) * cos(z) + cos(z) * cos(x)) - (cos(2 * x) + cos(2 * y) + cos(2 * z))),
    ("(R - √(x² + y²))² + z² = r²", 1.5, lambda x, y, z: (1 - sqrt(x**2 + y**2))**2 + z**2 - 0.16, {"R": 1, "r": 0.4}),
    ("(x.^2 + y.^2 + z.^2 + R.^2 - r.^2).^2 - 4*R.^2.*(x.^2 + y.^2)", 1.5,
     lambda x, y, z: (x**2 + y**2 + z**2 + 1 - 1 / 9)**2 - 4 * (x**2 + y**2), {"R": 1, "r": 1 / 3}),
    ("(-x.^4 + x.^2 - y.^2).^2 + z.^2/2 - (x.^2 + y.^2 + z.^2 + 1)/40", 1.5,
     lambda x, y, z: (-x**4 + x**2 - y**2)**2 + z**2 / 2 - (x**2 + y**2 + z**2 + 1) / 40),
    ("sqrt((x - 1).^2 + y.^2 + z.^2).*sqrt((x + 1).^2 + y.^2 + z.^2).*sqrt((y - 1).^2 + x.^2 + z.^2).*"
     "sqrt((y + 1).^2 + x.^2 + z.^2) - 1.1", 1.6,
     lambda x, y, z: sqrt((x - 1)**2 + y**2 + z**2) * sqrt((x + 1)**2 + y**2 + z**2) * sqrt((y - 1)**2 + x**2 + z**2)
     * sqrt((y + 1)**2 + x**2 + z**2) - 1.1),
    ("Cos[x] Sin[y] + Cos[y] Sin[z] + Cos[z] Sin[x] == 0", 3, lambda x, y, z: cos(x) * sin(y) + cos(y) * sin(z) + cos(z) * sin(x)),
    ("x^2 + y^2 - z^2 == 0.25", 1, lambda x, y, z: x**2 + y**2 - z**2 - 0.25),
    ("Sqrt[x^2 + y^2] == 1 + Sin[5 ArcTan[x, y]]/4 - z^2/4" .replace("ArcTan[x, y]", "Atan2[y, x]"), 1.5,
     lambda x, y, z: sqrt(x**2 + y**2) - (1 + sin(5 * arctan2(y, x)) / 4 - z**2 / 4)),
    ("|x|^(2/e) + |y|^(2/e) + |z|^(2/n) = 1".replace("/e", "/a").replace("/n", "/b"), 1.1,
     lambda x, y, z: abs(x)**2.5 + abs(y)**2.5 + abs(z)**1.25 - 1, {"a": 0.8, "b": 1.6}),
    ("x²/a² + y²/b² − z²/c² = 1", 2, lambda x, y, z: x**2 + y**2 / 0.25 - z**2 / 2.25 - 1, {"a": 1, "b": 0.5, "c": 1.5}),
    ("z = cosh⁻¹".replace("z = cosh⁻¹", "x² + y² = cosh²(z)"), 1.5, lambda x, y, z: x**2 + y**2 - np.cosh(z)**2),
    ("sin z = sinh x sinh y", 1.5, lambda x, y, z: sin(z) - np.sinh(x) * np.sinh(y)),
    ("e^z cos x = cos y", 1.4, lambda x, y, z: exp(z) * cos(x) - cos(y)),
    ("y cos z = x sin z", 2, lambda x, y, z: y * cos(z) - x * sin(z)),
    ("f(x,y,z) = x^4 + y^4 + z^4 − (x^2 + y^2 + z^2) + 0.4", 1.2,
     lambda x, y, z: x**4 + y**4 + z**4 - (x**2 + y**2 + z**2) + 0.4),
    ("z = arctan(y/x)", 1.5, lambda x, y, z: z - np.arctan(y / x)),
    ("z = ln(x² + y²)", 1, lambda x, y, z: z - log(x**2 + y**2)),
    ("X^2 + Y^2 + Z^2 = 1", 1.1, lambda x, y, z: x**2 + y**2 + z**2 - 1)]

# solids: libfive's and ImplicitCAD's min and max, and RegionPlot3D's conditions
SOLIDS = [
    ("x^2 < 1 and y^2 < 0.25 and not (x^2 + y^2 + z^2 < 0.49) and |z| < 0.5", 1.2,
     lambda x, y, z: _max(x**2 - 1, y**2 - 0.25, -(x**2 + y**2 + z**2 - 0.49), abs(z) - 0.5)),
    ("x^2 + y^2 + z^2 < 1 && x + y + z > 0.2", 1.1, lambda x, y, z: _max(x**2 + y**2 + z**2 - 1, 0.2 - (x + y + z))),
    ("0 < z < 0.8 && x^2 + y^2 <= (1 - z)^2", 1.1, lambda x, y, z: _max(-z, z - 0.8, x**2 + y**2 - (1 - z)**2)),
    ("x^2 + y^2 < 0.1 || y^2 + z^2 < 0.1 || z^2 + x^2 < 0.1", 1,
     lambda x, y, z: _min(x**2 + y**2 - 0.1, y**2 + z**2 - 0.1, z**2 + x**2 - 0.1)),
    ("R = sqrt(x*x+y*y+z*z) - 1.1\nD1 = x-0.85\nD2 = -x-0.85\nD3 = y-0.85\nD4 = -y-0.85\nD5 = z-0.85\nD6 = -z-0.85\n"
     "M = max(max(D1,D2),max(max(D3,D4),max(D5,D6)))\nmax(M,-R)", 1,
     lambda x, y, z: _max(abs(x) - 0.85, abs(y) - 0.85, abs(z) - 0.85, -(sqrt(x * x + y * y + z * z) - 1.1))),
    ("max(max(-x, x - 0.9), max(-y, y - 0.6), z - 0.3, -z)", 1,
     lambda x, y, z: _max(-x, x - 0.9, -y, y - 0.6, z - 0.3, -z)),
    ("(x^2+y^2+z^2 ≤ 1) and not (x^2+y^2 ≤ 0.2 or x^2+z^2 ≤ 0.2)", 1.1,
     lambda x, y, z: np.maximum(x**2 + y**2 + z**2 - 1, -_min(x**2 + y**2 - 0.2, x**2 + z**2 - 0.2)))]

# what has no meaning here, or several: refused, with what the message has to name
REFUSED = [
    ("spirulae", "m=max(|x|,|y|,|z|);k=3/2-m;n=ceil(log(2,k))-2;(3*2^n-k)^2+(x^2+y^2+z^2-m^2)=4^n", "log 2 argument"),
    ("spirulae", "z=if(sin(2x),1/5sin(2y),1/2cos(2y))", "unknown function 'if'"),
    ("POV-Ray", "sqrt(x*x + z*z) - 1\n\t\t+ f_noise3d(x*3, y*3, z*3)*0.25", "unknown function 'f_noise3d'"),
    ("GLSL", "dot(sin(p), cos(p.yzx))", "line 1, column 1")]


def _smooth_union(x, y, z):
    a, b = _max(abs(x), abs(y), abs(z)) - 0.7, sqrt(x**2 + y**2 + z**2) - 0.85
    h = np.clip(0.5 + 5 * (b - a), 0, 1)
    return b + (a - b) * h - 0.1 * h * (1 - h)


ORIGINS = {"Hauser": HAUSER, "spirulae": SPIRULAE, "POV-Ray": POVRAY, "MathMod": MATHMOD, "gallery": GALLERY, "GLSL": GLSL,
           "reference": REFERENCE, "solids": SOLIDS}
FORMULAS = [Written(origin, text, size, means or _smooth_union, *more)
            for origin, entries in ORIGINS.items() for text, size, means, *more in entries]
