// Packed directional distributions: the twin of `packed::evaluate` and `octahedron` in sheen-solver.
// Needs a global `words: array<u32>`.

// Bits of a node word that are the position of its group.
const POSITION: u32 = 0x001fffffu;
// Deepest subdivision that a distribution may have (`packed::MAX_DEPTH`).
const MAX_DEPTH: u32 = 16u;

fn decode_rgb9e5(word: u32) -> vec3<f32> {
    // Exponent bias 15, mantissa of 9 bits: one step is 2^(e - 24).
    let step = bitcast<f32>(((word >> 27u) + 103u) << 23u);
    return vec3<f32>(f32(word & 511u), f32((word >> 9u) & 511u), f32((word >> 18u) & 511u)) * step;
}

// True when `direction` lies on `corner`'s side of the great circle through `m` and `n`.
fn is_beyond(m: vec3<f32>, n: vec3<f32>, corner: vec3<f32>, direction: vec3<f32>) -> bool {
    let normal = cross(m, n);
    let side = dot(normal, direction);
    return select(side, -side, dot(normal, corner) < 0.0) > 0.0;
}

fn barycentric(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    var weights = vec3<f32>(
        dot(direction, cross(b, c)),
        dot(direction, cross(c, a)),
        dot(direction, cross(a, b)),
    );
    weights = select(weights, -weights, dot(a, cross(b, c)) < 0.0);
    weights = max(weights, vec3<f32>(0.0));
    let sum = weights.x + weights.y + weights.z;
    if sum > 0.0 {
        return weights / sum;
    }
    return vec3<f32>(1.0 / 3.0);
}

// Corner of the tetrahedron that the uniform basis subdivides.
fn tetrahedron_corner(corner: u32) -> vec3<f32> {
    // Corner 0 has no sign, the others have two.
    let same = vec3<bool>(corner < 2u, corner == 0u || corner == 2u, corner == 0u || corner == 3u);
    return select(vec3<f32>(-0.57735026), vec3<f32>(0.57735026), same);
}

// Number of the vertex of a face with the integer barycentric coordinates `at`, which sum to 2^level.
fn uniform_vertex(face: u32, at: vec3<u32>, level: u32) -> u32 {
    let inside = (1u << level) - 1u;
    let is_zero = at == vec3<u32>(0u);
    // The others of the tetrahedron's corners in their order.
    let corner = vec3<u32>(0u, 1u, 2u) + select(vec3<u32>(0u), vec3<u32>(1u), vec3<u32>(0u, 1u, 2u) >= vec3<u32>(face));
    if is_zero.y && is_zero.z {
        return corner.x;
    }
    if is_zero.x && is_zero.z {
        return corner.y;
    }
    if is_zero.x && is_zero.y {
        return corner.z;
    }
    if any(is_zero) {
        var low = corner.x;
        var high = corner.z;
        var steps = at.z;
        if is_zero.z {
            high = corner.y;
            steps = at.y;
        } else if is_zero.x {
            low = corner.y;
        }
        let edge = select(select(5u, high + 1u, low == 1u), high - 1u, low == 0u);
        return 4u + edge * inside + steps - 1u;
    }
    let before = (at.x - 1u) * inside - at.x * (at.x - 1u) / 2u + at.y - 1u;
    return 4u + 6u * inside + face * (inside * (inside - 1u) / 2u) + before;
}

// The same on the uniform basis: the twin of `uniform::evaluate`.
fn evaluate_uniform(start: u32, direction: vec3<f32>) -> vec3<f32> {
    let level = min(words[start + 1u], MAX_DEPTH);
    var face = 0u;
    var lowest = dot(tetrahedron_corner(0u), direction);
    for (var corner = 1u; corner < 4u; corner++) {
        let height = dot(tetrahedron_corner(corner), direction);
        if height < lowest {
            face = corner;
            lowest = height;
        }
    }
    var a = tetrahedron_corner(select(0u, 1u, face == 0u));
    var b = tetrahedron_corner(select(1u, 2u, face <= 1u));
    var c = tetrahedron_corner(select(2u, 3u, face <= 2u));
    let side = 1u << level;
    var at_a = vec3<u32>(side, 0u, 0u);
    var at_b = vec3<u32>(0u, side, 0u);
    var at_c = vec3<u32>(0u, 0u, side);
    for (var depth = 0u; depth < level; depth++) {
        let m12 = normalize(b + c);
        let m20 = normalize(c + a);
        let m01 = normalize(a + b);
        let at_m12 = (at_b + at_c) / 2u;
        let at_m20 = (at_c + at_a) / 2u;
        let at_m01 = (at_a + at_b) / 2u;
        if is_beyond(m01, m20, a, direction) {
            b = m01;
            c = m20;
            at_b = at_m01;
            at_c = at_m20;
        } else if is_beyond(m01, m12, b, direction) {
            a = m01;
            c = m12;
            at_a = at_m01;
            at_c = at_m12;
        } else if is_beyond(m20, m12, c, direction) {
            a = m20;
            b = m12;
            at_a = at_m20;
            at_b = at_m12;
        } else {
            a = m12;
            b = m20;
            c = m01;
            at_a = at_m12;
            at_b = at_m20;
            at_c = at_m01;
        }
    }
    let weights = barycentric(a, b, c, direction);
    let first = start + 2u;
    let colour = decode_rgb9e5(words[first + uniform_vertex(face, at_a, level)]) * weights.x
        + decode_rgb9e5(words[first + uniform_vertex(face, at_b, level)]) * weights.y
        + decode_rgb9e5(words[first + uniform_vertex(face, at_c, level)]) * weights.z;
    return colour * -bitcast<f32>(words[start]);
}

