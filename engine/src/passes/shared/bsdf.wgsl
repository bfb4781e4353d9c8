// The BSDF of glTF 2.0 (appendix B) with the extensions for specular, ior, transmission, volume, diffuse transmission,
// sheen, clearcoat, anisotropy and iridescence. From the top: a coat, sheen, and a mixture of metal and dielectric; the
// dielectric is a GGX layer over a Lambert base or over the inside of a transparent body.
//
// Directions are in the local frame of the shading normal: z is the cosine, x the direction of anisotropy. `wo` is
// above; `wi` may be below, where light is transmitted.
//!include shared/microfacet.wgsl
//!include shared/abilities.wgsl

// Whether the light that single scattering between microfacets loses is given back (Turquin, "Practical Multiple
// Scattering Compensation for Microfacet Models", 2019). Off for comparisons with renderers that don't.
override energy_compensation: bool = true;

struct Bsdf {
    base_color: vec3f,
    metallic: f32,
    alpha: vec2f, // GGX widths along x and y
    dielectric_f0: vec3f,
    specular: f32, // weight of the dielectric's reflection
    transmission: f32, // share of the body that is transparent
    // Index of refraction below over that above. 1: a thin wall that doesn't refract. 0: the same, but what goes straight
    // through it has been dealt with apart.
    eta: f32,
    diffuse_transmission: f32, // share of the rest that scatters to the other side
    diffuse_transmission_color: vec3f,
    coat: f32,
    coat_alpha: f32,
    coat_normal: vec3f,
    sheen_color: vec3f,
    sheen_roughness: f32,
    iridescent_f0: vec3f, // what a thin film makes of the normal reflection
    iridescence: f32, // its weight
}

struct BsdfSample {
    wi: vec3f,
    weight: vec3f, // f |cos| / pdf; zero: no sample
    pdf: f32,
}

fn plain_bsdf(base_color: vec3f, metallic: f32, roughness: f32, dielectric_f0: vec3f, specular: f32) -> Bsdf {
    let r = saturate(roughness);
    var b: Bsdf;
    b.base_color = clamp(base_color, vec3f(0.0), vec3f(1.0));
    b.metallic = saturate(metallic);
    b.alpha = vec2f(max(r * r, MIN_ALPHA));
    b.dielectric_f0 = dielectric_f0;
    b.specular = saturate(specular);
    b.eta = 1.0;
    b.coat_alpha = MIN_ALPHA;
    b.coat_normal = vec3f(0.0, 0.0, 1.0);
    return b;
}

// KHR_materials_anisotropy: the width along x grows with the strength.
fn anisotropic_alpha(roughness: f32, strength: f32) -> vec2f {
    let r = saturate(roughness);
    let a = max(r * r, MIN_ALPHA);
    return vec2f(mix(a, 1.0, strength * strength), a);
}

// What is known once the viewer's direction is: shares of the layers, and the probabilities of sampling them.
struct Lobes {
    cover: f32, // share of light that the coat reflects
    sheen: f32, // albedo of the sheen towards the viewer
    // Factors for what multiple scattering gives back: on the reflection of the dielectric's skin, on that of the metal, of the coat, and
    // on what transparent bodies reflect and let through.
    gloss: vec3f,
    metal_gloss: vec3f,
    coat_gloss: f32,
    through: f32,
    body: vec3f, // factor on the light below the dielectric's reflection
    table: vec2f, // what single scattering reflects, of F0 and beside it
    coat_p: f32,
    sheen_p: f32,
    specular_p: f32,
    diffuse_p: f32,
    back_p: f32, // diffuse transmission
    through_p: f32, // transmission; at the surface of a transparent body what it reflects, too
    mirror: f32, // of that the share that is reflected, by the angle alone
}

// Whether it is the surface of a transparent body, which refracts: its microfacets share what they reflect and let through.
fn is_refracting(b: Bsdf) -> bool {
    return has_transmission && b.transmission > 0.0 && b.eta > 0.0 && b.eta != 1.0;
}

// Of the rays that meet a microfacet of a transparent body those that are reflected, where it reflects `fresnel` of the light.
fn mirror_share(b: Bsdf, fresnel: vec3f) -> f32 {
    let reflected = dot(fresnel, vec3f(1.0 / 3.0));
    return reflected / max(reflected + (1.0 - reflected) * max_component(b.base_color), 1e-6);
}

