//! Where the newest line of each row is in the journal, in eight bytes a row.

use std::collections::BTreeMap;

/// Rows of a page; numbers of rows are dense.
const PAGE_ROWS: usize = 512;
/// Bits of a [`Place`] for the length of the line: 16 MiB. The longest line is of 83 kB (`position.rs`).
const LENGTH_BITS: u32 = 24;

/// Offset and length of a line; 0: none.
type Place = u64;

/// Newest lines by table and number of the row.
#[derive(Debug, Default)]
pub(super) struct NewestLines {
    tables: BTreeMap<String, BTreeMap<i64, Box<[Place; PAGE_ROWS]>>>,
    bytes: u64,
}

impl NewestLines {
    /// Notes a line of a row; what was noted of the row before is superseded.
    pub(super) fn note(&mut self, table: &str, id: i64, offset: u64, length: u64) {
        if !self.tables.contains_key(table) {
            self.tables.insert(table.to_owned(), BTreeMap::new());
        }
        let Some(pages) = self.tables.get_mut(table) else {
            return;
        };
        let rows = PAGE_ROWS as i64;
        let page = pages
            .entry(id.div_euclid(rows))
            .or_insert_with(|| Box::new([0; PAGE_ROWS]));
        let place = &mut page[id.rem_euclid(rows) as usize];
        self.bytes += length;
        self.bytes -= *place & ((1 << LENGTH_BITS) - 1);
        *place = (offset << LENGTH_BITS) | length;
    }

    /// Bytes of the newest lines.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Offsets of the newest lines, in no order.
    pub(super) fn offsets(self) -> impl Iterator<Item = u64> {
        let pages = self.tables.into_values().flat_map(BTreeMap::into_values);
        let places = pages.flat_map(|page| page.into_iter().filter(|place| *place > 0));
        places.map(|place| place >> LENGTH_BITS)
    }
}

#[cfg(test)]
mod tests {
    use super::{NewestLines, PAGE_ROWS};

    #[test]
    fn the_last_line_of_each_row_counts() {
        let mut newest = NewestLines::default();
        let far = 5 * PAGE_ROWS as i64;
        for (table, id, offset, length) in [
            ("visit", 1, 0, 10),
            ("alarm", 1, 10, 7),
            ("visit", far, 17, 3),
            ("visit", 1, 20, 5),
            ("visit", far + 1, 25, 1),
            ("visit", -1, 26, 2),
        ] {
            newest.note(table, id, offset, length);
        }
        assert_eq!(newest.bytes(), 7 + 3 + 5 + 1 + 2);
        let mut offsets: Vec<u64> = newest.offsets().collect();
        offsets.sort_unstable();
        assert_eq!(offsets, [10, 17, 20, 25, 26]);
    }
}
