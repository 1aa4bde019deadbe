//! The stored form of a dialogue: docs/recording.md.

use super::constants::{MAX_TEXT_BYTES, VERSION};
use super::dialogue::{DialogueEnd, DialogueEntry, DialogueEntryKind, SweepDialogue};
use super::error::DialogueError;
use super::{ByteReader, ByteWriter};
use crate::devices::error::Device;
use std::time::Duration;

/// First bytes: "patrold, dialogue".
const MAGIC: [u8; 4] = *b"PTRD";
/// In the tag of an entry: of the head, not the laser.
const OF_THE_HEAD: u8 = 0x80;

/// Appends entries in their stored form.
#[derive(Debug, Clone, Default)]
pub(super) struct EntryWriter {
    out: ByteWriter,
    count: u32,
    last: Duration,
}

impl EntryWriter {
    /// The first entry counts from `began_at`.
    pub(super) fn new(began_at: Duration) -> Self {
        Self {
            last: began_at,
            ..Self::default()
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.out.0.len()
    }

    /// `bytes` of an entry that has some.
    pub(super) fn push(&mut self, tag: u8, device: Device, at: Duration, bytes: Option<&[u8]>) {
        let of_the_head = match device {
            Device::Laser => 0,
            Device::Head => OF_THE_HEAD,
        };
        self.out.u8(tag | of_the_head);
        let since = nanoseconds(at).wrapping_sub(nanoseconds(self.last));
        self.out.signed_varint(since.cast_signed());
        self.last = at;
        if let Some(bytes) = bytes {
            self.out.varint(bytes.len() as u64);
            self.out.0.extend_from_slice(bytes);
        }
        self.count += 1;
    }
}

/// Within 584 years.
fn nanoseconds(at: Duration) -> u64 {
    u64::try_from(at.as_nanos()).unwrap_or(u64::MAX)
}

/// What is before the entries.
#[derive(Debug)]
pub(super) struct DialogueHeader<'a> {
    pub(super) plan: &'a [u8],
    pub(super) laser: &'a [u8],
    pub(super) head: &'a [u8],
    pub(super) began_at: Duration,
    pub(super) end: &'a DialogueEnd,
}

/// The whole file.
pub(super) fn encode(header: &DialogueHeader<'_>, entries: &EntryWriter) -> Vec<u8> {
    let mut out = ByteWriter(MAGIC.to_vec());
    out.u8(VERSION);
    out.block(header.plan);
    out.block(header.laser);
    out.block(header.head);
    out.u64(nanoseconds(header.began_at));
    let (end, why) = match header.end {
        DialogueEnd::Complete => (0, ""),
        DialogueEnd::Failed(why) => (1, why.as_str()),
        DialogueEnd::TooLong => (2, ""),
    };
    out.u8(end);
    let cut = why.floor_char_boundary(MAX_TEXT_BYTES);
    out.block(&why.as_bytes()[..cut]);
    out.u32(entries.count);
    out.0.extend_from_slice(&entries.out.0);
    out.0
}

impl DialogueEntryKind {
    /// As in the container.
    pub(super) fn tag(&self) -> u8 {
        match self {
            Self::Received(_) => 0,
            Self::Sent(_) => 1,
            Self::CommandTaken => 2,
            Self::DriverDeadline => 3,
            Self::EventHandled => 4,
            Self::PortLost => 5,
            Self::SweepDeadline => 6,
            Self::Cancelled => 7,
        }
    }

    fn bytes(&self) -> Option<&[u8]> {
        match self {
            Self::Received(bytes) | Self::Sent(bytes) => Some(bytes),
            _ => None,
        }
    }
}

impl SweepDialogue {
    /// The bytes of the container.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut entries = EntryWriter::new(self.began_at);
        for entry in &self.entries {
            let tag = entry.kind.tag();
            entries.push(tag, entry.device, entry.at, entry.kind.bytes());
        }
        let header = DialogueHeader {
            plan: &self.plan,
            laser: &self.laser,
            head: &self.head,
            began_at: self.began_at,
            end: &self.end,
        };
        encode(&header, &entries)
    }

    /// Reads a container.
    ///
    /// # Errors
    /// [`DialogueError`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, DialogueError> {
        let mut input = ByteReader::new(bytes);
        let magic = bytes.get(..MAGIC.len()).unwrap_or(bytes);
        if magic != MAGIC {
            let got = format!("\"{}\"", magic.escape_ascii());
            return Err(DialogueError::OtherKind { got });
        }
        input.take(MAGIC.len(), "PTRD")?;
        match input.u8("a version")? {
            VERSION => {}
            0 => return Err(input.damaged("a version from 1")),
            got => return Err(DialogueError::Newer { got }),
        }
        let plan = input.block("a plan")?.to_vec();
        let laser = input.block("the laser's driver")?.to_vec();
        let head = input.block("the head's driver")?.to_vec();
        let began_at = Duration::from_nanos(input.u64("an instant")?);
        let end = input.u8("an end")?;
        let why = input.text("a reason")?;
        let end = match end {
            0 => DialogueEnd::Complete,
            1 => DialogueEnd::Failed(why),
            2 => DialogueEnd::TooLong,
            _ => return Err(input.damaged("an end of 0 to 2")),
        };
        let count = input.u32("a number of entries")?;
        let (mut entries, mut last) = (Vec::new(), nanoseconds(began_at));
        for _ in 0..count {
            entries.push(read_entry(&mut input, &mut last)?);
        }
        if !input.is_at_end() {
            return Err(input.damaged("the end"));
        }
        Ok(Self {
            plan,
            laser,
            head,
            began_at,
            end,
            entries,
        })
    }
}

