//! The files of a comparison, written row by row.

use crate::bench::{Observer, Results, Row, RowPictures, TimedBuilds, difference_srgb8};
use crate::cli::output::progress::Progress;
use crate::report::Store;
use crate::scene::Picture;
use crate::technique::Spec;
use crate::{Error, Result};

/// Writes files until the first failure and none after it, so that measuring continues and the table is printed.
pub(in crate::cli) struct Writer<'a> {
    store: &'a Store,
    pub progress: Progress,
    /// Rows with their timed builds, for a trace.
    pub traced: Option<Vec<(Row, TimedBuilds)>>,
    /// The failure after which nothing more is written.
    pub failed: Option<Error>,
    /// The first error that ended a scene: if one scene does not fit on the device, the others are still measured.
    pub ended: Option<Error>,
}

impl<'a> Writer<'a> {
    /// Writes into `store`, and shows the progress of `rows` rows.
    pub fn new(store: &'a Store, rows: usize, traces: bool) -> Self {
        let (progress, traced) = (Progress::new(rows), traces.then(Vec::new));
        Self { store, progress, traced, failed: None, ended: None }
    }

    pub fn write(&mut self, write: impl FnOnce(&Store) -> Result<()>) {
        if self.failed.is_none() {
            self.failed = write(self.store).err();
        }
    }

    /// Writes a row's picture, numbered by the row's place among its scene's rows, and its difference from the truth.
    /// The first call also writes the truth itself and, if it was traced, the bounce of light.
    fn pictures(&mut self, row: &mut Row, pictures: &RowPictures) {
        let RowPictures { number: place, drawn, before, .. } = *pictures;
        // A row that was kept from an earlier run, in another order, may already have that number.
        let number = (place..).find(|n| before.rows.iter().all(|r| r.picture != Some(picture_name(row, *n, ""))));
        let [name, difference] = ["", "-difference"].map(|suffix| picture_name(row, number.unwrap_or(place), suffix));
        self.write(|store| write_picture(store, &name, &drawn.picture, &drawn.picture.to_srgb8()));
        row.picture = Some(name);
        let (Some(beside), Some(reference)) = (&drawn.beside_truth, pictures.reference) else { return };
        self.write(|store| write_picture(store, &difference, beside, &difference_srgb8(beside, reference)));
        row.difference = Some(difference);
        if before.rows.iter().all(|r| r.scene != row.scene || r.difference.is_none()) {
            let name = format!("{}-reference.png", row.scene);
            self.write(|store| write_picture(store, &name, reference, &reference.to_srgb8()));
            if let Some(bounce) = pictures.bounce {
                let name = format!("{}-bounce.png", row.scene);
                self.write(|store| write_picture(store, &name, bounce, &bounce.to_srgb8()));
            }
        }
    }
}

impl Observer for Writer<'_> {
    fn row_begins(&mut self, scene: &str, spec: &Spec) {
        self.progress.begins(scene, spec);
    }

    fn row_is_drawn(&mut self, row: &mut Row, pictures: &RowPictures) {
        if let Some(traced) = &mut self.traced {
            traced.push((row.clone(), pictures.drawn.builds.clone()));
        }
        self.pictures(row, pictures);
    }

    fn row_ends(&mut self, row: &Row, spec: &Spec, results: &Results) -> Result<()> {
        self.progress.ends(row, spec);
        self.write(|store| store.write(results));
        Ok(())
    }

    fn scene_fails(&mut self, error: Error) -> Result<()> {
        self.ended.get_or_insert(error);
        Ok(())
    }
}

/// Returns SCENE-NN-TECHNIQUE.png.
pub(in crate::cli) fn picture_name(row: &Row, number: usize, suffix: &str) -> String {
    format!("{}-{number:02}-{}{suffix}.png", row.scene, row.technique)
}

fn write_picture(store: &Store, name: &str, picture: &Picture, rgb8: &[u8]) -> Result<()> {
    store.write_picture(name, picture.width, picture.height, rgb8)
}
