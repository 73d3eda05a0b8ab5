// The solution's triangles with their vertices' radiance, interpolated linearly.
struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) colour: vec4<f32>, // radiance; w: 1 where the vertex is glossy
}

@vertex
fn vertex(@location(0) position: vec3<f32>, @location(1) colour: vec4<f32>) -> Corner {
    // Relative to the eye before the matrix: scenes far from the origin keep their digits.
    return Corner(frame.clip_from_relative * vec4<f32>(position - frame.eye, 1.0), colour);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    let tint = in.colour.w * frame.glossy_tint;
    let marked = frame.line_radiance * vec3<f32>(0.1, 0.55, 1.0);
    return vec4<f32>(mix(in.colour.rgb, marked, tint), 1.0);
}
