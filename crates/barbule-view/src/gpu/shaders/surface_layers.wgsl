// Surfaces with layers on them; their undersides are keratin. Goes with waves.wgsl, layers.wgsl, keratin.wgsl and surface.wgsl.

@fragment
fn fs_surface(surface: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let local = local_of(surface, is_front, 0.0);
    if is_front {
        return light_of(local, layers_colour(local.to_eye, local.to_lamp), layers_albedo_colour(local.to_eye));
    }
    return keratin_light(local);
}
