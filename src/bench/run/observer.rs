//! Observers of a run: what writes its files and shows its progress.

use crate::bench::{CasePictures, Results, Row};
use crate::scene::Picture;
use crate::technique::Spec;
use crate::{Error, Result};

/// Hears of rows as they are measured.
pub trait Observer {
    /// A row begins.
    fn row_begins(&mut self, _scene: &str, _spec: &Spec) {}

    /// A row has drawn its pictures. Their files' names may be written into the row.
    fn row_is_drawn(&mut self, _row: &mut Row, _pictures: &RowPictures) {}

    /// A row has ended, and is among `results`.
    ///
    /// # Errors
    /// An error ends the scene, as in [`Observer::scene_fails`].
    fn row_ends(&mut self, _row: &Row, _spec: &Spec, _results: &Results) -> Result<()> {
        Ok(())
    }

    /// A scene has ended in an error, for example because it does not fit on the device.
    ///
    /// # Errors
    /// An error ends the run; without one, the next scene follows.
    fn scene_fails(&mut self, error: Error) -> Result<()> {
        Err(error)
    }
}

/// For a run whose results alone matter.
impl Observer for () {}

/// The pictures of a row.
pub struct RowPictures<'a> {
    /// The row's place among its scene's rows, from 1.
    pub number: usize,
    /// Those that the row drew.
    pub drawn: &'a CasePictures,
    /// The picture that the truth lights; none where no picture was compared with it.
    pub reference: Option<&'a Picture>,
    /// One bounce of light, where the picture was compared with it.
    pub bounce: Option<&'a Picture>,
    /// The results without the row.
    pub before: &'a Results,
}