fn mean_alpha(b: Bsdf) -> f32 {
    return sqrt(b.alpha.x * b.alpha.y);
}

// Whether the widths differ.
fn is_stretched(b: Bsdf) -> bool {
    return has_layers && b.alpha.x != b.alpha.y;
}

// How far apart the widths are: 0 to 1.
fn stretch2(b: Bsdf) -> f32 {
    let apart = (b.alpha.x - b.alpha.y) / (b.alpha.x + b.alpha.y);
    return apart * apart;
}

// At which cosine and roughness isotropic surfaces lose as much light between their microfacets. Of widths that differ it is about their
// root mean square, from where a surface is stretched in the viewer's plane as this one is: within 0.05 by integration, 0.09 at
// grazing angles.
fn table_place(b: Bsdf, wo: vec3f) -> vec2f {
    if (!is_stretched(b)) {
        return vec2f(wo.z, sqrt(mean_alpha(b)));
    }
    let squares = b.alpha * b.alpha;
    let mean = 0.5 * (squares.x + squares.y);
    let tangent2 = dot(wo.xy * wo.xy, squares) / (mean * wo.z * wo.z);
    let alpha = sqrt(mean) * (1.0 - 0.1 * stretch2(b) * sqrt(mean));
    return vec2f(inverseSqrt(1.0 + tangent2), sqrt(alpha));
}

// What single scattering reflects, of F0 and beside it; `place` is `table_place(b, wo)`.
fn single_scattering(b: Bsdf, wo: vec3f, place: vec2f) -> vec2f {
    let table = albedo_lookup(place.x, place.y).xy;
    if (!is_stretched(b)) {
        return table;
    }
    // Of Fresnel's reflection the angle counts, and how wide the normals are spread in its plane.
    let sine2 = max(1.0 - wo.z * wo.z, 1e-6);
    let alpha = sqrt(dot(wo.xy * wo.xy, b.alpha * b.alpha) / sine2);
    let seen = albedo_lookup(wo.z, sqrt(alpha)).xy;
    // By integration as near as that comes: at most 0.02 too bright, 0.09 too dark at grazing angles.
    let more = stretch2(b) * (0.005 + 0.15 * min(b.alpha.x, b.alpha.y));
    let single = min((table.x + table.y) * (1.0 + more), 1.0);
    return seen * (single / max(seen.x + seen.y, 1e-3));
}

// The reflection of the dielectric's skin over a body that scatters, at an angle to a microfacet: the same from both sides.
fn skin_fresnel(b: Bsdf, cosine: f32) -> vec3f {
    return skin_reflection(b, schlick_weight(cosine));
}

fn skin_reflection(b: Bsdf, grazing: f32) -> vec3f {
    let f0 = b.specular * b.dielectric_f0;
    return with_film(b, min(f0 + (b.specular - f0) * grazing, vec3f(1.0)));
}

// That of what is transparent; `cosine` is on wo's side.
fn dielectric_fresnel(b: Bsdf, cosine: f32) -> vec3f {
    var outside = cosine;
    if (has_transmission && b.eta < 1.0 && b.eta > 0.0) {
        // Seen from the inside: what counts is the angle in the air, and beyond the critical one all is reflected.
        let sine2 = (1.0 - cosine * cosine) / (b.eta * b.eta);
        if (sine2 >= 1.0) {
            return vec3f(1.0);
        }
        outside = sqrt(1.0 - sine2);
    }
    var grazing = schlick_weight(outside);
    if (has_transmission && b.eta != 1.0) {
        // Schlick's is the reflection of bodies in air. Between bodies that are nearly alike it fades with their difference, as Fresnel's does: from
        // a ratio of 1.33 down, in proportion to the root of F0. No index, 0, is far from alike; and 1 is no ratio, but a thin wall in air,
        // whatever its glass (or a border between equals, which has nothing to reflect).
        grazing *= min(7.07 * abs(b.eta - 1.0) / (b.eta + 1.0), 1.0);
    }
    return skin_reflection(b, grazing);
}

// A reflection under the thin film.
fn with_film(b: Bsdf, fresnel: vec3f) -> vec3f {
    if (has_layers && b.iridescence > 0.0) {
        return mix(fresnel, b.iridescent_f0, b.iridescence);
    }
    return fresnel;
}

