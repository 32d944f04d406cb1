//! Casters that attenuate red, green and blue light in different ratios. Each light is then listed three times, once per color, so that
//! every light has a single color; a caster has one extinction for each color.

use crate::scene::{Caster, Light, Mesh, Reserve, Scene};
use crate::{Error, Result};

/// Red, green and blue.
const COLORS: usize = 3;

/// Consecutive casters that attenuate red, green and blue light in the same ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtinctionGroup {
    /// Number of casters in the group. Groups follow each other in the order of [`Scene::casters`].
    pub casters: usize,
    /// Factors of the casters' extinction for red, green and blue light: in [0, 1], not all 0.
    pub ratio: [f32; 3],
}

impl Scene {
    /// Returns the scene with these inks for its casters but see-through triangles, in the order of [`Scene::casters`]; the inks of those
    /// are in the meshes' alpha. If all casters have the same ratio and none is a see-through triangle of a color, it becomes the scene's
    /// [`Scene::extinction_ratio`]. Otherwise each light is listed three times: first all lights in red, then all in green, then all in
    /// blue, each keeping only that channel of its radiance.
    ///
    /// # Errors
    /// [`Error::Input`] if the scene already has inks or a ratio of its own, if the inks cover fewer or more casters than the scene has, if
    /// they split a volume, or if a ratio is out of range; [`Error::Refused`] if the scene is animated.
    pub fn with_inks(mut self, inks: &[ExtinctionGroup]) -> Result<Self> {
        if !self.inks.is_empty() || self.extinction_ratio != Self::GREY {
            return Err(self.wrong_inks("its casters have ratios of extinctions already".into()));
        }
        let inks: Vec<ExtinctionGroup> = inks.iter().copied().filter(|ink| ink.casters > 0).collect();
        let (given, count) =
            (inks.iter().map(|ink| ink.casters).sum::<usize>(), self.first_sheet() + self.cell_count());
        if given != count {
            return Err(
                self.wrong_inks(format!("inks of {given} casters, and it has {count} beside see-through triangles"))
            );
        }
        let first = inks.first().map_or(Self::GREY, |ink| ink.ratio);
        let sheets = self.sheet_inks();
        let is_one = sheets.iter().all(|ink| ink.ratio == Self::GREY && ink.ratio == first);
        if is_one && inks.iter().all(|ink| ink.ratio == first) {
            if !is_ratio(first, f32::MAX) {
                return Err(self.wrong_inks(format!("extinctions {first:?} are not finite, below 0 or all 0")));
            }
            self.extinction_ratio = first;
            return Ok(self);
        }
        self.inks = with_sheets(&inks, self.first_sheet(), &sheets);
        if self.reserve != Reserve::default() {
            let needs = "a scene that stands still: the number of casters of each extinction ratio may not change";
            return Err(Error::Refused(needs.into()));
        }
        let of_color = |light: &Light, color: usize| {
            let mut radiance = [0.0; COLORS];
            radiance[color] = light.radiance[color];
            Light { radiance, ..*light }
        };
        let lights = (0..COLORS).flat_map(|color| self.lights.iter().map(move |light| of_color(light, color)));
        self.lights = lights.collect();
        self.check_inks().map(|()| self)
    }

    /// Like [`Scene::with_inks`], with casters that absorb all colors alike beside see-through triangles of a color, if there are any.
    #[cfg(feature = "program")]
    pub(in crate::scene) fn with_tints(self) -> Result<Self> {
        let casters = self.first_sheet() + self.cell_count();
        if self.is_tinted() { self.with_inks(&[ExtinctionGroup { casters, ratio: Self::GREY }]) } else { Ok(self) }
    }

    /// Returns whether see-through triangles absorb some colors more than others.
    pub(crate) fn is_tinted(&self) -> bool {
        self.sheet_inks().iter().any(|ink| ink.ratio != Self::GREY)
    }

