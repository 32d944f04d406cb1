//! A checksum that shows whether two runs used the same scene.

use crate::scene::Scene;

impl Scene {
    /// Returns a checksum of the bits of all casters, lights and the camera, without the name. Two different scenes are very unlikely to
    /// share a checksum.
    pub fn fingerprint(&self) -> u32 {
        self.fingerprint_with("Still")
    }

    /// Like [`Scene::fingerprint`], but for a scene whose motion is described by `motion`.
    pub(crate) fn fingerprint_with(&self, motion: &str) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(bytemuck::cast_slice(&self.particles));
        for strand in &self.strands {
            hasher.update(bytemuck::bytes_of(&[strand.start, strand.end, [strand.radius, strand.opacity, 0.0]]));
        }
        for g in &self.splats {
            hasher.update(bytemuck::bytes_of(&[g.position, g.deviations, g.color]));
            hasher.update(bytemuck::bytes_of(&[g.rotation, [g.opacity, 0.0, 0.0, 0.0]]));
        }
        for mesh in &self.meshes {
            hasher.update(bytemuck::cast_slice(&mesh.positions));
            hasher.update(bytemuck::cast_slice(&mesh.triangles));
            hasher.update(bytemuck::bytes_of(&mesh.albedo));
            hasher.update(&[u8::from(mesh.solid)]);
            if let Some(alpha) = &mesh.alpha {
                hasher.update(format!("{:?}", alpha.mode).as_bytes());
                hasher.update(bytemuck::cast_slice(&alpha.factors));
                hasher.update(bytemuck::cast_slice(&alpha.uvs));
                if let Some(texture) = &alpha.texture {
                    hasher.update(format!("{:?} {:?}", texture.size, texture.wrap).as_bytes());
                    hasher.update(&texture.texels);
                }
            }
        }
        let counts = [self.particles.len(), self.strands.len(), self.meshes.len()];
        if !self.splats.is_empty() {
            hasher.update(&(self.splats.len() as u64).to_le_bytes());
        }
        for volume in &self.volumes {
            hasher.update(format!("{:?}", volume.placed()).as_bytes());
            volume.field().hash(&mut hasher);
        }
        if self.extinction_ratio != Self::GREY {
            hasher.update(bytemuck::bytes_of(&self.extinction_ratio));
        }
        if !self.inks.is_empty() {
            hasher.update(format!("{:?}", self.inks).as_bytes());
        }
        // `{:?}` prints different floats as different texts.
        hasher.update(format!("{counts:?} {:?} {:?} {motion}", self.lights, self.camera).as_bytes());
        hasher.finalize()
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::ExtinctionGroup;
    use crate::scene::tests::on_the_axis;

    #[test]
    fn another_scene_has_another_fingerprint() {
        let scene = || on_the_axis(&[(0.0, 1.0, 0.5), (1.0, 1.0, 0.5)]);
        assert_eq!(scene().fingerprint(), scene().fingerprint());
        let all = [
            on_the_axis(&[(0.0, 1.0, 0.5)]),
            on_the_axis(&[(1.0, 1.0, 0.5), (0.0, 1.0, 0.5)]),
            on_the_axis(&[(0.0, 1.0, 0.5), (1.0, 1.0, 0.5000001)]),
            {
                let mut other = scene();
                other.camera.fov_y_degrees += 1e-12;
                other
            },
            {
                let mut other = scene();
                other.lights[0].radiance[2] = 0.5;
                other
            },
            {
                let mut other = scene();
                other.extinction_ratio[1] = 0.5;
                other
            },
            {
                let mut other = scene();
                other.inks.push(ExtinctionGroup { casters: 2, ratio: [1.0, 0.5, 0.0] });
                other
            },
        ];
        for other in all {
            assert_ne!(other.fingerprint(), scene().fingerprint(), "{other:?}");
        }
    }
}
