//! What a scan leaves behind: tables that other programs can read.

pub mod shift_table;
