//! Tests of the reader of XYZ text.

use super::read;
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

proptest! {
    #[test]
    fn every_separator_and_line_end_is_read(
        points in proptest::collection::vec(proptest::array::uniform3(-1e9f64..1e9), 1..40),
        separator in prop_oneof![Just(" "), Just(","), Just(";"), Just("\t"), Just(", "), Just(" ; ")],
        end in prop_oneof![Just("\n"), Just("\r\n"), Just(" # why\n"), Just(" 0.5 7\n\n")],
    ) {
        let mut text = String::from("# a cloud\n");
        for [x, y, z] in &points {
            text += &format!("{x}{separator}{y}{separator}{z}{end}");
        }
        let cloud = read(text.as_bytes()).expect("well-formed text");
        prop_assert_eq!(cloud.points, points.into_iter().map(Point3::from).collect::<Vec<_>>());
    }
}

#[test]
fn column_names_on_the_first_line_are_skipped() {
    let cloud = read(b"X,Y,Z,intensity\n1,2,3,9\nnan,nan,nan,0\n").expect("a table");
    assert_eq!(cloud.points.len(), 2);
    assert_eq!(cloud.points[0], Point3::new(1.0, 2.0, 3.0));
}

#[test]
fn prose_and_short_lines_are_errors() {
    let cases: [(&[u8], &str); 5] = [
        (
            b"It was a dark and stormy night.\n",
            "XYZ text line 1: expected a number for x, got \"It\"",
        ),
        (
            b"1 2 3\n\n4 5\n",
            "XYZ text line 3: expected a number for z, got the end of the line",
        ),
        (
            b"# nothing\n#\n",
            "XYZ text line 2: expected at least one point, got comments only",
        ),
        (
            b"1 2 3\nx y z\n",
            "XYZ text line 2: expected a number for x, got \"x\"",
        ),
        (
            b"\x00\xff\n",
            "XYZ text line 1: expected a number for x, got \"\\0\u{fffd}\"",
        ),
    ];
    for (bytes, message) in cases {
        assert_eq!(read(bytes).expect_err(message).to_string(), message);
    }
}

fn points(text: &str) -> Vec<Point3<f64>> {
    read(text.as_bytes()).expect(text).points
}

#[test]
fn columns_stand_where_their_names_say() {
    let expected = [Point3::new(1.5, -2.0, 3.0), Point3::new(4.0, 5.0, 6.25)];
    for text in [
        ",x,y,z\n0,1.5,-2,3\n1,4,5,6.25\n",
        "z,name,Y,X\n3,a,-2,1.5\n6.25,b,5,4\n",
        "\"x\",\"y\",\"z\"\n1.5,-2,3\n4,5,6.25\n",
        "X [m],Y [m],Z [m],I\n1.5,-2,3,\n4,5,6.25,9\n",
        "X [mm]\tY [mm]\tZ [mm]\n1500\t-2000\t3000\n4000\t5000\t6250\n",
        "x;y;z\n1,5;-2;3\n4;5;6,25\n",
        ";x;y;z\n0;1.5;-2;3\n1;4;5;6.25\n",
        "//X Y Z R G B\n2\n1.5 -2 3 0 0 0\n4 5 6.25 0 0 0\n",
        "# z y x\n3 -2 1.5\n6.25 5 4\n",
        "Points:0,Points:1,Points:2\n1.5,-2,3\n4,5,6.25\n",
        "x,y,z\n1.5 -2 3\n4 5 6.25\n",
    ] {
        assert_eq!(points(text), expected, "{text}");
    }
}

#[test]
fn names_within_prose_are_no_columns() {
    let text = "# a cloud with x y z\n1 2 3\n";
    assert_eq!(points(text), [Point3::new(1.0, 2.0, 3.0)]);
    let text = "# x y z in metres\n1 2 3 4\n";
    assert_eq!(points(text), [Point3::new(1.0, 2.0, 3.0)]);
}

#[test]
fn named_normals_are_read() {
    let cloud = read(b"Nx,Ny,Nz,x,y,z\n0,0,1,1,2,3\n").expect("a table");
    assert_eq!(cloud.normals, Some(vec![Vector3::new(0.0, 0.0, 1.0)]));
    assert_eq!(cloud.points, [Point3::new(1.0, 2.0, 3.0)]);
}

#[test]
fn decimal_commas_are_told_from_separators() {
    let expected = [Point3::new(3.5, -4.25, 0.5)];
    assert_eq!(points("3,5;-4,25;0,5\n"), expected);
    assert_eq!(points("3,5 -4,25 0,5\n"), expected);
    assert_eq!(points("3,5\t-4,25\t0,5\n"), expected);
    assert_eq!(points("3.5,-4.25,0.5\n"), expected);
    assert_eq!(points("3.5, -4.25, 0.5\n"), expected);
    assert_eq!(points("3.5;-4.25;0.5\n"), expected);
    // Thousands are no decimals.
    let error = read(b"\"3,500.0\",\"1\",\"2\"\n").expect_err("thousands");
    assert!(error.to_string().ends_with("got \"3,500.0\""), "{error}");
}

#[test]
fn a_number_of_points_in_front_is_held_to() {
    assert_eq!(points("2\n1 2 3 9\n4 5 6 9\n").len(), 2);
    assert_eq!(points("1\n1 2 3\n2\n4 5 6\n7 8 9\n").len(), 3);
    let message = |text: &str| read(text.as_bytes()).expect_err(text).to_string();
    assert_eq!(
        message("3\n1 2 3\n4 5 6\n"),
        "XYZ text line 3: expected as many points as announced, got the end of the file, 1 short"
    );
    assert_eq!(
        message("1\n1 2 3\n4 5 6\n"),
        "XYZ text line 3: expected no more points than announced, got \"4 5 6\""
    );
    assert!(message("3\nwater\nO 0 0 0\n").starts_with("XYZ text line 2: expected a number"));
}

#[test]
fn an_empty_cell_is_no_number() {
    assert_eq!(
        read(b"1,,3\n").expect_err("two numbers").to_string(),
        "XYZ text line 1: expected a number for y, got \"\""
    );
}

#[test]
fn comments_and_blanks_of_other_tools_are_passed_over() {
    let text = "% from matlab\n; from a machine\n// from C\n1\u{a0}2\u{a0}\u{a0}3\n";
    assert_eq!(points(text), [Point3::new(1.0, 2.0, 3.0)]);
    let lost = points("1 2 3\n-nan(ind) 1.#QNAN NA\n");
    assert!(lost[1].iter().all(|c| c.is_nan()));
    assert_eq!(points("1.5D+00 2 3\n")[0].x, 1.5);
}
