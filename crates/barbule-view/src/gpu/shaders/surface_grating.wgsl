// Surfaces that are gratings; their undersides are keratin. Goes with waves.wgsl, grating.wgsl, keratin.wgsl and surface.wgsl.

@fragment
fn fs_surface(surface: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let local = local_of(surface, is_front, 0.0);
    if is_front {
        let f = grating_colour(local.to_eye, local.to_lamp);
        return light_of(local, f, grating_albedo_colour(local.to_eye));
    }
    let f = keratin_colour(dress.keratins[0], local.to_eye, local.to_lamp);
    return light_of(local, f, keratin_albedo_colour(dress.keratins[0], local.to_eye));
}
