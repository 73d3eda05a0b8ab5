//! Rays on the hierarchy of `obvhs`, eight boxes and eight triangles at a time (AVX2).
//!
//! The same tests in the same order with the same rounding as [`obvhs::cwbvh::CwBvh`] and `Face::intersect` make, which
//! are its plain twin: what is found does not depend on the machine. Source: Ylitie, Karras, Laine 2017, "Efficient
//! incoherent ray traversal on GPUs through compressed wide BVHs", for the nodes.

use super::visibility::Face;
use glam::Vec3A;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ray::Ray;
use std::arch::x86_64::*;

/// Boxes and triangles that are tested at once.
const LANES: usize = 8;
/// The tree does not look for what is nearer.
const NEAREST: f32 = 1e-4;
/// Nodes that wait, at most: one a level.
const DEEPEST: usize = 32;
/// Of what a node was found to have hit: children that are nodes; triangles.
const NODES: u32 = 0xff00_0000;
const TRIANGLES: u32 = 0x00ff_ffff;

/// Vectors, one a lane.
type Vectors = [__m256; 3];

/// Triangles of one node.
#[derive(Clone, Copy)]
struct Block {
    corner: Vectors,
    edge1: Vectors,
    edge2: Vectors,
}

/// A ray in all lanes.
struct Lanes {
    origin: Vectors,
    direction: Vectors,
    tmin: __m256,
    tmax: __m256,
    /// Eight times the octant that it comes from.
    octants: u64,
}

/// The triangles of a tree, on a machine that has AVX2.
pub(super) struct Wide {
    blocks: Vec<Block>,
    /// First block of each node.
    first: Vec<u32>,
}

impl Wide {
    /// `faces` in the order of the tree's leaves. `None` where the machine lacks AVX2.
    pub(super) fn new(tree: &CwBvh, faces: &[Face]) -> Option<Self> {
        if !is_x86_feature_detected!("avx2") {
            return None;
        }
        let (mut blocks, mut first) = (Vec::new(), Vec::new());
        for node in &tree.nodes {
            first.push(blocks.len() as u32);
            let base = node.primitive_base_idx as usize;
            let of_node = &faces[base..base + triangle_count(node)];
            for faces in of_node.chunks(LANES) {
                #[allow(unsafe_code, reason = "the machine has AVX2")]
                blocks.push(unsafe { Block::new(faces) });
            }
        }
        Some(Self { blocks, first })
    }

    /// Calls `meet` with distance and number of each face that the ray meets, node by node from near to far, until what
    /// it returns is less than the ray's end. True when that was so.
    pub(super) fn meets(
        &self,
        tree: &CwBvh,
        ray: &Ray,
        mut meet: impl FnMut(f32, usize) -> f32,
    ) -> bool {
        let (mut is_met, tmax) = (false, ray.tmax);
        let meet = |t, face| {
            is_met = meet(t, face) < tmax;
            (tmax, is_met)
        };
        #[allow(unsafe_code, reason = "there are blocks: the machine has AVX2")]
        unsafe {
            self.traverse(tree, ray, meet);
        }
        is_met
    }

    /// Distance and number of the nearest face for which `meet` returns its distance and not infinity.
    pub(super) fn nearest(
        &self,
        tree: &CwBvh,
        ray: &Ray,
        mut meet: impl FnMut(f32, usize) -> f32,
    ) -> Option<(f32, usize)> {
        let (mut nearest, mut found) = (ray.tmax, None);
        let meet = |t, face| {
            if t < nearest && meet(t, face) < nearest {
                (nearest, found) = (t, Some((t, face)));
            }
            (nearest, false)
        };
        #[allow(unsafe_code, reason = "there are blocks: the machine has AVX2")]
        unsafe {
            self.traverse(tree, ray, meet);
        }
        found
    }

