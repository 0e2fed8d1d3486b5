//! Tables that are whole, broken, and the thesis's own.

use std::{
    fs,
    path::{Path, PathBuf},
};

use proptest::prelude::{any, prop, proptest};
use shared::pattern::Corner;

use super::{ShiftTableError, read_appendix_c, read_shift_table, write_shift_table};

fn appendix_c() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/recorded/appendix-c.csv")
}

fn table_with(text: &str) -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("shifts.csv");
    fs::write(&path, text).unwrap();
    (dir, path)
}

#[test]
fn appendix_c_holds_400_vertices_of_the_cube_and_390_of_the_cylinder() {
    let cube = read_appendix_c(&appendix_c(), "cube").unwrap();
    let cylinder = read_appendix_c(&appendix_c(), "cylinder").unwrap();
    assert_eq!((cube.len(), cylinder.len()), (400, 390));
    let first = cube[0];
    assert_eq!(
        (first.corner, first.x_px, first.y_px),
        (Corner::UpperLeft, 51.0, 22.0)
    );
    assert_eq!(first.depth, 9.32);
}

#[test]
fn a_depth_of_9_43_in_appendix_c_is_a_shift_of_11_rows_and_9_columns() {
    let rows = read_appendix_c(&appendix_c(), "cube").unwrap();
    let row = rows.iter().find(|row| row.depth == 9.43).unwrap();
    assert!((row.shift_px - 202_f64.sqrt()).abs() < 0.01, "{row:?}");
}

#[test]
fn a_table_read_back_is_the_one_written() {
    let (_dir, path) = table_with("");
    let rows = read_appendix_c(&appendix_c(), "cylinder").unwrap();
    write_shift_table(&path, &rows).unwrap();
    let back = read_shift_table(&path).unwrap();
    assert_eq!(back.len(), rows.len());
    for (a, b) in rows.iter().zip(&back) {
        assert_eq!(
            (a.corner, a.index, a.x_px, a.depth),
            (b.corner, b.index, b.x_px, b.depth)
        );
        assert!((a.shift_px - b.shift_px).abs() <= 0.5e-4);
    }
}

#[test]
fn an_error_names_file_line_and_column() {
    let (_dir, path) = table_with(
        "vertex,row,column,x_px,y_px,shift_px,depth\nUPPER_LEFT,0,0,1,2,3,4\nUPPER_LEFT,0,1,1,far,3,4\n",
    );
    let message = read_shift_table(&path).unwrap_err().to_string();
    for part in ["shifts.csv", "line 3", "\"y_px\"", "\"far\""] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn a_missing_column_an_unknown_vertex_and_a_number_without_end_are_refused() {
    let (_dir, path) = table_with("vertex,row,column,x_px,y_px,depth\n");
    assert!(matches!(
        read_shift_table(&path),
        Err(ShiftTableError::MissingColumn {
            column: "shift_px",
            ..
        })
    ));
    for line in [
        "MIDDLE,0,0,1,2,3,4",
        "UPPER_LEFT,0,0,1,2,inf,4",
        "UPPER_LEFT,-1,0,1,2,3,4",
    ] {
        let (_dir, path) = table_with(&format!(
            "vertex,row,column,x_px,y_px,shift_px,depth\n{line}\n"
        ));
        assert!(matches!(
            read_shift_table(&path),
            Err(ShiftTableError::Field { line: 2, .. })
        ));
    }
}

#[test]
fn an_object_that_is_not_in_the_table_is_refused_with_those_that_are() {
    let error = read_appendix_c(&appendix_c(), "cone").unwrap_err();
    assert!(error.to_string().contains("cube, cylinder"), "{error}");
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("broken.csv");
        fs::write(&path, [b"vertex,row,column,x_px,y_px,shift_px,depth,object\n", &bytes[..]].concat()).unwrap();
        let _read = read_shift_table(&path);
        let _read = read_appendix_c(&path, "cube");
    }
}
