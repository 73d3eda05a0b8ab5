//! mgf
