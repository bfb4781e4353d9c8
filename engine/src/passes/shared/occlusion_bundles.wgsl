// All rays of ambient occlusion of a hit by one thread, as suits processors.
//!include shared/occlusion.wgsl
//!include shared/traversal.wgsl

// Traces all rays of a site, four at a time.
fn occlusion_of_all(at: OcclusionSite) -> Occlusion {
    var all = Occlusion(0u, 0u);
    let count = at.table.samples;
    // Rays of one side start at one place.
    let step = select(1u, 2u, at.table.direction == AO_BOTH);
    for (var side = 0u; side < step; side++) {
        for (var first = side; first < count; first += 4u * step) {
            let a = occlusion_ray(at, first);
            let b = occlusion_ray(at, first + step);
            let c = occlusion_ray(at, first + 2u * step);
            let d = occlusion_ray(at, first + 3u * step);
            let numbers = vec4u(first) + vec4u(0u, 1u, 2u, 3u) * step;
            let is_there = numbers < vec4u(count);
            let is_free = vec4<bool>(a.is_free, b.is_free, c.is_free, d.is_free);
            let bits = select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), is_there & !is_free);
            let asked = bits.x | bits.y | bits.z | bits.w;
            all.free += countOneBits(dot(select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), is_there & is_free), vec4u(1u)));
            if (asked == 0u) {
                continue;
            }
            let x = vec4f(a.direction.x, b.direction.x, c.direction.x, d.direction.x);
            let y = vec4f(a.direction.y, b.direction.y, c.direction.y, d.direction.y);
            let z = vec4f(a.direction.z, b.direction.z, c.direction.z, d.direction.z);
            let met = trace_bundle(a.origin, x, y, z, at.table.distance, asked, at.only_instance);
            all.occluded += countOneBits(met & 15u);
            var doubtful = met >> 4u;
            while (doubtful != 0u) {
                let i = firstTrailingBit(doubtful);
                doubtful &= doubtful - 1u;
                all.occluded += occlusion(at, first + i * step).occluded;
            }
        }
    }
    return all;
}
