//! Render paths and command line of sheen.
