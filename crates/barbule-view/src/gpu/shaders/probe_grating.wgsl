@fragment
fn fs_probe(@builtin(position) pixel: vec4f) -> @location(0) vec4u {
    let question = probe_question(pixel);
    let wi = question.first.xyz;
    let wo = question.second.xyz;
    if question.name.w == 1u {
        return bitcast<vec4u>(vec4f(grating_colour(wi, wo), 1.0));
    }
    let nm = question.first.w;
    let f = grating_value(grating_seen(wi, wo), nm, 6283.185307179586 / nm);
    return bitcast<vec4u>(vec4f(f, 0.0, grating_albedo(wi, nm), 1.0));
}
