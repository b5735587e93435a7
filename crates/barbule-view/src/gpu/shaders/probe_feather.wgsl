@fragment
fn fs_probe(@builtin(position) pixel: vec4f) -> @location(0) vec4u {
    let question = probe_question(pixel);
    let wi = question.first.xyz;
    let wo = question.second.xyz;
    var draw = feather_mean();
    if question.name.z == 1u {
        draw = feather_draw(question.name.xy);
    }
    if question.name.w == 1u {
        return bitcast<vec4u>(vec4f(feather_colour(wi, wo, draw, 1.0), 1.0));
    }
    let wave = feather_wave(question.first.w);
    let values = feather_values(feather_seen(wi, wo), wave, draw);
    var albedo = 0.0;
    if wi.z > 0.0 {
        albedo = feather_albedo(feather_light(wi), wave);
    }
    return bitcast<vec4u>(vec4f(values, albedo, 1.0));
}
