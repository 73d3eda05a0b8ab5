//! Builders, tolerances and image differences that the integration tests share.