    /// Returns the inks of see-through triangles.
    fn sheet_inks(&self) -> Vec<ExtinctionGroup> {
        let of = |mesh: &Mesh| {
            let alpha = mesh.alpha.as_ref().filter(|_| mesh.is_see_through() && !mesh.triangles.is_empty())?;
            Some(ExtinctionGroup { casters: mesh.triangles.len(), ratio: alpha.extinction_ratio })
        };
        self.meshes.iter().filter_map(of).collect()
    }

    /// Checks that inks, casters and lights are as [`Scene::with_inks`] leaves them.
    ///
    /// # Errors
    /// [`Error::Input`] if they are not.
    pub(crate) fn check_inks(&self) -> Result<()> {
        if self.inks.is_empty() {
            return Ok(());
        }
        if self.extinction_ratio != Self::GREY {
            return Err(self.wrong_inks("its casters have one ratio and several".into()));
        }
        if self.inks.iter().any(|ink| ink.casters == 0) {
            return Err(self.wrong_inks("an ink of no casters".into()));
        }
        if let Some(ink) = self.inks.iter().find(|ink| !is_ratio(ink.ratio, 1.0)) {
            let cause = format!("extinctions {:?} of an ink are not from 0 to 1, or are all 0", ink.ratio);
            return Err(self.wrong_inks(cause));
        }
        let each = self.lights.len() / COLORS;
        let kinds = |light: usize| (self.lights[light].kind, self.lights.get(light + each).map(|light| light.kind));
        let is_one = |(light, all): (usize, &Light)| {
            (0..COLORS).all(|color| color == light / each || all.radiance[color] == 0.0)
        };
        let is_thrice = each * COLORS == self.lights.len()
            && (0..each * 2).map(kinds).all(|(a, b)| Some(a) == b)
            && self.lights.iter().enumerate().all(is_one);
        if !is_thrice {
            return Err(self.wrong_inks("its lights do not stand once per color".into()));
        }
        self.holds_inks()
    }

    /// Checks that the inks cover exactly the scene's casters, are those of see-through meshes, and do not split volumes.
    fn holds_inks(&self) -> Result<()> {
        let mut end = self.first_cell();
        let (given, count) = (self.inks.iter().map(|ink| ink.casters).sum::<usize>(), end + self.cell_count());
        if given != count {
            return Err(self.wrong_inks(format!("inks of {given} casters, and it has {count}")));
        }
        let sheets = self.sheet_inks();
        let mut meant = sheets.iter().flat_map(|ink| std::iter::repeat_n(ink.ratio, ink.casters));
        if !self.ink_ratios().skip(self.first_sheet()).take(self.sheet_count()).all(|ratio| meant.next() == Some(ratio))
        {
            return Err(self.wrong_inks("inks of see-through triangles that are not those of their alpha".into()));
        }
        let ends = self.inks.iter().scan(0, |end, ink| {
            *end += ink.casters;
            Some(*end)
        });
        let ends: Vec<usize> = ends.collect();
        for volume in &self.volumes {
            let begin = end;
            end += volume.cells().len();
            if ends.iter().any(|ink| (begin + 1..end).contains(ink)) {
                return Err(self.wrong_inks("an ink ends within a volume".into()));
            }
        }
        Ok(())
    }

    fn wrong_inks(&self, cause: String) -> Error {
        Error::input(
            self.name.clone(),
            cause,
            "give each caster one ratio of extinctions from 0 to 1, and each volume one",
        )
    }

    /// Returns how many times each light is listed in the scene: 3 if it has inks, otherwise 1.
    pub fn colors(&self) -> usize {
        if self.inks.is_empty() { 1 } else { COLORS }
    }

    /// Returns the color of a light if the scene has inks, from 0 for red to 2 for blue; otherwise 0.
    pub fn color_of_light(&self, light: usize) -> usize {
        let colors = self.colors();
        (light / (self.lights.len() / colors).max(1)).min(colors - 1)
    }

