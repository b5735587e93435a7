@fragment
fn fs_probe(@builtin(position) pixel: vec4f) -> @location(0) vec4u {
    let question = probe_question(pixel);
    return bitcast<vec4u>(vec4f(tone_shown(question.first.xyz, question.second.x > 0.5), 1.0));
}
