// How samples of lights and samples of the BSDF share the light that both can find. All ways agree on average; balanced
// by multiple importance sampling they are least noisy.

const ESTIMATOR_MIS = 0u;
const ESTIMATOR_BSDF = 1u; // lights are found by scattered rays alone, but for those that have no extent
const ESTIMATOR_LIGHTS = 2u; // scattered rays find only what can't be sampled as a light

// The weight of a light sample, whose direction the BSDF would have sampled with `bsdf_pdf`.
fn light_sample_weight(light_pdf: f32, bsdf_pdf: f32, is_delta: bool) -> f32 {
    if (is_delta || frame.estimator == ESTIMATOR_LIGHTS) {
        return 1.0;
    }
    return select(mis_weight(light_pdf, bsdf_pdf), 0.0, frame.estimator == ESTIMATOR_BSDF);
}

// The weight of light that a ray met which the BSDF sent there, and which is sampled as a light with `light_pdf`; either
// is 0 where that is not how it came about.
fn met_light_weight(bsdf_pdf: f32, light_pdf: f32) -> f32 {
    if (bsdf_pdf <= 0.0 || light_pdf <= 0.0 || frame.estimator == ESTIMATOR_BSDF) {
        return 1.0;
    }
    return select(mis_weight(bsdf_pdf, light_pdf), 0.0, frame.estimator == ESTIMATOR_LIGHTS);
}
