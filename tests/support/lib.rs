//! Helpers for the tests of whole programs.
