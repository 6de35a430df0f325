//! Tests of the shading functions against integrals and closed forms: energy, normalisation, attenuation, extreme
//! normals.

use super::*;

fn surface(metallic: f32, roughness: f32, to_viewer: Vec3) -> Surface {
    Surface {
        position: Vec3::ZERO,
        normal: Vec3::Y,
        to_viewer: to_viewer.normalize(),
        base_color: Vec3::ONE,
        metallic,
        roughness,
        occlusion: 1.0,
        emissive: Vec3::ZERO,
    }
}

/// Returns directions of a midpoint grid over the hemisphere around y, with their solid angles.
fn hemisphere(steps: u32) -> impl Iterator<Item = (Vec3, f32)> {
    let cell = 2.0 * PI / (steps * 4 * steps) as f32;
    (0..steps * 4 * steps).map(move |k| {
        let (y, azimuth) = ((k % steps) as f32 + 0.5, (k / steps) as f32 + 0.5);
        let (y, azimuth) = (y / steps as f32, azimuth * 2.0 * PI / (4 * steps) as f32);
        let radius = (1.0 - y * y).sqrt();
        (Vec3::new(radius * azimuth.cos(), y, radius * azimuth.sin()), cell)
    })
}

#[test]
fn a_furnace_never_gets_brighter() {
    for metallic in [0.0, 1.0] {
        for roughness in [0.3, 0.6, 1.0] {
            for to_viewer in [Vec3::Y, Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 0.1, 0.0)] {
                let surface = surface(metallic, roughness, to_viewer);
                let out: f32 = hemisphere(200).map(|(light, angle)| reflect_light(&surface, light).x * angle).sum();
                // The grid's own error is 1e-3.
                assert!(out <= 1.002, "{metallic} {roughness} {to_viewer}: {out}");
                assert!(out > 0.25, "{metallic} {roughness} {to_viewer}: {out}");
            }
        }
    }
}

#[test]
fn the_highlight_distribution_covers_the_plane_once() {
    for roughness in [0.4f32, 0.7, 1.0] {
        let alpha = roughness * roughness;
        let covered: f32 = hemisphere(400).map(|(h, angle)| distribution_ggx(h.y, alpha) * h.y * angle).sum();
        assert!((covered - 1.0).abs() < 1e-2, "{roughness}: {covered}");
    }
}

#[test]
fn matte_surroundings_are_the_integral_of_their_radiance() {
    for normal in [Vec3::Y, Vec3::X, Vec3::NEG_Y, Vec3::new(1.0, 1.0, 0.0).normalize()] {
        let sphere = hemisphere(300).flat_map(|(d, angle)| [(d, angle), (-d, angle)]);
        let radiance = |d: Vec3| if d.y > 0.0 { SKY + OVERHEAD * d.y } else { GROUND };
        let mean: f32 = sphere.map(|(d, angle)| radiance(d) * d.dot(normal).max(0.0) * angle / PI).sum();
        assert!((mean - surroundings_matte(normal.y)).abs() < 3e-3, "{normal}: {mean}");
    }
    for k in 0..=200 {
        let y = k as f32 / 100.0 - 1.0;
        let phase = 2.0 / (3.0 * PI) * ((1.0 - y * y).sqrt() + (PI - y.acos()) * y);
        let exact = mix(GROUND, SKY, 0.5 + 0.5 * y) + OVERHEAD * phase;
        assert!((surroundings_matte(y) - exact).abs() < 2e-4 * OVERHEAD, "{y}");
    }
}

#[test]
fn a_white_matte_floor_under_one_lux_shows_one_over_pi() {
    let light = PosedLight {
        kind: LightKind::Directional,
        color: Vec3::ONE,
        position: Default::default(),
        direction: crate::space::SceneVector(Vec3::NEG_Y),
        range: f32::INFINITY,
    };
    let surface = surface(0.0, 1.0, Vec3::new(1.0, 0.5, 0.0));
    let matte = light_surface(&surface, &Light::from(&light)).x;
    // 0.96 / pi of the diffuse layer, and a little specular reflection.
    assert!((matte - 0.96 / PI).abs() < 0.02, "{matte}");
}

#[test]
fn lights_end_at_their_range_and_cone() {
    let light = |kind, range| {
        Light::from(&PosedLight {
            kind,
            color: Vec3::splat(8.0),
            position: crate::space::ScenePoint(Vec3::new(0.0, 2.0, 0.0)),
            direction: crate::space::SceneVector(Vec3::NEG_Y),
            range,
        })
    };
    let at = |light: Light, x: f32| arrive(&light, Vec3::new(x, 0.0, 0.0)).illuminance.x;
    assert!((at(light(LightKind::Point, f32::INFINITY), 0.0) - 2.0).abs() < 1e-6);
    assert_eq!(at(light(LightKind::Point, 2.0), 0.0), 0.0);
    let spot = light(LightKind::Spot { inner: 0.2, outer: 0.5 }, f32::INFINITY);
    assert!((at(spot, 0.0) - 2.0).abs() < 1e-6);
    assert_eq!(at(spot, 2.0 * 0.55f32.tan()), 0.0);
    let half = at(spot, 2.0 * 0.35f32.tan());
    assert!(half > 0.1 && half < 1.9, "{half}");
}

#[test]
fn normals_without_length_or_tangent_stay_finite() {
    let flat = shading_normal(Vec3::ZERO, Vec4::ZERO, Vec3::ZERO, false);
    assert!(flat.is_finite() && (flat.length() - 1.0).abs() < 1e-6);
    let bent = shading_normal(Vec3::Z * 3.0, Vec4::new(2.0, 0.0, 1.0, -1.0), Vec3::new(0.0, 1.0, 0.0), true);
    assert!((bent - Vec3::NEG_Y).length() < 1e-6, "{bent}");
}

#[test]
fn a_light_fills_the_shaders_rows() {
    assert_eq!(size_of::<Light>(), 64);
}
