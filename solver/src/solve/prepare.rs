//! What a solve reads and never changes: normalised scene, patches, lit sides, occluders, lobes.

use crate::brdf::Lobe;
use crate::config::Settings;
use crate::geometry::Polygon;
use crate::hierarchy::Hierarchy;
use crate::hierarchy::coincident::{covered_sides, lamps_first, usable_sides};
use crate::hierarchy::contact::{Contacts, Reach};
use crate::hierarchy::detail::Detail;
use crate::hierarchy::patch::{Patch, merge, welded};
use crate::hierarchy::reach::{Side, lamps, lit_sides};
use crate::hierarchy::targets::Lamps;
use crate::normalise::Normalised;
use crate::radiometry::Rgb;
use crate::scene::{Material, Scene, Triangle};
use crate::solve::Watch;
use crate::transport::propagate::Environment;
use crate::transport::region::PatchTree;
use crate::transport::visibility::{NO_PATCH, Occluder, Occluders};
use glam::Vec3;
use std::time::Instant;

/// What a material emits, normalised.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Emission {
    /// Radiance in every direction.
    pub even: Rgb,
    /// Radiance that comes on top of it, times what the lobe's albedo in a direction lacks of its largest: black but in
    /// a furnace.
    pub compensating: Rgb,
}

/// A scene made ready for its solve.
pub struct Prepared {
    /// Normalised scene.
    pub frame: Normalised,
    /// Patches of the surfaces that are not glass.
    pub patches: Vec<Patch>,
    /// Which of their sides reflect or emit.
    pub usable: Vec<[bool; 2]>,
    /// Which of their sides another patch in the same place hides.
    pub covered: Vec<[bool; 2]>,
    /// Which of their sides light can reach, and which emit.
    pub lit: Vec<[Side; 2]>,
    /// Where light comes from.
    pub lamps: Lamps,
    /// Where things stand.
    pub detail: Detail,
    /// All patches, for what may stand between two of them.
    pub tree: PatchTree,
    /// Shape of each patch.
    pub shapes: Vec<Polygon>,
    /// All surfaces as occluders.
    pub occluders: Occluders,
    /// Clear triangles: corners, material.
    pub glass: Vec<[Vec3; 3]>,
    /// Materials of `glass`.
    pub glass_material: Vec<u32>,
    /// Glossy lobe per material.
    pub lobes: Vec<Option<Lobe>>,
    /// Diffuse reflectance per material.
    pub diffuse: Vec<Rgb>,
    /// What sides that emit do emit, per material.
    pub emission: Vec<Emission>,
    /// Time that this took [s].
    pub seconds: f64,
}

impl Prepared {
    /// Makes `scene` ready.
    pub fn new(scene: &Scene, settings: &Settings) -> Self {
        Self::watched(scene, settings, &mut Watch::new(&mut (), None, None))
    }

