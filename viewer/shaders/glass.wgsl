// Clear surfaces: each multiplies what lies behind it by its tint. The order does not matter.
struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat, either) tint: vec3<f32>,
}

@vertex
fn vertex(@location(0) position: vec3<f32>, @location(1) tint: vec3<f32>) -> Corner {
    return Corner(frame.clip_from_relative * vec4<f32>(position - frame.eye, 1.0), tint);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(in.tint, 1.0);
}