// What a dielectric with this Fresnel reflection reflects on the whole, by single scattering; the film's doesn't depend on the angle.
fn with_film_over(b: Bsdf, reflected: vec3f, table: vec2f) -> vec3f {
    if (has_layers && b.iridescence > 0.0) {
        return mix(reflected, b.iridescent_f0 * (table.x + table.y), b.iridescence);
    }
    return reflected;
}

fn metal_fresnel(b: Bsdf, cosine: f32) -> vec3f {
    return with_film(b, schlick(b.base_color, cosine));
}

// The coat's reflection: KHR_materials_clearcoat takes it at the normal, with an index of 1.5.
fn coat_fresnel(b: Bsdf, w: vec3f) -> f32 {
    if (!has_layers || b.coat <= 0.0) {
        return 0.0;
    }
    return b.coat * (0.04 + 0.96 * schlick_weight(abs(dot(w, b.coat_normal))));
}

fn lobes(b: Bsdf, wo: vec3f) -> Lobes {
    var l: Lobes;
    l.cover = coat_fresnel(b, wo);
    l.gloss = vec3f(1.0);
    l.metal_gloss = vec3f(1.0);
    l.coat_gloss = 1.0;
    l.through = 1.0;
    l.body = vec3f(1.0);
    let place = table_place(b, wo);
    if (energy_compensation) {
        l.table = single_scattering(b, wo, place);
        let single = max(l.table.x + l.table.y, 1e-3);
        let lost = (1.0 - single) / single;
        l.gloss = vec3f(1.0) + with_film(b, b.specular * b.dielectric_f0) * lost;
        l.metal_gloss = vec3f(1.0) + with_film(b, b.base_color) * lost;
        if (has_transmission) {
            // What a thin transparent wall doesn't reflect isn't absorbed: it meets the next microfacet.
            l.through = 1.0 + lost;
            if (is_refracting(b)) {
                // The same at the surface of a body, where what single scattering leaves depends on the index too.
                l.through = 1.0 / max(glass_albedo(place.x, place.y, b.eta), 0.1);
                // The place is a metal's. By furnaces of balls, plates and cubes, glass that is rough along one way and much less so across
                // makes up to 0.04 of light there, where the one width is near 1 and the ratio of the indices about 1.5; half of it at 1.2
                // and 2.4, else none.
                let wide = max(b.alpha.x, b.alpha.y);
                let ratio = max(b.eta, 1.0 / b.eta);
                let excess = saturate(2.5 * (ratio - 1.0)) * saturate((3.0 - ratio) / 1.2);
                l.through /= 1.0 + 0.025 * sqrt(stretch2(b)) * wide * wide * wide * excess;
            }
        }
        if (has_layers && l.cover > 0.0) {
            let coat = albedo_lookup(abs(dot(wo, b.coat_normal)), sqrt(b.coat_alpha));
            l.coat_gloss = 1.0 / max(coat.x + coat.y, 1e-3);
        }
        // Below the reflection remains what isn't reflected, whatever the angle at a microfacet.
        let reflected = with_film_over(b, b.specular * (b.dielectric_f0 * l.table.x + l.table.y), l.table);
        l.body = vec3f(1.0) - min(reflected * l.gloss, vec3f(1.0));
    }
    if (!energy_compensation) {
        l.table = rough_albedo_estimate(wo.z, sqrt(mean_alpha(b)));
    }
    if (has_layers && max_component(b.sheen_color) > 0.0) {
        l.sheen = albedo_lookup(wo.z, b.sheen_roughness).z;
    }

    // Of the reflection as a whole. Where light goes through a thin wall, smooth ones are what matters, and the angle alone counts.
    let skin = with_film_over(b, b.specular * (b.dielectric_f0 * l.table.x + l.table.y), l.table);
    var glass = skin;
    if (has_transmission && b.transmission > 0.0) {
        glass = dielectric_fresnel(b, wo.z);
    }
    let refracts = is_refracting(b);
    let dielectric = mix(skin, select(glass, vec3f(0.0), refracts), b.transmission);
    let metal = with_film_over(b, b.base_color * l.table.x + l.table.y, l.table);
    let below = below_layers(b, l);
    let inside = below * (1.0 - b.metallic);
    l.coat_p = l.cover;
    l.sheen_p = (1.0 - l.cover) * max_component(b.sheen_color) * l.sheen;
    l.specular_p = below * max_component(mix(dielectric, metal, b.metallic));
    let diffuse = inside * (1.0 - max_component(skin)) * (1.0 - b.transmission);
    l.diffuse_p = diffuse * (1.0 - b.diffuse_transmission) * max_component(b.base_color);
    l.back_p = diffuse * b.diffuse_transmission * max_component(b.diffuse_transmission_color);
    if (refracts) {
        let reflected = dot(glass, vec3f(1.0 / 3.0));
        let passing = (1.0 - reflected) * max_component(b.base_color);
        l.through_p = inside * b.transmission * (reflected + passing);
        l.mirror = mirror_share(b, glass);
    } else if (b.eta > 0.0) {
        l.through_p = inside * (1.0 - max_component(glass)) * b.transmission * max_component(b.base_color);
    }
    let sum = l.coat_p + l.sheen_p + l.specular_p + l.diffuse_p + l.back_p + l.through_p;
    if (sum > 0.0) {
        // No lobe that matters may starve: what looks dark from here may be bright elsewhere.
        let least = 0.05 * sum;
        l.coat_p = raised(l.coat_p, least);
        l.sheen_p = raised(l.sheen_p, least);
        l.specular_p = raised(l.specular_p, least);
        l.diffuse_p = raised(l.diffuse_p, least);
        l.back_p = raised(l.back_p, least);
        l.through_p = raised(l.through_p, least);
        let scale = 1.0 / (l.coat_p + l.sheen_p + l.specular_p + l.diffuse_p + l.back_p + l.through_p);
        l.coat_p *= scale;
        l.sheen_p *= scale;
        l.specular_p *= scale;
        l.diffuse_p *= scale;
        l.back_p *= scale;
        l.through_p *= scale;
    }
    return l;
}

