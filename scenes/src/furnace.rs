//! `furnace`: a closed box in which every radiance is known.

use glam::{DVec3, dvec3};

use crate::builder::{About, Camera, GeneratedScene, Material, SceneBuilder};
use crate::shapes::{Rectangle, border, rectangle};

/// The closed box; six quads seen from inside.
pub(crate) fn scene() -> GeneratedScene {
    let mut b = SceneBuilder::new(About {
        name: "furnace",
        title: "Closed box that emits 1 and reflects 0.5 everywhere",
        stresses: "energy conservation and closure: no light may be lost or made",
        known: &[
            "Radiance 1 / (1 - 0.5) = 2 W/(sr m²) in every direction at every point, so 2 in every pixel",
            "Radiosity 2π, emitted exitance π, irradiance 2π W/m²; all emitted power is absorbed",
            "Form factors of every row sum to 1",
        ],
    });
    let shell = b.material("shell", Material::diffuse([0.5; 3]).emitting([1.0; 3]));
    let (width, height, depth) = (1.8, 1.2, 1.5);
    b.object("shell");
    // The far wall, then what leads from it to the near one, then the near wall.
    let far = Rectangle {
        origin: DVec3::ZERO,
        u: width * DVec3::X,
        v: height * DVec3::Y,
    };
    let near = far.inset(0.0, -depth);
    border(&mut b, shell, near, far);
    rectangle(&mut b, shell, far);
    let near = Rectangle {
        origin: dvec3(width, 0.0, depth),
        u: -width * DVec3::X,
        v: height * DVec3::Y,
    };
    rectangle(&mut b, shell, near);
    b.camera(Camera {
        name: "inside",
        eye: [1.5, 0.9, 1.2],
        target: [0.4, 0.4, 0.3],
        fov_y_degrees: 65.0,
        size: [256, 256],
    });
    b.finish()
}
