// Wireframe: edges of hierarchy elements, drawn a little towards the eye, those of back faces left out.
// How much nearer than its surface a line is drawn: beats interpolation error, hides behind what is in front.
const NEARER: f32 = 0.998;

@vertex
fn vertex(@location(0) position: vec3<f32>, @location(1) face_normal: vec3<f32>) -> @builtin(position) vec4<f32> {
    let relative = position - frame.eye;
    if dot(face_normal, relative) >= 0.0 {
        // Outside the clip volume.
        return vec4<f32>(2.0, 2.0, 2.0, 1.0);
    }
    return frame.clip_from_relative * vec4<f32>(relative * NEARER, 1.0);
}

@fragment
fn fragment() -> @location(0) vec4<f32> {
    return vec4<f32>(frame.line_radiance, 1.0);
}