fn raised(p: f32, least: f32) -> f32 {
    return select(0.0, max(p, least), p > 0.0);
}

// The frame of the coat's normal: a vector of the local frame in it.
fn to_coat(b: Bsdf, w: vec3f) -> vec3f {
    let x = any_perpendicular(b.coat_normal);
    return vec3f(dot(w, x), dot(w, cross(b.coat_normal, x)), dot(w, b.coat_normal));
}

fn from_coat(b: Bsdf, w: vec3f) -> vec3f {
    let x = any_perpendicular(b.coat_normal);
    return x * w.x + cross(b.coat_normal, x) * w.y + b.coat_normal * w.z;
}

// f |cos| and the pdf of sampling wi. `l` is `lobes(b, wo)`.
fn bsdf_eval(b: Bsdf, l: Lobes, wo: vec3f, wi: vec3f) -> vec4f {
    if (wo.z <= 0.0) {
        return vec4f(0.0);
    }
    if (wi.z > 0.0) {
        return eval_above(b, l, wo, wi);
    }
    if (has_transmission && wi.z < 0.0 && l.back_p + l.through_p > 0.0) {
        return eval_below(b, l, wo, wi);
    }
    return vec4f(0.0);
}

fn eval_above(b: Bsdf, l: Lobes, wo: vec3f, wi: vec3f) -> vec4f {
    let h = normalize(wo + wi);
    let cosine = dot(wo, h);
    let skin = skin_fresnel(b, cosine);
    var f = vec3f(0.0);
    var pdf = 0.0;
    let refracts = is_refracting(b) && l.through_p > 0.0;
    if (l.specular_p > 0.0 || refracts) {
        var dielectric = skin * l.gloss;
        if (has_transmission && b.transmission > 0.0) {
            let glass = dielectric_fresnel(b, cosine);
            dielectric = mix(dielectric, glass * l.through, b.transmission);
            if (refracts) {
                pdf += l.through_p * mirror_share(b, glass) * ggx_normal_pdf(wo, h, b.alpha) / (4.0 * cosine);
            }
        }
        f += mix(dielectric, metal_fresnel(b, cosine) * l.metal_gloss, b.metallic) * ggx_reflection(wo, wi, h, b.alpha);
        pdf += l.specular_p * ggx_reflection_pdf(wo, h, b.alpha);
    }
    if (l.diffuse_p > 0.0) {
        f += diffuse_above(b, l, skin);
        pdf += l.diffuse_p * wi.z / PI;
    }
    if (has_layers && l.sheen_p > 0.0) {
        f = f * below_sheen(b, l, wi) + sheen_above(b, wo, wi);
        pdf += l.sheen_p / (2.0 * PI);
    }
    f *= (1.0 - l.cover) * wi.z;
    if (has_layers && l.coat_p > 0.0) {
        let o = to_coat(b, wo);
        let i = to_coat(b, wi);
        if (o.z > 0.0 && i.z > 0.0) {
            let n = normalize(o + i);
            let alpha = vec2f(b.coat_alpha);
            f += l.cover * l.coat_gloss * ggx_reflection(o, i, n, alpha) * i.z;
            pdf += l.coat_p * ggx_reflection_pdf(o, n, alpha);
        }
    }
    return vec4f(f, pdf);
}