    /// `meet` returns where the ray ends from now on, and whether to stop.
    #[target_feature(enable = "avx2")]
    fn traverse(&self, tree: &CwBvh, ray: &Ray, mut meet: impl FnMut(f32, usize) -> (f32, bool)) {
        if tree.nodes.is_empty() {
            return;
        }
        let mut lanes = Lanes::new(tree, ray);
        let (mut stack, mut waiting) = ([(0u32, 0u32); DEEPEST], 0);
        // First child, and which of them were hit: the root is the one child of nothing.
        let mut group = (0u32, 1u32 << 31);
        loop {
            let child = group.1.ilog2();
            let is_inner = group.1;
            group.1 &= !(1 << child);
            if group.1 & NODES != 0 {
                stack[waiting] = group;
                waiting += 1;
            }
            let slot = (child - 24) ^ (lanes.octants as u32 & 0xff);
            let before = (is_inner & !(u32::MAX << slot)).count_ones();
            let number = (group.0 + before) as usize;
            let node = &tree.nodes[number];
            let hits = lanes.hits(node, ray);
            let triangles = hits & TRIANGLES;
            if triangles != 0 {
                let first = self.first[number] as usize;
                for block in (0..3).rev() {
                    let wanted = triangles >> (block * LANES) & 0xff;
                    if wanted == 0 {
                        continue;
                    }
                    let (distances, met) = lanes.meets(&self.blocks[first + block]);
                    let mut met = met & wanted;
                    while met != 0 {
                        let lane = met.ilog2() as usize;
                        met &= !(1 << lane);
                        let face = node.primitive_base_idx as usize + block * LANES + lane;
                        let (end, stop) = meet(lane_of(distances, lane), face);
                        if stop {
                            return;
                        }
                        lanes.tmax = _mm256_set1_ps(end);
                    }
                }
            }
            group = (node.child_base_idx, hits & NODES | u32::from(node.imask));
            if group.1 & NODES == 0 {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                group = stack[waiting];
            }
        }
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val::<[Block]>(&self.blocks) + size_of_val::<[u32]>(&self.first)
    }
}

/// Triangles of a node: those of its leaves follow each other.
fn triangle_count(node: &CwBvhNode) -> usize {
    let end = |meta: &u8| match meta >> 5 {
        0 => 0,
        _ if meta & 0b11000 == 0b11000 => 0,
        ones => usize::from(meta & 0b11111) + ones.count_ones() as usize,
    };
    node.child_meta.iter().map(end).max().unwrap_or(0)
}

impl Block {
    #[target_feature(enable = "avx2")]
    fn new(faces: &[Face]) -> Self {
        let vectors = |of: fn(&Face) -> Vec3A| {
            [0, 1, 2].map(|axis| {
                // Lanes without a triangle have one without area, and nobody asks for them.
                let lane = |i: usize| faces.get(i).map_or(0.0, |face| of(face)[axis]);
                let [a, b, c, d, e, f, g, h] = [0, 1, 2, 3, 4, 5, 6, 7].map(lane);
                _mm256_setr_ps(a, b, c, d, e, f, g, h)
            })
        };
        Self {
            corner: vectors(|face| face.corner),
            edge1: vectors(|face| face.edge1),
            edge2: vectors(|face| face.edge2),
        }
    }
}

impl Lanes {
    #[target_feature(enable = "avx2")]
    fn new(tree: &CwBvh, ray: &Ray) -> Self {
        let all = |vector: Vec3A| vector.to_array().map(|of_axis| _mm256_set1_ps(of_axis));
        let octants = tree.new_traversal(ray.direction).oct_inv4;
        Self {
            origin: all(ray.origin),
            direction: all(ray.direction),
            tmin: _mm256_set1_ps(ray.tmin),
            tmax: _mm256_set1_ps(ray.tmax),
            octants: u64::from(octants) << 32 | u64::from(octants),
        }
    }

