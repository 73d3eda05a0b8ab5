// The solution's triangles, every sample of a glossy one shaded by itself: the distributions at the corners are evaluated
// towards what the sample mirrors. Their lobes follow mirror directions, so they are blended where they agree.
// In: one buffer each for positions, corners, vertices and distributions. Out: radiance [W·sr⁻¹·m⁻²].
struct ShadedVertex {
    normal: vec3<f32>,   // unit
    offset: u32,         // of its distribution in `words`, or NO_DISTRIBUTION
    radiance: vec3<f32>, // the part that does not depend on direction
    padding: u32,
}

const NO_DISTRIBUTION: u32 = 0xffffffffu;
// Distributions are not asked for directions nearer to the surface (`cpu::GRAZING`).
const GRAZING: f32 = 0.02;

@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> corners: array<u32>;
@group(1) @binding(2) var<storage, read> vertices: array<ShadedVertex>;
@group(1) @binding(3) var<storage, read> words: array<u32>;

struct Sample {
    @builtin(position) clip: vec4<f32>,
    @location(0) weights: vec3<f32>,                                // of the corners
    @location(1) relative: vec3<f32>,                               // to the eye [m]
    @location(2) @interpolate(flat, either) corners: vec3<u32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Sample {
    let first = index - index % 3u;
    let at = 3u * corners[index];
    // Relative to the eye before the matrix: scenes far from the origin keep their digits.
    let relative = vec3<f32>(positions[at], positions[at + 1u], positions[at + 2u]) - frame.eye;
    return Sample(
        frame.clip_from_relative * vec4<f32>(relative, 1.0),
        vec3<f32>(vec3<u32>(index % 3u) == vec3<u32>(0u, 1u, 2u)),
        relative,
        vec3<u32>(corners[first], corners[first + 1u], corners[first + 2u]),
    );
}

// The unit vector along `v`, or zero.
fn direction_of(v: vec3<f32>) -> vec3<f32> {
    let squared = dot(v, v);
    return select(vec3<f32>(0.0), v * inverseSqrt(squared), squared > 0.0);
}

// `direction` mirrored at a plane.
fn mirrored(normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    return normal * (2.0 * dot(normal, direction)) - direction;
}

// Radiance of a vertex towards what mirrors `incoming` there.
fn shaded(corner: u32, incoming: vec3<f32>) -> vec4<f32> {
    let vertex = vertices[corner];
    if vertex.offset == NO_DISTRIBUTION {
        return vec4<f32>(vertex.radiance, 0.0);
    }
    var direction = mirrored(vertex.normal, incoming);
    let height = dot(vertex.normal, direction);
    if height < GRAZING {
        direction = direction_of(direction + vertex.normal * (GRAZING - height));
    }
    return vec4<f32>(vertex.radiance + evaluate_distribution(vertex.offset, direction), 1.0);
}

@fragment
fn fragment(in: Sample) -> @location(0) vec4<f32> {
    let normal = direction_of(
        vertices[in.corners.x].normal * in.weights.x
            + vertices[in.corners.y].normal * in.weights.y
            + vertices[in.corners.z].normal * in.weights.z,
    );
    let incoming = mirrored(normal, direction_of(-in.relative));
    let colour = shaded(in.corners.x, incoming) * in.weights.x
        + shaded(in.corners.y, incoming) * in.weights.y
        + shaded(in.corners.z, incoming) * in.weights.z;
    let marked = frame.line_radiance * vec3<f32>(0.1, 0.55, 1.0);
    return vec4<f32>(mix(colour.rgb, marked, colour.w * frame.glossy_tint), 1.0);
}