// Share of light that reaches the body below the dielectric's reflection and is not transmitted.
fn body_share(b: Bsdf, l: Lobes, skin: vec3f) -> vec3f {
    var share = vec3f(1.0 - max_component(skin));
    if (energy_compensation) {
        share = vec3f(1.0 - max_component(vec3f(1.0) - l.body));
    }
    return share * ((1.0 - b.metallic) * (1.0 - b.transmission));
}

// The parts of `eval_above`, without the cosine and what the coat leaves.
fn diffuse_above(b: Bsdf, l: Lobes, skin: vec3f) -> vec3f {
    return body_share(b, l, skin) * (1.0 - b.diffuse_transmission) * b.base_color / PI;
}

fn sheen_above(b: Bsdf, wo: vec3f, wi: vec3f) -> vec3f {
    return b.sheen_color * charlie(wo, wi, max(b.sheen_roughness * b.sheen_roughness, 0.0025));
}

// What the sheen leaves of the light that is reflected below it.
fn below_sheen(b: Bsdf, l: Lobes, wi: vec3f) -> f32 {
    return 1.0 - max_component(b.sheen_color) * max(l.sheen, albedo_lookup(wi.z, b.sheen_roughness).z);
}

// Light that is scattered to the other side, without what coat and sheen leave of it. As all radiance, it is denser where the index is
// higher.
fn diffuse_below(b: Bsdf, l: Lobes, wo: vec3f, wi: vec3f) -> vec3f {
    let share = body_share(b, l, skin_fresnel(b, wo.z));
    let eta = select(1.0, b.eta, b.eta > 0.0);
    return share * b.diffuse_transmission * b.diffuse_transmission_color * (-wi.z / (PI * eta * eta));
}

// What coat and sheen leave of light that comes from below.
fn below_layers(b: Bsdf, l: Lobes) -> f32 {
    return (1.0 - l.cover) * (1.0 - max_component(b.sheen_color) * l.sheen);
}

fn eval_below(b: Bsdf, l: Lobes, wo: vec3f, wi: vec3f) -> vec4f {
    var f = vec3f(0.0);
    var pdf = 0.0;
    if (l.back_p > 0.0) {
        f += diffuse_below(b, l, wo, wi);
        pdf += l.back_p * -wi.z / PI;
    }
    if (l.through_p > 0.0) {
        let passing = b.base_color * ((1.0 - b.metallic) * b.transmission * l.through);
        if (b.eta == 1.0) {
            // A thin wall: the reflection's lobe, mirrored to the other side.
            let mirrored = vec3f(wi.xy, -wi.z);
            let h = normalize(wo + mirrored);
            let fresnel = dielectric_fresnel(b, dot(wo, h));
            f += passing * (vec3f(1.0) - fresnel) * ggx_reflection(wo, mirrored, h, b.alpha) * mirrored.z;
            pdf += l.through_p * ggx_reflection_pdf(wo, h, b.alpha);
        } else {
            // Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007. Radiance is carried, which
            // is denser inside by the square of the index.
            var h = normalize(wo + wi * b.eta);
            h = select(-h, h, h.z > 0.0);
            let o = dot(wo, h);
            let i = dot(wi, h);
            if (o > 0.0 && i < 0.0) {
                let t = i + o / b.eta;
                let jacobian = -i / (t * t);
                let fresnel = dielectric_fresnel(b, o);
                let normals = ggx_normal_pdf(wo, h, b.alpha);
                let masking = (1.0 + ggx_root(wo, b.alpha)) / (ggx_root(wo, b.alpha) + ggx_root(wi, b.alpha));
                f += passing * (vec3f(1.0) - fresnel) * (normals * jacobian * masking / (b.eta * b.eta));
                pdf += l.through_p * (1.0 - mirror_share(b, fresnel)) * normals * jacobian;
            }
        }
    }
    f *= below_layers(b, l);
    return vec4f(f, pdf);
}