    /// Which children of a node the ray hits: bits 24 to 31 for nodes, those below for triangles of leaves.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn hits(&self, node: &CwBvhNode, ray: &Ray) -> u32 {
        let extent = node.compute_extent() * ray.inv_direction;
        let origin = (Vec3A::from(node.p) - ray.origin) * ray.inv_direction;
        // Where it enters and leaves the slabs between the planes of an axis.
        let span = |axis: usize, low: [u8; 8], high: [u8; 8]| {
            let planes = if ray.direction[axis] < 0.0 {
                [high, low]
            } else {
                [low, high]
            };
            let (extent, origin) = (_mm256_set1_ps(extent[axis]), _mm256_set1_ps(origin[axis]));
            planes.map(|steps| {
                let steps = _mm256_cvtepi32_ps(widened(u64::from_le_bytes(steps)));
                _mm256_add_ps(_mm256_mul_ps(steps, extent), origin)
            })
        };
        let x = span(0, node.child_min_x, node.child_max_x);
        let y = span(1, node.child_min_y, node.child_max_y);
        let z = span(2, node.child_min_z, node.child_max_z);
        let near = _mm256_max_ps(x[0], _mm256_max_ps(y[0], z[0]));
        let near = _mm256_max_ps(near, _mm256_set1_ps(NEAREST));
        let far = _mm256_min_ps(x[1], _mm256_min_ps(y[1], z[1]));
        let far = _mm256_min_ps(far, self.tmax);
        let is_hit = _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far));
        let (bits, index) = node.get_child_and_index_bits(self.octants as u32);
        let of_child = _mm256_sllv_epi32(widened(bits), widened(index));
        any_of(_mm256_and_si256(of_child, is_hit))
    }

    /// Distances to the triangles of a block, and which of them it meets (Möller & Trumbore 1997).
    #[inline]
    #[target_feature(enable = "avx2")]
    fn meets(&self, block: &Block) -> (__m256, u32) {
        let Block {
            corner,
            edge1,
            edge2,
        } = block;
        let to_corner = [0, 1, 2].map(|axis| _mm256_sub_ps(corner[axis], self.origin[axis]));
        let normal = cross(edge1, edge2);
        let across = cross(&self.direction, &to_corner);
        let determinant = dot(&normal, &self.direction);
        let (zero, one) = (_mm256_setzero_ps(), _mm256_set1_ps(1.0));
        let inverse = _mm256_div_ps(one, determinant);
        let u = _mm256_mul_ps(dot(&across, edge2), inverse);
        let v = _mm256_mul_ps(dot(&across, edge1), inverse);
        let t = _mm256_mul_ps(dot(&normal, &to_corner), inverse);
        let is_inside = [
            _mm256_cmp_ps::<_CMP_NEQ_OQ>(determinant, zero),
            _mm256_cmp_ps::<_CMP_GE_OQ>(u, zero),
            _mm256_cmp_ps::<_CMP_GE_OQ>(v, zero),
            _mm256_cmp_ps::<_CMP_LE_OQ>(_mm256_add_ps(u, v), one),
            _mm256_cmp_ps::<_CMP_GE_OQ>(t, self.tmin),
        ];
        let is_before_end = _mm256_cmp_ps::<_CMP_LE_OQ>(t, self.tmax);
        let is_met = is_inside
            .into_iter()
            .fold(is_before_end, |all, one| _mm256_and_ps(all, one));
        (t, _mm256_movemask_ps(is_met) as u32)
    }
}

/// Eight bytes as eight numbers.
#[inline]
#[target_feature(enable = "avx2")]
fn widened(bytes: u64) -> __m256i {
    _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(bytes as i64))
}

/// The bits that any lane has.
#[inline]
#[target_feature(enable = "avx2")]
fn any_of(lanes: __m256i) -> u32 {
    let four = _mm_or_si128(
        _mm256_castsi256_si128(lanes),
        _mm256_extracti128_si256::<1>(lanes),
    );
    let two = _mm_or_si128(four, _mm_shuffle_epi32::<0b01_00_11_10>(four));
    let one = _mm_or_si128(two, _mm_shuffle_epi32::<0b10_11_00_01>(two));
    _mm_cvtsi128_si32(one) as u32
}

#[inline]
#[target_feature(enable = "avx2")]
fn lane_of(lanes: __m256, lane: usize) -> f32 {
    let turned = _mm256_permutevar8x32_ps(lanes, _mm256_set1_epi32(lane as i32));
    _mm256_cvtss_f32(turned)
}

#[inline]
#[target_feature(enable = "avx2")]
fn dot(a: &Vectors, b: &Vectors) -> __m256 {
    let [x, y, z] = [0, 1, 2].map(|axis| _mm256_mul_ps(a[axis], b[axis]));
    _mm256_add_ps(_mm256_add_ps(x, y), z)
}

#[inline]
#[target_feature(enable = "avx2")]
fn cross(a: &Vectors, b: &Vectors) -> Vectors {
    [(1, 2), (2, 0), (0, 1)]
        .map(|(i, j)| _mm256_sub_ps(_mm256_mul_ps(a[i], b[j]), _mm256_mul_ps(b[i], a[j])))
}
