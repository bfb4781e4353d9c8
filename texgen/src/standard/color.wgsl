
// Standard functions: colours. RGB is linear Rec.709 unless it is said otherwise.

fn luminance(rgb: vec3f) -> f32 { return dot(rgb, vec3f(0.2126, 0.7152, 0.0722)); }

// sRGB as in files, and light (IEC 61966-2-1).
fn srgbToLinear(encoded: vec3f) -> vec3f {
    let c = max(encoded, vec3f());
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}
fn linearToSrgb(rgb: vec3f) -> vec3f {
    let c = max(rgb, vec3f());
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

// Hue, saturation and value; hue is 0 to 1 and goes round.
fn rgbToHsv(rgb: vec3f) -> vec3f {
    let most = max(rgb.r, max(rgb.g, rgb.b));
    let spread = most - min(rgb.r, min(rgb.g, rgb.b));
    if spread <= 0.0 || most <= 0.0 {
        return vec3f(0.0, 0.0, most);
    }
    return vec3f(hueOf(rgb, most, spread), spread / most, most);
}
fn hsvToRgb(hsv: vec3f) -> vec3f {
    let ramp = saturate(abs(6.0 * fract(hsv.x + vec3f(0.0, 2.0 / 3.0, 1.0 / 3.0)) - 3.0) - 1.0);
    return hsv.z * mix(vec3f(1.0), ramp, hsv.y);
}

// Hue, saturation and lightness. Light brighter than white has a lightness above 1, and a saturation below 0 there; the way back
// gives the same light.
fn rgbToHsl(rgb: vec3f) -> vec3f {
    let most = max(rgb.r, max(rgb.g, rgb.b));
    let least = min(rgb.r, min(rgb.g, rgb.b));
    let spread = most - least;
    let lightness = 0.5 * (most + least);
    if spread <= 0.0 {
        return vec3f(0.0, 0.0, lightness);
    }
    return vec3f(hueOf(rgb, most, spread), spread / hslRoom(lightness), lightness);
}
fn hslToRgb(hsl: vec3f) -> vec3f {
    let ramp = saturate(abs(6.0 * fract(hsl.x + vec3f(0.0, 2.0 / 3.0, 1.0 / 3.0)) - 3.0) - 1.0);
    return hsl.z + hsl.y * (ramp - 0.5) * hslRoom(hsl.z);
}

// The largest spread of the components that leaves colours of this lightness within 0 and 1; never 0.
fn hslRoom(lightness: f32) -> f32 {
    let room = 1.0 - abs(2.0 * lightness - 1.0);
    return select(room, 1e-6, abs(room) < 1e-6);
}

fn hueOf(rgb: vec3f, most: f32, spread: f32) -> f32 {
    var hue = (rgb.r - rgb.g) / spread + 4.0;
    if most == rgb.r {
        hue = (rgb.g - rgb.b) / spread;
    } else if most == rgb.g {
        hue = (rgb.b - rgb.r) / spread + 2.0;
    }
    return fract(hue / 6.0);
}

// Oklab (Ottosson 2020): lightness, green to red, blue to yellow; equal steps look equal.
fn rgbToOklab(rgb: vec3f) -> vec3f {
    let lms = mat3x3f(
        vec3f(0.41222147, 0.21190350, 0.08830246),
        vec3f(0.53633254, 0.68069955, 0.28171884),
        vec3f(0.05144599, 0.10739696, 0.62997870),
    ) * rgb;
    let root = sign(lms) * pow(abs(lms), vec3f(1.0 / 3.0));
    return mat3x3f(
        vec3f(0.21045426, 1.97799850, 0.02590404),
        vec3f(0.79361779, -2.42859221, 0.78277177),
        vec3f(-0.00407205, 0.45059371, -0.80867577),
    ) * root;
}
fn oklabToRgb(lab: vec3f) -> vec3f {
    let root = mat3x3f(
        vec3f(1.0, 1.0, 1.0),
        vec3f(0.39633778, -0.10556135, -0.08948418),
        vec3f(0.21580376, -0.06385417, -1.29148555),
    ) * lab;
    return mat3x3f(
        vec3f(4.07674166, -1.26843800, -0.00419609),
        vec3f(-3.30771159, 2.60975740, -0.70341861),
        vec3f(0.23096993, -0.34131940, 1.70761470),
    ) * (root * root * root);
}

// CIE 1931 XYZ (white D65) to RGB.
fn xyzToRgb(xyz: vec3f) -> vec3f {
    return mat3x3f(
        vec3f(3.2404542, -0.9692660, 0.0556434),
        vec3f(-1.5371385, 1.8760108, -0.2040259),
        vec3f(-0.4985314, 0.0415560, 1.0572252),
    ) * xyz;
}

// Colour of a glowing body of so many kelvin, 1000 to 25000, with luminance 1 (Kim et al. 2002 for its chromaticity).
fn blackbody(kelvin: f32) -> vec3f {
    let t = clamp(kelvin, 1000.0, 25000.0);
    let u = 1000.0 / t;
    var x = ((-0.2661239 * u - 0.2343589) * u + 0.8776956) * u + 0.179910;
    if t > 4000.0 {
        x = ((-3.0258469 * u + 2.1070379) * u + 0.2226347) * u + 0.240390;
    }
    var y = ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683;
    if t > 4000.0 {
        y = ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483;
    } else if t > 2222.0 {
        y = ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867;
    }
    let rgb = max(xyzToRgb(vec3f(x / y, 1.0, (1.0 - x - y) / y)), vec3f());
    return rgb / max(luminance(rgb), 1e-6);
}

// Colour of light of one wavelength in nanometres, 380 to 780: the eye's response (fits of Wyman, Sloan and Shirley 2013), without
// what screens can't show.
fn wavelength(nanometres: f32) -> vec3f {
    let w = nanometres;
    let x = 1.056 * cieLobe(w, 599.8, 0.0264, 0.0323) + 0.362 * cieLobe(w, 442.0, 0.0624, 0.0374)
        - 0.065 * cieLobe(w, 501.1, 0.0490, 0.0382);
    let y = 0.821 * cieLobe(w, 568.8, 0.0213, 0.0247) + 0.286 * cieLobe(w, 530.9, 0.0613, 0.0322);
    let z = 1.217 * cieLobe(w, 437.0, 0.0845, 0.0278) + 0.681 * cieLobe(w, 459.0, 0.0385, 0.0725);
    return max(xyzToRgb(vec3f(x, y, z)), vec3f());
}

fn cieLobe(w: f32, middle: f32, below: f32, above: f32) -> f32 {
    let t = (w - middle) * select(above, below, w < middle);
    return exp(-0.5 * t * t);
}
