//! Render paths, image comparison and command line of sheen.
//!
//! The binary `sheen` only calls [`cli::run`]; everything else is here so that tests reach it.

mod app;
pub mod bench;
pub mod camera;
pub mod cli;
pub mod compare;
pub mod gpu;
pub mod memory;
pub mod panels;
pub mod passes;
pub mod script;
pub mod steering;
pub mod tonemap;
pub mod verify;
pub mod ways;
pub mod window;
