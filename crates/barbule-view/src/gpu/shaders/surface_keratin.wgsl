// Surfaces of keratin on both sides. Goes with keratin.wgsl and surface.wgsl.

@fragment
fn fs_surface(surface: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return keratin_light(local_of(surface, is_front, 0.0));
}