fn read_entry(input: &mut ByteReader<'_>, last: &mut u64) -> Result<DialogueEntry, DialogueError> {
    let tag = input.u8("an entry")?;
    let device = match tag & OF_THE_HEAD {
        0 => Device::Laser,
        _ => Device::Head,
    };
    *last = last.wrapping_add_signed(input.signed_varint("an instant")?);
    let bytes = |input: &mut ByteReader<'_>| -> Result<Vec<u8>, DialogueError> {
        let length = input.varint("a length")?;
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        Ok(input.take(length, "bytes")?.to_vec())
    };
    let kind = match tag & !OF_THE_HEAD {
        0 => DialogueEntryKind::Received(bytes(input)?),
        1 => DialogueEntryKind::Sent(bytes(input)?),
        2 => DialogueEntryKind::CommandTaken,
        3 => DialogueEntryKind::DriverDeadline,
        4 => DialogueEntryKind::EventHandled,
        5 => DialogueEntryKind::PortLost,
        6 => DialogueEntryKind::SweepDeadline,
        7 => DialogueEntryKind::Cancelled,
        _ => return Err(input.damaged("an entry of kind 0 to 7")),
    };
    Ok(DialogueEntry {
        at: Duration::from_nanos(*last),
        device,
        kind,
    })
}

#[cfg(test)]
mod tests {
    use super::super::error::DialogueError;
    use super::{DialogueEnd, DialogueEntry, DialogueEntryKind as Kind, SweepDialogue};
    use crate::devices::error::Device;
    use std::time::Duration;

    fn dialogue() -> SweepDialogue {
        let entry = |ns, device, kind| DialogueEntry {
            at: Duration::from_nanos(ns),
            device,
            kind,
        };
        SweepDialogue {
            plan: vec![1, 2],
            laser: vec![3],
            head: vec![],
            began_at: Duration::from_nanos(1_000_000_000),
            end: DialogueEnd::Failed("off".to_owned()),
            entries: vec![
                entry(1_000_000_010, Device::Laser, Kind::CommandTaken),
                entry(1_000_000_010, Device::Laser, Kind::Sent(b"QT\n".to_vec())),
                // Noted later than the laser's, and earlier.
                entry(1_000_000_005, Device::Head, Kind::Received(b"*".to_vec())),
                entry(1_000_000_300, Device::Head, Kind::EventHandled),
                entry(1_000_000_300, Device::Laser, Kind::DriverDeadline),
                entry(1_000_000_300, Device::Head, Kind::PortLost),
                entry(1_000_000_300, Device::Laser, Kind::SweepDeadline),
                entry(1_000_000_300, Device::Laser, Kind::Cancelled),
            ],
        }
    }

    /// The worked example of docs/recording.md.
    const EXAMPLE: &str = "50 54 52 44 01 02 00 00 00 01 02 01 00 00 00 03 00 00 00 00 00 ca 9a 3b 00 00 00 00 01 03 00 00 00 \
        6f 66 66 08 00 00 00 02 14 01 00 03 51 54 0a 80 09 01 2a 84 ce 04 03 00 85 00 06 00 07 00";

    #[test]
    fn the_bytes_are_those_of_the_document() {
        let bytes = dialogue().to_bytes();
        let hex: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex.join(" "), EXAMPLE);
        assert_eq!(SweepDialogue::from_bytes(&bytes), Ok(dialogue()));
        let document = patrold_test_support::workspace_root().join("docs/recording.md");
        let document = std::fs::read_to_string(document).expect("the document");
        let words: Vec<&str> = document.split_whitespace().collect();
        let example: Vec<&str> = EXAMPLE.split_whitespace().collect();
        assert!(words.windows(example.len()).any(|w| w == example));
    }

    #[test]
    fn what_is_cut_changed_newer_or_another_thing_is_refused_in_words() {
        let whole = dialogue().to_bytes();
        for length in 5..whole.len() {
            let error = SweepDialogue::from_bytes(&whole[..length]).expect_err("cut");
            assert!(error.to_string().contains("cut short"), "{length}: {error}");
        }
        let mut longer = whole.clone();
        longer.push(0);
        assert!(SweepDialogue::from_bytes(&longer).is_err());
        let with = |at: usize, byte: u8| {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            SweepDialogue::from_bytes(&bytes).expect_err("refused")
        };
        assert_eq!(with(4, 2), DialogueError::Newer { got: 2 });
        assert!(with(4, 2).to_string().contains("version 2"));
        assert!(with(4, 0).to_string().contains("version from 1"));
        let other = with(0, b'X').to_string();
        assert!(other.contains("\"XTRD\""), "{other}");
        // The kind of the first entry.
        assert!(with(40, 8).to_string().contains("kind 0 to 7"));
        assert!(SweepDialogue::from_bytes(b"").is_err());
    }
}
