//! Invariants of every loaded scene.

use gobo::scene::{Alpha, AlphaMode, AlphaTexture, Caster, Light, Mesh, Particle, Scene, Splat, Strand, View};

fn all_finite(numbers: &[f32]) -> bool {
    numbers.iter().all(|number| number.is_finite())
}

/// Asserts that a loaded scene keeps the promises of its types, and that lights and cameras can be fitted to it.
pub fn assert_valid(scene: &Scene) {
    scene.particles.iter().for_each(particle);
    scene.strands.iter().for_each(strand);
    scene.splats.iter().for_each(splat);
    scene.casters().iter().for_each(caster);
    scene.volumes.iter().for_each(|volume| assert!(!volume.cells().is_empty(), "{:?}", volume.placed()));
    scene.meshes.iter().for_each(mesh);
    assert!(!scene.lights.is_empty(), "no light");
    scene.lights.iter().for_each(light);
    assert!(!scene.name.chars().any(char::is_control), "name {:?}", scene.name);
    view(&View::camera(&scene.camera, scene, [16, 9]));
    View::volumes(scene, 16).iter().chain(&View::opaques(scene, 16)).for_each(view);
}

fn particle(particle: &Particle) {
    assert!(all_finite(&particle.position), "{particle:?}");
    assert!(particle.radius.is_finite() && particle.radius > 0.0, "{particle:?}");
    assert!(particle.extinction.is_finite() && particle.extinction >= 0.0, "{particle:?}");
}

fn strand(strand: &Strand) {
    assert!(all_finite(&strand.start) && all_finite(&strand.end) && strand.start != strand.end, "{strand:?}");
    assert!(strand.radius.is_finite() && strand.radius > 0.0, "{strand:?}");
    assert!((0.0..=1.0).contains(&strand.opacity), "{strand:?}");
}

fn splat(splat: &Splat) {
    assert!(all_finite(&splat.position), "{splat:?}");
    assert!(splat.deviations.iter().all(|d| d.is_finite() && *d > 0.0), "{splat:?}");
    assert!((splat.rotation.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5, "{splat:?}");
    assert!(splat.color.iter().all(|c| (0.0..=1.0).contains(c)), "{splat:?}");
    assert!((0.0..=1.0).contains(&splat.opacity), "{splat:?}");
    assert!(Caster::from(splat).is_splat(), "{splat:?}");
}

fn caster(caster: &Caster) {
    assert!(caster.density.is_finite() && caster.radius.is_finite() && caster.radius > 0.0, "{caster:?}");
    assert!(all_finite(&caster.axis), "{caster:?}");
    assert!((0.0..=80.0).contains(&caster.density) || !caster.is_strand(), "{caster:?}");
}

fn mesh(mesh: &Mesh) {
    assert!(mesh.positions.iter().all(|position| all_finite(position)), "{}", mesh.name);
    assert!(mesh.triangles.iter().flatten().all(|index| (*index as usize) < mesh.positions.len()), "{}", mesh.name);
    assert!(mesh.albedo.iter().all(|channel| (0.0..=1.0).contains(channel)), "{:?}", mesh.albedo);
    assert!(!mesh.name.chars().any(char::is_control), "name {:?}", mesh.name);
    mesh.alpha.iter().for_each(|of| alpha(of, mesh.positions.len()));
}

fn alpha(alpha: &Alpha, vertices: usize) {
    assert!(!matches!(alpha.mode, AlphaMode::Cut(cutoff) if !(cutoff > 0.0 && cutoff <= 1.0)), "{:?}", alpha.mode);
    assert_eq!(alpha.factors.len(), vertices);
    assert!(alpha.factors.iter().all(|factor| (0.0..=1.0).contains(factor)), "{:?}", alpha.factors);
    assert!(alpha.uvs.iter().all(|uv| all_finite(uv)), "{:?}", alpha.uvs);
    assert_eq!(alpha.uvs.len(), if alpha.texture.is_some() { vertices } else { 0 });
    let Some(texture) = &alpha.texture else { return };
    let [width, height] = texture.size;
    assert!([width, height].iter().all(|side| (1..=AlphaTexture::MOST_SIDE).contains(side)), "{width} × {height}");
    assert_eq!(texture.texels.len(), width as usize * height as usize);
}

fn light(light: &Light) {
    assert!(light.radiance.iter().all(|channel| channel.is_finite() && *channel >= 0.0), "{light:?}");
    assert!(light.radius > 0.0, "{light:?}");
    let towards = light.towards(glam::DVec3::new(0.3, 0.2, 0.1));
    assert!(towards.is_finite() && towards.length() < 1.001, "{light:?}");
}

fn view(view: &View) {
    let axes = [view.right, view.up, view.forward];
    assert!(axes.iter().all(|axis| (glam::Vec3::from(*axis).length() - 1.0).abs() < 1e-5), "{view:?}");
    assert!(all_finite(&view.origin), "{view:?}");
    assert!(all_finite(&[view.scale_x, view.scale_y, view.near, view.far]) && view.near < view.far, "{view:?}");
}
