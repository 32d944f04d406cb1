//! The files of a comparison, written row after row.

use crate::bench::{CasePictures, Results, Row, SceneCase, difference_srgb8};
use crate::report::Store;
use crate::scene::Picture;
use crate::{Error, Result};

/// Writes files until the first failure, and none after it, so that the measuring goes on and the table is printed.
pub(in crate::cli) struct Writer<'a> {
    pub store: &'a Store,
    /// The failure after which nothing more is written.
    pub failed: Option<Error>,
}

impl Writer<'_> {
    pub fn write(&mut self, write: impl FnOnce(&Store) -> Result<()>) {
        if self.failed.is_none() {
            self.failed = write(self.store).err();
        }
    }

    /// Writes a row's picture, numbered by the row's place among its scene's rows, and its difference from the truth.
    /// The truth itself is written the first time, and the bounce of light too, where it was traced.
    pub fn pictures(&mut self, row: &mut Row, place: usize, results: &Results, case: &SceneCase, drawn: &CasePictures) {
        // A row that was kept from an earlier run, in another order, may already have that number.
        let number = (place..).find(|n| results.rows.iter().all(|r| r.picture != Some(picture_name(row, *n, ""))));
        let [name, difference] = ["", "-difference"].map(|suffix| picture_name(row, number.unwrap_or(place), suffix));
        self.write(|store| write_picture(store, &name, &drawn.picture, &drawn.picture.to_srgb8()));
        row.picture = Some(name);
        let (Some(beside), Some(reference)) = (&drawn.beside_truth, case.reference()) else { return };
        self.write(|store| write_picture(store, &difference, beside, &difference_srgb8(beside, reference)));
        row.difference = Some(difference);
        if results.rows.iter().all(|r| r.scene != row.scene || r.difference.is_none()) {
            let name = format!("{}-reference.png", row.scene);
            self.write(|store| write_picture(store, &name, reference, &reference.to_srgb8()));
            if let Some(traced) = case.traced() {
                let name = format!("{}-bounce.png", row.scene);
                self.write(|store| write_picture(store, &name, traced, &traced.to_srgb8()));
            }
        }
    }
}

/// SCENE-NN-TECHNIQUE.png
pub(in crate::cli) fn picture_name(row: &Row, number: usize, suffix: &str) -> String {
    format!("{}-{number:02}-{}{suffix}.png", row.scene, row.technique)
}

fn write_picture(store: &Store, name: &str, picture: &Picture, rgb8: &[u8]) -> Result<()> {
    store.write_picture(name, picture.width, picture.height, rgb8)
}
