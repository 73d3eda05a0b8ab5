//! Generator of sheen's own scenes: OBJ, MTL, camera sidecar and README, the same bytes every time.
//!
//! One module a scene; `builder` welds positions and writes text, `shapes` knows solids. Conventions:
//! metres, y up, front faces counter-clockwise, normalised modified Phong with Kd + Ks ≤ 1.

mod area_light;
mod builder;
mod cafe;
mod cornell_box;
mod furnace;
mod glossy_room;
mod glossy_sphere;
mod lamp_grid;
mod parallel_plates;
mod shapes;
mod three_lights;

pub use builder::GeneratedScene;

/// Every scene, in the order in which they are written.
pub fn all() -> Vec<GeneratedScene> {
    vec![
        furnace::scene(),
        parallel_plates::scene(),
        cornell_box::diffuse(),
        cornell_box::glossy(),
        three_lights::scene(),
        glossy_sphere::scene(),
        lamp_grid::close(),
        lamp_grid::apart(),
        lamp_grid::far_apart(),
        area_light::scene(),
        glossy_room::scene(),
        cafe::scene(),
    ]
}
