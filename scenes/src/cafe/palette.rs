//! Materials of the café.

use crate::builder::{Material, MaterialId, SceneBuilder};

/// Every material, by what it is used for.
pub(crate) struct Palette {
    pub(crate) tile_light: MaterialId,
    pub(crate) tile_dark: MaterialId,
    pub(crate) plaster: MaterialId,
    pub(crate) ceiling: MaterialId,
    pub(crate) beam: MaterialId,
    pub(crate) wainscot: MaterialId,
    pub(crate) trim: MaterialId,
    pub(crate) door: MaterialId,
    pub(crate) window_frame: MaterialId,
    pub(crate) window: MaterialId,
    pub(crate) iron: MaterialId,
    pub(crate) counter_panel: MaterialId,
    pub(crate) counter_frame: MaterialId,
    pub(crate) counter_top: MaterialId,
    pub(crate) shelf: MaterialId,
    pub(crate) chrome: MaterialId,
    pub(crate) brass: MaterialId,
    pub(crate) machine: MaterialId,
    pub(crate) rubber: MaterialId,
    pub(crate) vinyl: MaterialId,
    pub(crate) table_top: MaterialId,
    pub(crate) chair_wood: MaterialId,
    pub(crate) chair_seats: [MaterialId; 3],
    pub(crate) porcelain: MaterialId,
    pub(crate) cups: [MaterialId; 3],
    pub(crate) bottles: [MaterialId; 5],
    pub(crate) coffee: MaterialId,
    pub(crate) cake: MaterialId,
    pub(crate) icing: MaterialId,
    pub(crate) terracotta: MaterialId,
    pub(crate) soil: MaterialId,
    pub(crate) leaves: MaterialId,
    pub(crate) petals: MaterialId,
    pub(crate) board: MaterialId,
    pub(crate) chalk: MaterialId,
    pub(crate) gilt: MaterialId,
    pub(crate) paints: [MaterialId; 6],
    pub(crate) lamp: MaterialId,
    pub(crate) cord: MaterialId,
}

