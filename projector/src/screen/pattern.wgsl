// Draws a pattern pixel for pixel: no filtering, no blending, bytes in = bytes out.
//
// A pixel shows the colour of the column line that covers it, else of the row line, else the field colour.
// Which line covers a pixel along each axis, and in which colour, is computed once on the CPU by the same
// code that reads the pattern, and stored in two one-dimensional textures (alpha 1 = line, 0 = no line).
// Pictures that are not made of lines come as one texel per pixel.

struct Picture {
    field: vec4<f32>,
    // 1: lines over the field colour, 0: one texel per pixel
    lines: u32,
};

@group(0) @binding(0) var<uniform> picture: Picture;
@group(0) @binding(1) var columns: texture_2d<f32>;
@group(0) @binding(2) var rows: texture_2d<f32>;
@group(0) @binding(3) var texels: texture_2d<f32>;

// One triangle that covers the whole target; no vertex buffer.
@vertex
fn whole_target(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    let x = f32(i32(corner & 1u) * 4 - 1);
    let y = f32(i32(corner >> 1u) * 4 - 1);
    return vec4<f32>(x, y, 0.0, 1.0);
}

// The texel of a profile for a pixel. An empty profile has one texel without a line, for every pixel.
fn along(profile: texture_2d<f32>, pixel: i32) -> vec2<i32> {
    return vec2<i32>(min(pixel, i32(textureDimensions(profile).x) - 1), 0);
}

// The position is at pixel centres (x + 1/2, y + 1/2), counted from the upper left.
@fragment
fn colour(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(floor(position.xy));
    if (picture.lines == 0u) {
        return vec4<f32>(textureLoad(texels, pixel, 0).rgb, 1.0);
    }
    let column = textureLoad(columns, along(columns, pixel.x), 0);
    if (column.a > 0.5) {
        return vec4<f32>(column.rgb, 1.0);
    }
    let row = textureLoad(rows, along(rows, pixel.y), 0);
    if (row.a > 0.5) {
        return vec4<f32>(row.rgb, 1.0);
    }
    return vec4<f32>(picture.field.rgb, 1.0);
}