// A direction that microfacets reflect to.
fn sample_reflection(wo: vec3f, alpha: vec2f, u: vec2f) -> vec3f {
    return reflect(-wo, sample_visible_normal(wo, alpha, reflection_bound(wo, alpha), u));
}

// A number in a lobe's share of [0, 1), over all of it.
fn within_share(place: f32, share: f32) -> f32 {
    return min(place / share, 0.99999994);
}

// A direction that a microfacet of a transparent body reflects or refracts to, by how much it does of either: by how much the surface
// as a whole does, rough glass would let few rays through where single microfacets let much through, and these would count for as much
// more. The first number decides by the latter, so that points are as well spread, and `coin` changes as many of these as have to be.
fn sample_glass(b: Bsdf, mirror: f32, wo: vec3f, u: vec2f, coin: f32) -> vec3f {
    var mirrors = u.x < mirror;
    let share = select(1.0 - mirror, mirror, mirrors);
    let place = within_share(select(u.x - mirror, u.x, mirrors), share);
    let h = sample_visible_normal(wo, b.alpha, 1.0, vec2f(place, u.y));
    let reflected = mirror_share(b, dielectric_fresnel(b, dot(wo, h)));
    if (coin * share >= select(1.0 - reflected, reflected, mirrors)) {
        mirrors = !mirrors;
    }
    let wi = select(refract(-wo, h, 1.0 / b.eta), reflect(-wo, h), mirrors);
    // What misses its side meets another microfacet, which the factor for multiple scattering stands for.
    return select(vec3f(0.0), wi, mirrors == (wi.z > 0.0));
}

// A direction. `l` is `lobes(b, wo)`. The first number chooses the lobe, too: points in each are as well spread as all together.
fn bsdf_sample(b: Bsdf, l: Lobes, wo: vec3f, u: vec3f) -> BsdfSample {
    let none = BsdfSample(vec3f(0.0), vec3f(0.0), 0.0);
    if (wo.z <= 0.0) {
        return none;
    }
    let after_specular = u.x - l.specular_p;
    let after_diffuse = after_specular - l.diffuse_p;
    let after_through = after_diffuse - l.through_p;
    let after_coat = after_through - l.coat_p;
    let after_back = after_coat - l.back_p;
    var wi: vec3f;
    var side = 1.0; // where the lobe lies: a direction that misses its side isn't one of another lobe
    if (after_specular < 0.0) {
        wi = sample_reflection(wo, b.alpha, vec2f(within_share(u.x, l.specular_p), u.y));
    } else if (after_diffuse < 0.0) {
        wi = sample_cosine(vec2f(within_share(after_specular, l.diffuse_p), u.y));
    } else if (has_transmission && after_through < 0.0) {
        let v = vec2f(within_share(after_diffuse, l.through_p), u.y);
        if (b.eta == 1.0) {
            wi = sample_reflection(wo, b.alpha, v);
            wi.z = -wi.z;
            side = -1.0;
        } else {
            wi = sample_glass(b, l.mirror, wo, v, u.z);
            side = sign(wi.z);
        }
    } else if (has_layers && after_coat < 0.0) {
        let o = to_coat(b, wo);
        if (o.z <= 0.0) {
            return none;
        }
        wi = from_coat(b, sample_reflection(o, vec2f(b.coat_alpha), vec2f(within_share(after_through, l.coat_p), u.y)));
    } else if (has_transmission && after_back < 0.0) {
        wi = sample_cosine(vec2f(within_share(after_coat, l.back_p), u.y));
        wi.z = -wi.z;
        side = -1.0;
    } else if (has_layers && l.sheen_p > 0.0) {
        wi = sample_hemisphere(vec2f(within_share(after_back, l.sheen_p), u.y));
    } else {
        return none; // what rounding has left
    }
    if (wi.z * side <= 0.0) {
        return none;
    }
    let value = bsdf_eval(b, l, wo, wi);
    if (value.w <= 0.0) {
        return none;
    }
    return BsdfSample(wi, value.xyz / value.w, value.w);
}
