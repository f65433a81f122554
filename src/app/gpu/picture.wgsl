// Draws a float picture: finds the value under each pixel of the screen, then its colour.
// The arithmetic of the colour is that of `Display::colour`; a test holds the two against each other.

struct Uniforms {
    origin_px: vec2f,          // a place of the framebuffer ...
    anchor_picture: vec2f,     // ... and the place of the picture that is shown there
    backdrop: vec3f,           // what a dimmed picture fades towards
    picture_px_per_px: f32,    // pixels of the picture in one pixel of the screen
    size: vec2u,               // columns, rows
    tile: vec2u,               // columns, rows of one array layer at level 0
    tiles_across: u32,
    level: u32,                // the level to read
    lut_row: u32,              // the colour map
    flags: u32,                // 1: diverging map, 2: the target converts from linear light, 4: means are drawn
    range_min: f32,
    range_scale: f32,          // 1 / (max - min)
    exponent: f32,             // 1 / gamma
    dim: f32,                  // 0: as it is, 1: dimmed
}

@group(0) @binding(0) var<uniform> uniforms: Uniforms;
@group(0) @binding(1) var picture: texture_2d_array<f32>;
@group(0) @binding(2) var lut: texture_2d<f32>;

// One triangle that covers the viewport.
@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
}

// Compilers may assume that there is no NaN; they leave bits alone.
fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
}

// The value of a cell of the level that is read.
fn load(cell: vec2u) -> f32 {
    let tile = uniforms.tile >> vec2u(uniforms.level);
    let place = cell / tile;
    let layer = place.y * uniforms.tiles_across + place.x;
    return textureLoad(picture, cell - place * tile, layer, i32(uniforms.level)).r;
}

// The mean over the part of the picture that one pixel of the screen covers; `edge` is counted from the picture's upper
// left corner.
fn average(edge: vec2f) -> vec2f {
    let cell_size = f32(1u << uniforms.level);
    let half_width = 0.5 * uniforms.picture_px_per_px;
    let end = vec2f(uniforms.size);
    let low = clamp(edge - half_width, vec2f(0.0), end) / cell_size;
    let high = clamp(edge + half_width, vec2f(0.0), end) / cell_size;
    let last = (uniforms.size - 1u) >> vec2u(uniforms.level);
    let first = min(vec2u(low), last);
    let stop = min(vec2u(ceil(high)), last + 1u);
    var sum = 0.0;
    var weight = 0.0;
    for (var y = first.y; y < stop.y; y += 1u) {
        let wy = min(high.y, f32(y + 1u)) - max(low.y, f32(y));
        for (var x = first.x; x < stop.x; x += 1u) {
            let wx = min(high.x, f32(x + 1u)) - max(low.x, f32(x));
            let value = load(vec2u(x, y));
            if !is_nan(value) {
                sum += wx * wy * value;
                weight += wx * wy;
            }
        }
    }
    return vec2f(sum, weight);
}

fn colour_at(position: f32) -> vec3f {
    let x = position * 255.0;
    let i = min(u32(x), 254u);
    let a = textureLoad(lut, vec2u(i, uniforms.lut_row), 0).rgb;
    let b = textureLoad(lut, vec2u(i + 1u, uniforms.lut_row), 0).rgb;
    return mix(a, b, x - f32(i));
}

fn power(x: f32) -> f32 {
    if x <= 0.0 {
        return 0.0;
    }
    return pow(x, uniforms.exponent);
}

fn colour_of(value: f32) -> vec3f {
    let t = clamp((value - uniforms.range_min) * uniforms.range_scale, 0.0, 1.0);
    if (uniforms.flags & 1u) != 0u {
        let signed_distance = 2.0 * t - 1.0;
        return colour_at(0.5 + 0.5 * sign(signed_distance) * power(abs(signed_distance)));
    }
    return colour_at(power(t));
}

fn linear_of_srgb(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

@fragment
fn fs_main(@builtin(position) framebuffer: vec4f) -> @location(0) vec4f {
    let place = uniforms.anchor_picture + (framebuffer.xy - uniforms.origin_px) * uniforms.picture_px_per_px;
    // The centre of the first pixel is (0, 0), its corner (-0.5, -0.5).
    let edge = place + 0.5;
    if any(edge < vec2f(0.0)) || any(edge >= vec2f(uniforms.size)) {
        return vec4f(0.0);
    }
    var colour = vec3f(1.0, 0.0, 1.0);
    // Mesa's software driver compiles the shader anew, and keeps it, for each value of a uniform that alone decides a
    // branch: so branches ask only for flags, which have few values, and not for the zoom itself.
    if (uniforms.flags & 4u) == 0u {
        let value = load(min(vec2u(edge), uniforms.size - 1u));
        if !is_nan(value) {
            colour = colour_of(value);
        }
    } else {
        let mean = average(edge);
        if mean.y > 0.0 {
            colour = colour_of(mean.x / mean.y);
        }
    }
    let luma = dot(colour, vec3f(0.2126, 0.7152, 0.0722));
    colour = mix(colour, vec3f(luma), 0.7 * uniforms.dim);
    colour = mix(colour, uniforms.backdrop, 0.45 * uniforms.dim);
    if (uniforms.flags & 2u) != 0u {
        colour = linear_of_srgb(colour);
    }
    return vec4f(colour, 1.0);
}
