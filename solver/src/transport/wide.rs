//! Rays on the hierarchy of `obvhs`, eight boxes and eight triangles at a time (AVX2).
//!
//! The same triangles in the same order as [`obvhs::cwbvh::CwBvh`] and `Face::intersect` test, which are the plain twin:
//! what is found does not depend on the machine. Source: Ylitie, Karras, Laine 2017, "Efficient incoherent ray traversal
//! on GPUs through compressed wide BVHs", for the order. Boxes are as tight as the tree's, but not compressed: a processor
//! has room for them, and no time to unpack them.

use super::visibility::Face;
use glam::Vec3A;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ray::Ray;
use std::arch::x86_64::*;

/// Boxes and triangles that are tested at once.
const LANES: usize = 8;
/// All of them.
const ALL: u32 = 0xff;
/// The tree does not look for what is nearer.
const NEAREST: f32 = 1e-4;
/// Nodes that wait, at most: one a level.
const DEEPEST: usize = 32;

/// Vectors, one a lane.
type Vectors = [__m256; 3];

/// Children in the order that a ray meets them in, last first: bit i ^ octant of a mask comes to i.
const IN_ORDER: [[u8; 256]; 8] = in_order();

const fn in_order() -> [[u8; 256]; 8] {
    let mut table = [[0u8; 256]; 8];
    let mut octant = 0;
    while octant < 8 {
        let mut mask = 0;
        while mask < 256 {
            let mut i = 0;
            while i < 8 {
                table[octant][mask] |= ((mask >> (i ^ octant) & 1) << i) as u8;
                i += 1;
            }
            mask += 1;
        }
        octant += 1;
    }
    table
}

/// A node of the tree.
#[derive(Clone, Copy)]
struct Node {
    /// Low and high ends of the children's boxes along each axis.
    ends: [[__m256; 2]; 3],
    /// Of each child that is a leaf, which of the node's triangles it has.
    triangles: [u32; LANES],
    /// Which children are nodes.
    inner: u32,
    /// The first of these, of the node's blocks, and of its triangles.
    children: u32,
    blocks: u32,
    faces: u32,
}

/// Triangles of one node.
#[derive(Clone, Copy)]
struct Block {
    corner: Vectors,
    edge1: Vectors,
    edge2: Vectors,
    normal: Vectors,
}

/// A ray in all lanes.
struct Lanes {
    origin: Vectors,
    direction: Vectors,
    inverse: Vectors,
    tmin: __m256,
    tmax: __m256,
    /// Which end of a box it meets first, of each axis.
    against: [usize; 3],
}

/// Nodes and triangles of a tree, on a machine that has AVX2.
pub(super) struct Wide {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
}

/// True where [`Wide`] can be used: what the first processors with AVX2 had.
pub(super) fn is_supported() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
}

impl Wide {
    /// `faces` in the order of the tree's leaves. `None` where the machine lacks what it takes.
    pub(super) fn new(tree: &CwBvh, faces: &[Face]) -> Option<Self> {
        if !is_supported() {
            return None;
        }
        let (mut nodes, mut blocks) = (Vec::new(), Vec::new());
        for node in &tree.nodes {
            #[allow(unsafe_code, reason = "the machine has AVX2")]
            nodes.push(unsafe { Node::new(node, blocks.len()) });
            let base = node.primitive_base_idx as usize;
            let of_node = &faces[base..base + triangle_count(node)];
            for faces in of_node.chunks(LANES) {
                #[allow(unsafe_code, reason = "the machine has AVX2")]
                blocks.push(unsafe { Block::new(faces) });
            }
        }
        Some(Self { nodes, blocks })
    }

    /// Calls `meet` with distance and number of each face that the ray meets, node by node from near to far, until what
    /// it returns is less than the ray's end. True when that was so.
    pub(super) fn meets(&self, ray: &Ray, mut meet: impl FnMut(f32, usize) -> f32) -> bool {
        let (mut is_met, tmax) = (false, ray.tmax);
        let meet = |t, face| {
            is_met = meet(t, face) < tmax;
            (tmax, is_met)
        };
        #[allow(unsafe_code, reason = "there are blocks: the machine has AVX2")]
        unsafe {
            self.traverse(ray, meet);
        }
        is_met
    }

