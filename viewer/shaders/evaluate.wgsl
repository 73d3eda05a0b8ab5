// Evaluates every glossy vertex towards the eye, once a frame (§5.2 of Stamminger et al. 2000).
// In: `glossy`, `words`. Out: `colours`, radiance [W·sr⁻¹·m⁻²] per vertex.
struct GlossyVertex {
    position: vec3<f32>, // in world space [m]
    offset: u32,         // of its distribution in `words`
    radiance: vec3<f32>, // the part that does not depend on direction
    vertex: u32,         // entry of `colours`
}

@group(1) @binding(0) var<storage, read> glossy: array<GlossyVertex>;
@group(1) @binding(1) var<storage, read> words: array<u32>;
@group(1) @binding(2) var<storage, read_write> colours: array<vec4<f32>>;

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&glossy) {
        return;
    }
    let entry = glossy[id.x];
    let towards = frame.eye - entry.position;
    let length_squared = dot(towards, towards);
    // An eye at the vertex sees it from nowhere: the direction stays zero, as on the CPU.
    let direction = select(vec3<f32>(0.0), towards * inverseSqrt(length_squared), length_squared > 0.0);
    colours[entry.vertex] = vec4<f32>(entry.radiance + evaluate_distribution(entry.offset, direction), 1.0);
}