    /// The same under a watch: stopped, sides that light is not known to reach yet stay dark.
    pub(crate) fn watched(scene: &Scene, settings: &Settings, watch: &mut Watch<'_>) -> Self {
        let started = Instant::now();
        let frame = Normalised::new(scene);
        let is_glass = |t: &&Triangle| frame.materials[t.material as usize].is_glass();
        let first_there = welded(&frame.points);
        let opaque: Vec<Triangle> = scene
            .triangles()
            .iter()
            .filter(|t| !is_glass(t))
            .map(|t| Triangle {
                points: t.points.map(|p| first_there[p as usize]),
                ..*t
            })
            .collect();
        let clear: Vec<Triangle> = scene.triangles().iter().filter(is_glass).copied().collect();
        let (mut patches, mut patch_of) = merge(&frame.points, scene.normals(), &opaque);
        lamps_first(&mut patches, &mut patch_of, &frame.materials);
        let corners = |t: &Triangle| t.points.map(|p| frame.points[p as usize]);
        let mut occluding: Vec<Occluder> = opaque
            .iter()
            .zip(&patch_of)
            .map(|(t, &patch)| Occluder {
                corners: corners(t),
                patch,
                transmission: Rgb::BLACK,
            })
            .collect();
        occluding.extend(clear.iter().map(|t| Occluder {
            corners: corners(t),
            patch: NO_PATCH,
            transmission: frame.materials[t.material as usize].transmission,
        }));
        let occluders = Occluders::new(&occluding);
        let lobes = frame
            .materials
            .iter()
            .map(|m| Lobe::of(m, settings.sharpest_roughness))
            .collect();
        let shapes: Vec<Polygon> = patches
            .iter()
            .map(|patch| Polygon::new(&patch.corners(&frame.points)))
            .collect();
        let glass: Vec<[Vec3; 3]> = clear.iter().map(corners).collect();
        let tree = PatchTree::new(&shapes, &glass);
        let usable = usable_sides(&patches, &frame.materials);
        let covered = covered_sides(&tree, &shapes, &usable);
        let mut seen = usable.clone();
        for (seen, covered) in seen.iter_mut().zip(&covered) {
            for side in 0..2 {
                seen[side] &= !covered[side];
            }
        }
        let contacts = Contacts {
            tree: &tree,
            shapes: &shapes,
            occluders: &occluders,
            usable: &usable,
        };
        let (materials, lights) = (&frame.materials, &frame.point_lights);
        let mut report = || watch.report("finding light", 0.0, 0);
        let lit = lit_sides(&contacts, &patches, materials, lights, &seen, &mut report);
        let lamps = lamps(&shapes, &lit, lights);
        let diffuse = frame.materials.iter().map(|m| m.diffuse).collect();
        let even = |material: &Material| Emission {
            even: material.emission,
            compensating: Rgb::BLACK,
        };
        let emission = frame.materials.iter().map(even).collect();
        Self {
            emission,
            glass,
            glass_material: clear.iter().map(|t| t.material).collect(),
            detail: Detail::of(&shapes),
            tree,
            shapes,
            frame,
            patches,
            usable,
            covered,
            lit,
            lamps,
            occluders,
            lobes,
            diffuse,
            seconds: started.elapsed().as_secs_f64(),
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.frame.points[..])
            + size_of_val(&self.patches[..])
            + size_of_val(&self.shapes[..])
            + size_of_val(&self.usable[..])
            + size_of_val(&self.covered[..])
            + size_of_val(&self.lit[..])
            + size_of_val(&self.glass[..])
            + self.tree.bytes()
            + self.occluders.bytes()
    }

    /// What the side of a patch emits.
    pub fn emission(&self, patch: u32, back: bool) -> Emission {
        if self.lit[patch as usize][usize::from(back)].emits {
            self.emission[self.patches[patch as usize].material as usize]
        } else {
            Emission::default()
        }
    }

    /// What links see of it.
    pub fn environment(&self) -> Environment<'_> {
        Environment {
            occluders: &self.occluders,
            tree: &self.tree,
            shapes: &self.shapes,
            detail: self.detail,
            lobes: &self.lobes,
            point_lights: &self.frame.point_lights,
            diffuse: &self.diffuse,
            reach: self.reach(),
        }
    }

    /// Clusters and patches, and what light can reach of them; no element is subdivided yet.
    pub fn hierarchy(&self) -> Hierarchy {
        let mut hierarchy = Hierarchy::new(
            self.frame.points.clone(),
            self.patches.clone(),
            &self.frame.materials,
            &self.lit,
        );
        self.reach().expose(&mut hierarchy, 0);
        hierarchy
    }

    /// Where light can reach.
    pub fn reach(&self) -> Reach<'_> {
        Reach {
            contacts: Contacts {
                tree: &self.tree,
                shapes: &self.shapes,
                occluders: &self.occluders,
                usable: &self.usable,
            },
            sides: &self.lit,
            lamps: &self.lamps,
        }
    }
}