    /// Like [`Scene::color_of_light`], but for the light that owns a map.
    #[cfg(feature = "program")]
    pub(crate) fn color_of_map(&self, map: usize) -> usize {
        let colors = self.colors();
        (map / (self.map_count() / colors).max(1)).min(colors - 1)
    }

    /// Returns the casters as seen by light of one color ([`Scene::color_of_light`]): [`Scene::casters`], each with its extinction for that
    /// color.
    pub fn casters_of(&self, color: usize) -> Vec<Caster> {
        self.in_color(self.casters(), 0, color)
    }

    /// Applies the extinctions for a color to casters that begin at index `first`.
    pub(crate) fn in_color(&self, mut casters: Vec<Caster>, first: usize, color: usize) -> Vec<Caster> {
        casters
            .iter_mut()
            .zip(self.ink_ratios().skip(first))
            .for_each(|(caster, ratio)| caster.density *= ratio[color]);
        casters
    }

    /// Returns the ratio of each caster. Casters after the last ink absorb all colors alike; a scene from [`Scene::with_inks`] has none.
    pub(crate) fn ink_ratios(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        let all = self.inks.iter().flat_map(|ink| std::iter::repeat_n(ink.ratio, ink.casters));
        all.chain(std::iter::repeat(Self::GREY))
    }

    /// Returns the ratio of each volume.
    pub(crate) fn volume_ratios(&self) -> Vec<[f32; 3]> {
        if self.inks.is_empty() {
            return vec![Self::GREY; self.volumes.len()];
        }
        let mut ratios = self.ink_ratios().skip(self.first_cell());
        let mut of = |cells: usize| {
            let first = ratios.next().unwrap_or(Self::GREY);
            ratios.by_ref().take(cells.saturating_sub(1)).for_each(drop);
            first
        };
        self.volumes.iter().map(|volume| of(volume.cells().len())).collect()
    }
}

/// Returns the inks with those of the `sheets` before caster `first`.
fn with_sheets(inks: &[ExtinctionGroup], first: usize, sheets: &[ExtinctionGroup]) -> Vec<ExtinctionGroup> {
    let (mut before, mut after) = (Vec::new(), Vec::new());
    let mut begin = 0;
    for ink in inks {
        let here = first.saturating_sub(begin).min(ink.casters);
        before.push(ExtinctionGroup { casters: here, ..*ink });
        after.push(ExtinctionGroup { casters: ink.casters - here, ..*ink });
        begin += ink.casters;
    }
    let all = before.iter().chain(sheets).chain(&after);
    all.copied().filter(|ink| ink.casters > 0).collect()
}

