// Surfaces that are gratings; their undersides are keratin. Goes with waves.wgsl, grating.wgsl, keratin.wgsl and surface.wgsl.

@fragment
fn fs_surface(surface: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let local = local_of(surface, is_front, 0.0);
    if is_front {
        return light_of(local, grating_colour(local.to_eye, local.to_lamp), grating_albedo_colour(local.to_eye));
    }
    return keratin_light(local);
}
