"""What Mitsuba has no stock plugin for: the document's light without fall-off, and its material.

Both follow Mitsuba's own conventions, so that its stock integrators do the transport. The document's illumination
cos(phi) * brightness is a radiance of color / pi * cos(phi) * E at an irradiance of E = pi * brightness.
"""

from __future__ import annotations

from .variant import dr, mi


class SteadyPoint(mi.Emitter):
    """"steady_point": a point light that does not fade with distance (decision L1).

    Parameters: `position`, and `brightness` as an RGB colour.
    """

    def __init__(self, properties):
        super().__init__(properties)
        self.position = mi.Point3f(properties["position"])
        self.irradiance = mi.Color3f(properties["brightness"]) * dr.pi
        self.m_flags = mi.EmitterFlags.DeltaPosition
        dr.make_opaque(self.position, self.irradiance)

    def sample_direction(self, it, sample, active=True):
        ds = dr.zeros(mi.DirectionSample3f)
        ds.p, ds.time, ds.emitter = self.position, it.time, mi.EmitterPtr(self)
        to_light = self.position - it.p
        ds.dist = dr.norm(to_light)
        ds.d = to_light / ds.dist
        ds.n = -ds.d
        ds.pdf, ds.delta = 1.0, True
        return ds, self.irradiance & active

    def pdf_direction(self, it, ds, active=True):
        return mi.Float(0)

    def eval_direction(self, it, ds, active=True):
        return self.irradiance & active

    def eval(self, si, active=True):
        return mi.Color3f(0)

    def bbox(self):
        return mi.ScalarBoundingBox3f()

    def to_string(self):
        return "SteadyPoint"


class DocumentMaterial(mi.BSDF):
    """"document": section 4.3.4 as a BSDF.

    Local colour is a diffuse lobe that is evaluated for lights and never sampled: the document's diffuse light makes no
    further rays. Reflection with weight R (1 - T) and refraction with weight T, without Fresnel's factors, are two
    mirrors' worth of delta lobes; total reflection keeps the weight T (decision R3). Shadow rays of integrators that
    know null transmission pass with T a crossing (decision L3).

    Parameters: `color` (RGB), `reflection`, `transparency`, `refractive_index`.
    """

    def __init__(self, properties):
        super().__init__(properties)
        self.color = mi.Color3f(properties["color"])
        self.reflection = mi.Float(properties.get("reflection", 0.0))
        self.transparency = mi.Float(properties.get("transparency", 0.0))
        self.refractive_index = mi.Float(properties.get("refractive_index", 1.0))
        dr.make_opaque(self.color, self.reflection, self.transparency, self.refractive_index)
        flags = mi.BSDFFlags
        both = flags.FrontSide | flags.BackSide
        self.m_components = [flags.DiffuseReflection | both, flags.DeltaReflection | both,
                             flags.DeltaTransmission | both | flags.NonSymmetric, flags.Null | both]
        self.m_flags = self.m_components[0]
        for component in self.m_components[1:]:
            self.m_flags |= component

    def sample(self, ctx, si, sample1, sample2, active=True):
        reflected, refracted = self.reflection * (1 - self.transparency), self.transparency
        total_weight = reflected + refracted
        reflects = sample1 * total_weight < reflected
        cos1 = si.wi.z
        ratio = dr.select(cos1 > 0, dr.rcp(self.refractive_index), self.refractive_index)  # n1 / n2
        sin2_squared = dr.square(ratio) * (1 - dr.square(cos1))
        mirrored = mi.Vector3f(-si.wi.x, -si.wi.y, cos1)
        bent = mi.Vector3f(-ratio * si.wi.x, -ratio * si.wi.y, -dr.copysign(dr.safe_sqrt(1 - sin2_squared), cos1))
        chosen = dr.zeros(mi.BSDFSample3f)
        chosen.wo = dr.select(reflects | (sin2_squared > 1), mirrored, bent)
        chosen.pdf = dr.select(reflects, reflected, refracted) / total_weight
        chosen.eta = 1.0  # of use to Russian roulette only
        chosen.sampled_component = dr.select(reflects, mi.UInt32(1), 2)
        chosen.sampled_type = dr.select(reflects, mi.UInt32(+mi.BSDFFlags.DeltaReflection),
                                        mi.UInt32(+mi.BSDFFlags.DeltaTransmission))
        return chosen, mi.Color3f(total_weight) & (active & (total_weight > 0))

    def eval(self, ctx, si, wo, active=True):
        local = self.color * (dr.inv_pi * dr.abs(wo.z) * (1 - self.reflection) * (1 - self.transparency))
        return local & (active & (si.wi.z * wo.z > 0))

    def pdf(self, ctx, si, wo, active=True):
        return mi.Float(0)

    def eval_pdf(self, ctx, si, wo, active=True):
        return self.eval(ctx, si, wo, active), mi.Float(0)

    def eval_null_transmission(self, si, active=True):
        return mi.Color3f(self.transparency) & active

    def to_string(self):
        return "DocumentMaterial"


mi.register_emitter("steady_point", SteadyPoint)
mi.register_bsdf("document", DocumentMaterial)