fn is_ratio(ratio: [f32; 3], most: f32) -> bool {
    ratio.iter().all(|factor| (0.0..=most).contains(factor)) && ratio != [0.0; 3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::on_the_axis;

    const RED: [f32; 3] = [0.25, 1.0, 1.0];
    const BLUE: [f32; 3] = [1.0, 0.5, 0.0];

    fn two() -> Scene {
        let mut scene = on_the_axis(&[(0.0, 0.5, 2.0), (1.0, 0.5, 4.0), (2.0, 0.5, 8.0)]);
        scene.lights[0].radiance = [0.5, 1.0, 2.0];
        let mut other = scene.lights[0];
        other.radiance = [4.0, 0.0, 8.0];
        scene.lights.push(other);
        scene
    }

    #[test]
    fn lights_stand_once_per_color() {
        let scene = two()
            .with_inks(&[ExtinctionGroup { casters: 1, ratio: RED }, ExtinctionGroup { casters: 2, ratio: BLUE }])
            .expect("inks");
        let radiances: Vec<_> = scene.lights.iter().map(|light| light.radiance).collect();
        let expected =
            [[0.5, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, 8.0]];
        assert_eq!(radiances, expected);
        assert_eq!((0..6).map(|light| scene.color_of_light(light)).collect::<Vec<_>>(), [0, 0, 1, 1, 2, 2]);
        let densities = |color| scene.casters_of(color).iter().map(|caster| caster.density).collect::<Vec<_>>();
        assert_eq!([densities(0), densities(1), densities(2)], [[0.5, 4.0, 8.0], [2.0, 2.0, 4.0], [2.0, 0.0, 0.0]]);
    }

    #[test]
    fn inks_of_one_ratio_are_a_color() {
        let same = ExtinctionGroup { casters: 1, ratio: [2.0, 1.0, 0.5] };
        let scene = two()
            .with_inks(&[same, ExtinctionGroup { casters: 0, ratio: RED }, ExtinctionGroup { casters: 2, ..same }])
            .expect("one");
        assert_eq!((scene.extinction_ratio, scene.inks.len(), scene.lights.len()), (same.ratio, 0, 2));
        let grey = two().with_inks(&[ExtinctionGroup { casters: 3, ratio: Scene::GREY }]).expect("grey");
        assert_eq!(grey, two());
    }

    #[test]
    fn what_does_not_go_with_inks_is_one_line() {
        let (red, blue) = (ExtinctionGroup { casters: 1, ratio: RED }, ExtinctionGroup { casters: 2, ratio: BLUE });
        let told = |scene: Scene, inks: &[ExtinctionGroup]| scene.with_inks(inks).expect_err("refused").to_string();
        let moving = Scene { reserve: Reserve { particles: 4, ..Reserve::default() }, ..two() };
        let inked = || two().with_inks(&[red, blue]).expect("inks");
        for (found, words) in [
            (told(two(), &[red]), "inks of 1 casters, and it has 3"),
            (told(two(), &[red, ExtinctionGroup { ratio: [1.0, 1.5, 0.0], ..blue }]), "not from 0 to 1"),
            (told(two(), &[red, ExtinctionGroup { ratio: [0.0; 3], ..blue }]), "all 0"),
            (told(two(), &[red, ExtinctionGroup { ratio: [f32::NAN, 1.0, 1.0], ..blue }]), "not from 0 to 1"),
            (told(two(), &[ExtinctionGroup { casters: 3, ratio: [-1.0, 1.0, 1.0] }]), "below 0"),
            (told(two(), &[ExtinctionGroup { casters: 3, ratio: [0.0; 3] }]), "all 0"),
            (told(two(), &[ExtinctionGroup { casters: 3, ratio: [f32::INFINITY, 1.0, 1.0] }]), "not finite"),
            (told(moving, &[red, blue]), "stands still"),
            (told(inked(), &[red, blue]), "already"),
        ] {
            assert!(found.contains(words) && !found.contains('\n'), "{found}");
        }
    }

    #[test]
    fn what_with_inks_would_not_make_is_found() {
        let (red, blue) = (ExtinctionGroup { casters: 1, ratio: RED }, ExtinctionGroup { casters: 2, ratio: BLUE });
        let good = two().with_inks(&[red, blue]).expect("inks");
        good.check_inks().expect("as it was made");
        let damaged = |damage: fn(&mut Scene)| {
            let mut scene = good.clone();
            damage(&mut scene);
            scene.check_inks().expect_err("found").to_string()
        };
        for (found, words) in [
            (damaged(|scene| scene.lights.truncate(1)), "once per color"),
            (damaged(|scene| scene.lights.push(scene.lights[0])), "once per color"),
            (damaged(|scene| scene.lights.truncate(3)), "once per color"),
            (damaged(|scene| scene.particles.truncate(2)), "inks of 3 casters, and it has 2"),
            (damaged(|scene| scene.particles.clear()), "it has 0"),
            (damaged(|scene| scene.inks.push(ExtinctionGroup { casters: 0, ..scene.inks[0] })), "an ink of no casters"),
            (damaged(|scene| scene.extinction_ratio = RED), "one ratio and several"),
            (damaged(|scene| scene.inks[0].ratio = [f32::NAN; 3]), "not from 0 to 1"),
        ] {
            assert!(found.contains(words), "{found}");
        }
    }
}