// Colour at the midpoint of an edge of a node: one of those that start at `first`, or the mean of the edge's ends.
fn midpoint_colour(first: u32, stored_mask: u32, midpoint: u32, a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    if (stored_mask & (1u << midpoint)) == 0u {
        return (a + b) * 0.5;
    }
    return decode_rgb9e5(words[first + countOneBits(extractBits(stored_mask, 0u, midpoint))]);
}

// Radiance of the distribution that starts at `words[start]`, towards `direction` (unit, leaving the surface).
fn evaluate_distribution(start: u32, direction: vec3<f32>) -> vec3<f32> {
    if (words[start] >> 31u) != 0u {
        return evaluate_uniform(start, direction);
    }
    let scale = bitcast<f32>(words[start]);
    let negative = direction < vec3<f32>(0.0);
    let octant = select(0u, 1u, negative.x) | select(0u, 2u, negative.y) | select(0u, 4u, negative.z);
    var node = words[start + 1u + octant];
    var a = vec3<f32>(select(1.0, -1.0, negative.x), 0.0, 0.0);
    var b = vec3<f32>(0.0, select(1.0, -1.0, negative.y), 0.0);
    var c = vec3<f32>(0.0, 0.0, select(1.0, -1.0, negative.z));
    // Colours at the corners.
    let axes = start + 9u;
    var colour_a = decode_rgb9e5(words[axes + select(0u, 3u, negative.x)]);
    var colour_b = decode_rgb9e5(words[axes + select(1u, 4u, negative.y)]);
    var colour_c = decode_rgb9e5(words[axes + select(2u, 5u, negative.z)]);
    for (var depth = 0u; depth <= MAX_DEPTH; depth++) {
        if node == 0u {
            break;
        }
        let position = start + (node & POSITION);
        let split_mask = extractBits(node, 24u, 4u);
        let first = position + countOneBits(split_mask);
        let stored_mask = extractBits(node, 21u, 3u);
        let colour_m12 = midpoint_colour(first, stored_mask, 0u, colour_b, colour_c);
        let colour_m20 = midpoint_colour(first, stored_mask, 1u, colour_c, colour_a);
        let colour_m01 = midpoint_colour(first, stored_mask, 2u, colour_a, colour_b);
        let m12 = normalize(b + c);
        let m20 = normalize(c + a);
        let m01 = normalize(a + b);
        var child = 3u;
        if is_beyond(m01, m20, a, direction) {
            child = 0u;
            b = m01;
            c = m20;
            colour_b = colour_m01;
            colour_c = colour_m20;
        } else if is_beyond(m01, m12, b, direction) {
            child = 1u;
            a = m01;
            c = m12;
            colour_a = colour_m01;
            colour_c = colour_m12;
        } else if is_beyond(m20, m12, c, direction) {
            child = 2u;
            a = m20;
            b = m12;
            colour_a = colour_m20;
            colour_b = colour_m12;
        } else {
            a = m12;
            b = m20;
            c = m01;
            colour_a = colour_m12;
            colour_b = colour_m20;
            colour_c = colour_m01;
        }
        if (node & (1u << (28u + child))) != 0u {
            let weights = barycentric(a, b, c, direction);
            return (colour_a * weights.x + colour_b * weights.y + colour_c * weights.z) * scale;
        }
        if (split_mask & (1u << child)) == 0u {
            break;
        }
        node = words[position + countOneBits(extractBits(split_mask, 0u, child))];
    }
    return vec3<f32>(0.0);
}
