//! Columns by their names: coordinates and normals of a PLY, a PCD or a table, in any order and case.

/// Names of the coordinates, lower case, each with those that other tools give it (ParaView, CloudCompare, ROS).
const COORDINATES: [[&str; 5]; 3] = [
    ["x", "points:0", "points_0", "x_coordinate", "position_x"],
    ["y", "points:1", "points_1", "y_coordinate", "position_y"],
    ["z", "points:2", "points_2", "z_coordinate", "position_z"],
];
/// Names of the components of a normal, lower case.
const NORMALS: [[&str; 5]; 3] = [
    ["nx", "normal_x", "normals:0", "normals_0", "normal.x"],
    ["ny", "normal_y", "normals:1", "normals_1", "normal.y"],
    ["nz", "normal_z", "normals:2", "normals_2", "normal.z"],
];
/// Units that a column may state in brackets after its name, and their length in metres.
const UNITS_M: [(&str, f64); 8] = [
    ("m", 1.0),
    ("metre", 1.0),
    ("metres", 1.0),
    ("meter", 1.0),
    ("meters", 1.0),
    ("cm", 0.01),
    ("mm", 0.001),
    ("km", 1000.0),
];

/// Which columns hold what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Columns {
    /// Indices of x y z.
    pub(super) xyz: [usize; 3],
    /// Indices of the components of the normal.
    pub(super) normal: Option<[usize; 3]>,
    /// Length of the unit of x y z, metres.
    pub(super) unit_m: [f64; 3],
}

impl Columns {
    /// The first three columns are x y z, in metres.
    pub(super) const IN_ORDER: Self = Self {
        xyz: [0, 1, 2],
        normal: None,
        unit_m: [1.0; 3],
    };

    /// Finds the columns of a point among `names`; `None` marks one that can be none. Exact names come before those of other
    /// tools, and of two with one name the first counts. `None` without all of x y z.
    pub(super) fn find<'a>(names: impl IntoIterator<Item = Option<&'a str>>) -> Option<Self> {
        let parsed: Vec<Option<(String, f64)>> = names
            .into_iter()
            .map(|name| name.map(name_and_unit))
            .collect();
        let find = |spellings: &[&str]| {
            spellings.iter().find_map(|spelling| {
                let is_it = |c: &Option<(String, f64)>| {
                    c.as_ref().is_some_and(|(name, _)| name == spelling)
                };
                parsed.iter().position(is_it)
            })
        };
        let three = |names: &[[&str; 5]; 3]| match names.each_ref().map(|n| find(n)) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        };
        let xyz = three(&COORDINATES)?;
        let unit_m = |column: usize| match parsed.get(column) {
            Some(Some((_, unit_m))) => *unit_m,
            _ => 1.0,
        };
        Some(Self {
            xyz,
            normal: three(&NORMALS),
            unit_m: xyz.map(unit_m),
        })
    }
}

/// `X [mm]` is `x` in thousandths of a metre.
fn name_and_unit(text: &str) -> (String, f64) {
    let text = text.trim().to_ascii_lowercase();
    let Some(at) = text.find(['[', '(']) else {
        return (text, 1.0);
    };
    let (name, unit) = text.split_at(at);
    let unit = unit.trim_matches(['[', ']', '(', ')', ' ']);
    let unit_m = UNITS_M.iter().find(|(name, _)| *name == unit);
    (name.trim().to_owned(), unit_m.map_or(1.0, |(_, m)| *m))
}

#[cfg(test)]
mod tests {
    use super::Columns;

    fn find(names: &str) -> Option<Columns> {
        Columns::find(names.split(',').map(Some))
    }

    #[test]
    fn columns_are_found_by_name_in_any_order_and_case() {
        let xyz = |names| find(names).map(|columns| columns.xyz);
        assert_eq!(xyz("x,y,z"), Some([0, 1, 2]));
        assert_eq!(xyz("Z,t,Y,X"), Some([3, 2, 0]));
        assert_eq!(xyz("Points:0,Points:1,Points:2"), Some([0, 1, 2]));
        assert_eq!(xyz("position_x,x,y,z"), Some([1, 2, 3]));
        assert_eq!(xyz("x,y"), None);
        assert_eq!(
            Columns::find([Some("x"), None, Some("y"), Some("z")]).map(|c| c.xyz),
            Some([0, 2, 3])
        );
        let with_normal = find("nx,x,ny,y,normal_z,z").expect("columns");
        assert_eq!(
            (with_normal.xyz, with_normal.normal),
            ([1, 3, 5], Some([0, 2, 4]))
        );
        assert_eq!(find("x,y,z,nx,ny").expect("columns").normal, None);
    }

    #[test]
    fn a_unit_in_brackets_scales_its_column() {
        let unit_m = |names| find(names).expect("columns").unit_m;
        assert_eq!(unit_m("X [m],Y [mm],Z (cm)"), [1.0, 0.001, 0.01]);
        assert_eq!(unit_m("x,y [world],z[]"), [1.0; 3]);
    }
}
