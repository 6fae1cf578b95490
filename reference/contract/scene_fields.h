/// The fields of a scene's small records, in the order of captures and fingerprints.
#pragma once

namespace scotty::reference {

/// Calls f(field) for each field of a Material.
template <class Material, class F>
void for_each_material_field(Material& m, F&& f) {
    f(m.kind);
    f(m.reflectance);
    f(m.transmittance);
    f(m.ior);
    f(m.emission);
    f(m.emission_is_sampled);
}

/// The same for a Light.
template <class Light, class F>
void for_each_light_field(Light& light, F&& f) {
    f(light.kind);
    f(light.position);
    f(light.edge_x);
    f(light.edge_y);
    f(light.normal);
    f(light.radiance);
    f(light.area);
}

/// The same for a Camera. Fingerprints leave out the width where it is 0, so that scenes without it
/// keep the ones that were recorded of them.
template <class Camera, class F>
void for_each_camera_field(Camera& camera, F&& f, bool with_width = true) {
    f(camera.position);
    f(camera.right);
    f(camera.up);
    f(camera.forward);
    f(camera.tan_half_fov);
    if (with_width) f(camera.tan_half_width);
}

}  // namespace scotty::reference
