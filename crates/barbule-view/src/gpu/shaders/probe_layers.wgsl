@fragment
fn fs_probe(@builtin(position) pixel: vec4f) -> @location(0) vec4u {
    let question = probe_question(pixel);
    let wi = question.first.xyz;
    let wo = question.second.xyz;
    if question.name.w == 1u {
        return bitcast<vec4u>(vec4f(layers_colour(wi, wo), 1.0));
    }
    // The wavelengths of the tables are asked by their numbers.
    let wave = u32(question.first.w);
    return bitcast<vec4u>(vec4f(layers_value(wi, wo, wave), 0.0, layers_albedo(wi, wave), 1.0));
}