    /// Distance and number of the nearest face for which `meet` returns its distance and not infinity.
    pub(super) fn nearest(
        &self,
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
            self.traverse(ray, meet);
        }
        found
    }

    /// `meet` returns where the ray ends from now on, and whether to stop.
    #[target_feature(enable = "avx2,bmi1,lzcnt,popcnt")]
    fn traverse(&self, ray: &Ray, mut meet: impl FnMut(f32, usize) -> (f32, bool)) {
        if self.nodes.is_empty() {
            return;
        }
        let mut lanes = Lanes::new(ray);
        let octant = octant(ray);
        let (mut stack, mut waiting) = ([(0u32, 0u32); DEEPEST], 0);
        // First child, which of them were hit, and above these bits which there are: the root is the one child of nothing.
        let mut group = (0u32, 1u32 << (LANES - 1));
        loop {
            let child = (group.1 & ALL).ilog2();
            group.1 &= !(1 << child);
            if group.1 & ALL != 0 {
                stack[waiting] = group;
                waiting += 1;
            }
            let slot = child ^ octant as u32;
            let before = (group.1 >> LANES & !(u32::MAX << slot)).count_ones();
            let node = &self.nodes[(group.0 + before) as usize];
            let hits = lanes.hits(node);
            let mut leaves = hits & !node.inner;
            if leaves != 0 {
                let mut triangles = 0;
                while leaves != 0 {
                    triangles |= node.triangles[leaves.trailing_zeros() as usize % LANES];
                    leaves &= leaves - 1;
                }
                for block in (0..3).rev() {
                    let wanted = triangles >> (block * LANES) & ALL;
                    if wanted == 0 {
                        continue;
                    }
                    let (distances, met) = lanes.meets(&self.blocks[node.blocks as usize + block]);
                    let mut met = met & wanted;
                    while met != 0 {
                        let lane = met.ilog2() as usize;
                        met &= !(1 << lane);
                        let face = node.faces as usize + block * LANES + lane;
                        let (end, stop) = meet(lane_of(distances, lane), face);
                        if stop {
                            return;
                        }
                        lanes.tmax = _mm256_set1_ps(end);
                    }
                }
            }
            let nodes = IN_ORDER[octant][(hits & node.inner) as usize];
            group = (node.children, u32::from(nodes) | node.inner << LANES);
            if nodes == 0 {
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
        size_of_val::<[Block]>(&self.blocks) + size_of_val::<[Node]>(&self.nodes)
    }
}

/// Which way a ray goes, as the tree numbers octants: children with this number are nearest.
fn octant(ray: &Ray) -> usize {
    let bit = |axis: usize, bit: usize| if ray.direction[axis] < 0.0 { 0 } else { bit };
    bit(0, 4) | bit(1, 2) | bit(2, 1)
}

/// Triangles of a child, a bit each from the node's first; 0 for nodes and where there is no child.
fn triangles_of(meta: u8) -> u32 {
    if is_node(meta) {
        return 0;
    }
    u32::from(meta >> 5) << (meta & 0b11111)
}

/// Triangles of a node: those of its leaves follow each other.
fn triangle_count(node: &CwBvhNode) -> usize {
    let all = node
        .child_meta
        .iter()
        .fold(0, |all, &meta| all | triangles_of(meta));
    (u32::BITS - all.leading_zeros()) as usize
}

fn is_node(meta: u8) -> bool {
    meta & 0b11000 == 0b11000
}

impl Node {
    #[target_feature(enable = "avx2")]
    fn new(node: &CwBvhNode, blocks: usize) -> Self {
        let steps = [
            [node.child_min_x, node.child_max_x],
            [node.child_min_y, node.child_max_y],
            [node.child_min_z, node.child_max_z],
        ];
        let size = node.compute_extent();
        let end = |axis: usize, side: usize, child: usize| {
            if node.child_meta[child] == 0 {
                // No child: a box that ends before it begins.
                return if side == 0 {
                    f32::INFINITY
                } else {
                    f32::NEG_INFINITY
                };
            }
            let exact = f64::from(node.p[axis])
                + f64::from(steps[axis][side][child]) * f64::from(size[axis]);
            let end = exact as f32;
            match side {
                0 if f64::from(end) > exact => end.next_down(),
                1 if f64::from(end) < exact => end.next_up(),
                _ => end,
            }
        };
        let ends = |axis: usize, side: usize| {
            let [a, b, c, d, e, f, g, h] = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| end(axis, side, i));
            _mm256_setr_ps(a, b, c, d, e, f, g, h)
        };
        Self {
            ends: [0, 1, 2].map(|axis| [ends(axis, 0), ends(axis, 1)]),
            triangles: node.child_meta.map(triangles_of),
            inner: node.imask.into(),
            children: node.child_base_idx,
            blocks: blocks as u32,
            faces: node.primitive_base_idx,
        }
    }
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
            normal: vectors(|face| face.normal),
        }
    }
}

impl Lanes {
    #[target_feature(enable = "avx2")]
    fn new(ray: &Ray) -> Self {
        let all = |vector: Vec3A| vector.to_array().map(|of_axis| _mm256_set1_ps(of_axis));
        Self {
            origin: all(ray.origin),
            direction: all(ray.direction),
            inverse: all(ray.inv_direction),
            tmin: _mm256_set1_ps(ray.tmin),
            tmax: _mm256_set1_ps(ray.tmax),
            against: [0, 1, 2].map(|axis| usize::from(ray.direction[axis] < 0.0)),
        }
    }

    /// Which children of a node the ray hits.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn hits(&self, node: &Node) -> u32 {
        // Where it enters and leaves the slabs between the ends of an axis.
        let span = |axis: usize| {
            let first = self.against[axis];
            [first, 1 - first].map(|side| {
                let to_end = _mm256_sub_ps(node.ends[axis][side], self.origin[axis]);
                _mm256_mul_ps(to_end, self.inverse[axis])
            })
        };
        let (x, y, z) = (span(0), span(1), span(2));
        let near = _mm256_max_ps(x[0], _mm256_max_ps(y[0], z[0]));
        let near = _mm256_max_ps(near, _mm256_set1_ps(NEAREST));
        let far = _mm256_min_ps(x[1], _mm256_min_ps(y[1], z[1]));
        let far = _mm256_min_ps(far, self.tmax);
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32
    }

    /// Distances to the triangles of a block, and which of them it meets (Möller & Trumbore 1997).
    #[inline]
    #[target_feature(enable = "avx2")]
    fn meets(&self, block: &Block) -> (__m256, u32) {
        let Block {
            corner,
            edge1,
            edge2,
            normal,
        } = block;
        let to_corner = [0, 1, 2].map(|axis| _mm256_sub_ps(corner[axis], self.origin[axis]));
        let across = cross(&self.direction, &to_corner);
        let determinant = dot(normal, &self.direction);
        let (zero, one) = (_mm256_setzero_ps(), _mm256_set1_ps(1.0));
        let inverse = _mm256_div_ps(one, determinant);
        let u = _mm256_mul_ps(dot(&across, edge2), inverse);
        let v = _mm256_mul_ps(dot(&across, edge1), inverse);
        let t = _mm256_mul_ps(dot(normal, &to_corner), inverse);
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
