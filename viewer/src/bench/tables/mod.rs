//! Tables 1 to 4 of Stamminger et al. 2000: their figures beside ours.

mod basis;
mod methods;
mod run;
mod sum;

pub use basis::{GLOSSY_ROOM, basis};
pub use methods::{Tables, TablesError, methods};
pub use run::Case;
pub use sum::{LAMP_GRIDS, sum};
