//! The laboratory: runs models, watches them, writes what they return.
