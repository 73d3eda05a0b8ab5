// Averages blocks of samples to pixels, glass tint applied. Out: radiance, or a colour for the display.
struct Resolve {
    samples: u32,   // across and down a pixel
    has_glass: u32, // 0: `tint` is a stand-in
    exposure: f32,  // display colour = sRGB(exposure · radiance)
    padding: u32,
}

@group(0) @binding(0) var<uniform> resolve: Resolve;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var tint: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // One triangle that covers the target.
    return vec4<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn mean(pixel: vec2<u32>) -> vec3<f32> {
    let corner = pixel * resolve.samples;
    var sum = vec3<f32>(0.0);
    for (var y = 0u; y < resolve.samples; y++) {
        for (var x = 0u; x < resolve.samples; x++) {
            let at = corner + vec2<u32>(x, y);
            var sample = textureLoad(radiance, at, 0).rgb;
            if resolve.has_glass != 0u {
                sample *= textureLoad(tint, at, 0).rgb;
            }
            sum += sample;
        }
    }
    return sum / f32(resolve.samples * resolve.samples);
}

@fragment
fn linear(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4<f32>(mean(vec2<u32>(at.xy)), 1.0);
}

@fragment
fn display(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let exposed = clamp(mean(vec2<u32>(at.xy)) * resolve.exposure, vec3<f32>(0.0), vec3<f32>(1.0));
    let low = exposed * 12.92;
    let high = 1.055 * pow(exposed, vec3<f32>(1.0 / 2.4)) - 0.055;
    return vec4<f32>(select(high, low, exposed <= vec3<f32>(0.0031308)), 1.0);
}