impl Palette {
    /// Adds the materials to a scene.
    pub(crate) fn new(b: &mut SceneBuilder) -> Self {
        let mut diffuse = |name: &str, kd| b.material(name, Material::diffuse(kd));
        let plaster = diffuse("plaster", [0.78, 0.66, 0.48]);
        let ceiling = diffuse("ceiling", [0.82, 0.79, 0.73]);
        let beam = diffuse("beam", [0.24, 0.14, 0.075]);
        let wainscot = diffuse("wainscot", [0.36, 0.2, 0.1]);
        let iron = diffuse("iron", [0.07, 0.1, 0.09]);
        let rubber = diffuse("rubber", [0.04, 0.04, 0.04]);
        let coffee = diffuse("coffee", [0.09, 0.045, 0.02]);
        let cake = diffuse("cake", [0.3, 0.15, 0.07]);
        let soil = diffuse("soil", [0.06, 0.04, 0.025]);
        let leaves = diffuse("leaves", [0.09, 0.25, 0.06]);
        let petals = diffuse("petals", [0.78, 0.3, 0.24]);
        let board = diffuse("board", [0.035, 0.045, 0.04]);
        let chalk = diffuse("chalk", [0.76, 0.74, 0.68]);
        let cord = diffuse("cord", [0.03, 0.03, 0.03]);
        let paints = [
            diffuse("paint_ochre", [0.66, 0.44, 0.12]),
            diffuse("paint_rust", [0.55, 0.16, 0.06]),
            diffuse("paint_blue", [0.08, 0.2, 0.42]),
            diffuse("paint_sand", [0.76, 0.68, 0.52]),
            diffuse("paint_olive", [0.26, 0.3, 0.1]),
            diffuse("paint_night", [0.05, 0.07, 0.13]),
        ];
        let mut glossy =
            |name: &str, kd, ks: [f64; 3], ns| b.material(name, Material::glossy(kd, ks, ns));
        Self {
            tile_light: glossy("tile_light", [0.46, 0.4, 0.31], [0.3; 3], 100.0),
            tile_dark: glossy("tile_dark", [0.27, 0.115, 0.07], [0.3; 3], 100.0),
            trim: glossy("trim", [0.28, 0.15, 0.07], [0.07; 3], 40.0),
            door: glossy("door", [0.1, 0.22, 0.19], [0.1; 3], 60.0),
            window_frame: glossy("window_frame", [0.62, 0.59, 0.52], [0.06; 3], 40.0),
            window: glossy("window", [0.012, 0.016, 0.03], [0.3; 3], 200.0),
            counter_panel: glossy("counter_panel", [0.06, 0.27, 0.27], [0.14; 3], 60.0),
            counter_frame: glossy("counter_frame", [0.26, 0.13, 0.06], [0.1; 3], 50.0),
            counter_top: glossy("counter_top", [0.16, 0.08, 0.045], [0.28; 3], 120.0),
            shelf: glossy("shelf", [0.4, 0.23, 0.11], [0.08; 3], 50.0),
            chrome: glossy("chrome", [0.06, 0.06, 0.06], [0.74, 0.75, 0.77], 180.0),
            brass: glossy("brass", [0.12, 0.08, 0.03], [0.68, 0.5, 0.22], 120.0),
            machine: glossy("machine", [0.5, 0.05, 0.04], [0.2; 3], 120.0),
            vinyl: glossy("vinyl", [0.6, 0.07, 0.05], [0.1; 3], 35.0),
            table_top: glossy("table_top", [0.58, 0.55, 0.5], [0.22; 3], 120.0),
            chair_wood: glossy("chair_wood", [0.3, 0.15, 0.065], [0.1; 3], 50.0),
            chair_seats: [
                glossy("seat_mustard", [0.66, 0.42, 0.07], [0.06; 3], 30.0),
                glossy("seat_teal", [0.06, 0.32, 0.34], [0.06; 3], 30.0),
                glossy("seat_coral", [0.68, 0.22, 0.13], [0.06; 3], 30.0),
            ],
            porcelain: glossy("porcelain", [0.74, 0.72, 0.68], [0.14; 3], 120.0),
            cups: [
                glossy("cup_white", [0.76, 0.74, 0.7], [0.14; 3], 120.0),
                glossy("cup_blue", [0.12, 0.26, 0.5], [0.16; 3], 120.0),
                glossy("cup_yellow", [0.72, 0.5, 0.1], [0.14; 3], 120.0),
            ],
            bottles: [
                glossy("bottle_green", [0.03, 0.16, 0.06], [0.4; 3], 150.0),
                glossy("bottle_amber", [0.42, 0.16, 0.02], [0.36; 3], 150.0),
                glossy("bottle_ruby", [0.36, 0.02, 0.04], [0.36; 3], 150.0),
                glossy("bottle_blue", [0.03, 0.1, 0.36], [0.38; 3], 150.0),
                glossy("bottle_cream", [0.62, 0.54, 0.38], [0.24; 3], 100.0),
            ],
            icing: glossy("icing", [0.74, 0.5, 0.5], [0.08; 3], 25.0),
            terracotta: glossy("terracotta", [0.5, 0.2, 0.11], [0.05; 3], 20.0),
            gilt: glossy("gilt", [0.3, 0.2, 0.07], [0.4, 0.3, 0.13], 60.0),
            lamp: b.material(
                "lamp",
                Material::diffuse([0.7, 0.68, 0.62]).emitting([11.0, 8.8, 6.0]),
            ),
            plaster,
            ceiling,
            beam,
            wainscot,
            iron,
            rubber,
            coffee,
            cake,
            soil,
            leaves,
            petals,
            board,
            chalk,
            paints,
            cord,
        }
    }
}
