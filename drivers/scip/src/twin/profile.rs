//! Which sensor the twin is: the lines by which it tells who it is, and what its firmware can do.

/// Which commands a sensor knows beside those of every SCIP2.0 sensor, and how it words its answers (protocol sections
/// 1, 6 and 10).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Generation {
    /// URG-04LX and its like: distances only, one command per turn of the motor.
    Urg,
    /// UTM-30LX on USB: `ME GE` (intensity) and `RT`; no `CR`, `HS`, `DB`.
    Top,
    /// UST and UTM-30LX-EW on Ethernet, SCIP2.2: besides `ND NE HD HE` (several echoes), `RB`, `%ST`, `%SL`, `$IP`;
    /// `TM1` is answered outside time adjustment too.
    Ethernet,
}

/// Identity and abilities of one model and firmware (protocol sections 1, 6, 9, 10 and 12).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Profile {
    /// Which family of commands.
    pub generation: Generation,
    /// `VEND` of `VV`.
    pub vendor: &'static str,
    /// `MODL` of `PP` and `II`.
    pub model: &'static str,
    /// `PROD` of `VV`.
    pub product: &'static str,
    /// `FIRM` of `VV`.
    pub firmware: String,
    /// `SERI` of `VV`.
    pub serial: String,
    /// `FIRM`, `PROT` and `STAT` lines of the SCIP1.1 `V` reply; `None` for a sensor that wakes in SCIP2.0 and knows no other.
    pub scip1: Option<Scip1Lines>,
    /// `PROT` of `VV`.
    pub protocol: &'static str,
    /// Least distance, mm (`DMIN`).
    pub min_range_mm: u32,
    /// Greatest distance, mm (`DMAX`).
    pub max_range_mm: u32,
    /// Steps of a full revolution (`ARES`).
    pub steps_per_revolution: u32,
    /// First measuring step (`AMIN`).
    pub first_step: u32,
    /// Last measuring step (`AMAX`).
    pub last_step: u32,
    /// Step straight ahead (`AFRT`).
    pub front_step: u32,
    /// Highest step that can be asked for.
    pub max_step: u32,
    /// Nominal speed, revolutions per minute (`SCAN`).
    pub speed_rpm: u32,
    /// Which part of a `KEY:value;` line its sum counts.
    pub keyed_sum: KeyedSum,
    /// `SBPS` of a sensor without a serial line; `None` if it has one and tells its bit rate.
    pub usb_only_text: Option<&'static str>,
    /// Whether the firmware knows `HS` (from 3.2.00 on); an older one answers 0C.
    pub high_sensitivity: bool,
    /// Whether the firmware knows `DB` (from 3.3.00 on, not all units); another answers 0E.
    pub rehearsals: bool,
}

/// What the SCIP1.1 `V` reply says differently from `VV`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scip1Lines {
    /// The `FIRM:` line.
    pub firmware: &'static str,
    /// The `PROT:` line.
    pub protocol: &'static str,
    /// The `STAT:` line.
    pub status: &'static str,
}

/// Which part of a `KEY:value;` line its sum counts (section 3: three habits are on record).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeyedSum {
    /// Everything before the `;`: every byte log.
    BeforeSemicolon,
    /// The `;` too: what the vendor's library also takes.
    WithSemicolon,
    /// Nothing from `<-` on: reported of UTM-30LX firmware.
    BeforeComment,
}

impl Generation {
    /// `ME`, `GE` and `RT`.
    pub(super) fn has_intensity(self) -> bool {
        self != Self::Urg
    }

    /// SCIP2.2 with its further commands and its reused status letters.
    pub(super) fn is_ethernet(self) -> bool {
        self == Self::Ethernet
    }
}

impl Profile {
    /// URG-04LX H0706400 with firmware 3.1.04: USB and RS-232C, wakes in SCIP1.1 (section 12).
    pub fn urg_04lx() -> Self {
        Self {
            generation: Generation::Urg,
            vendor: "Hokuyo Automatic Co.,Ltd.",
            model: "URG-04LX(Hokuyo Automatic Co.,Ltd.)",
            product: "SOKUIKI Sensor URG-04LX",
            firmware: "3.1.04(02/Aug./2007)".to_owned(),
            serial: "H0706400".to_owned(),
            scip1: Some(Scip1Lines {
                firmware: "FIRM:3.1.04,07/08/02(20-4095[mm],240[deg],44-725[step],600[rpm])",
                protocol: "PROT:00003,(SCIP 1.0)",
                status: "STAT:FW Normal[FinalDist with shadow  ]",
            }),
            protocol: "SCIP 2.0",
            min_range_mm: 20,
            max_range_mm: 5600,
            steps_per_revolution: 1024,
            first_step: 44,
            last_step: 725,
            front_step: 384,
            max_step: 768,
            speed_rpm: 600,
            keyed_sum: KeyedSum::BeforeSemicolon,
            usb_only_text: None,
            high_sensitivity: false,
            rehearsals: false,
        }
    }

    /// URG-04LX-UG01 H1510998 with firmware 3.4.03: USB only, wakes in SCIP2.0, knows `HS` and `DB` (sections 1 and 12).
    /// Its `SBPS` text is the one other USB-only models send.
    pub fn urg_04lx_ug01() -> Self {
        Self {
            model: "URG-04LX-UG01(Simple-URG)(Hokuyo Automatic Co.,Ltd.)",
            product: "SOKUIKI Sensor URG-04LX-UG01(Simple-URG)",
            firmware: "3.4.03(17/Dec./2012)".to_owned(),
            serial: "H1510998".to_owned(),
            scip1: None,
            usb_only_text: Some("USB Full Speed"),
            high_sensitivity: true,
            rehearsals: true,
            ..Self::urg_04lx()
        }
    }

    /// UTM-30LX with firmware P.1.05: USB only, 40 turns a second, 1081 steps over 270 degrees (section 1). Its serial
    /// number and the date of its firmware are made up: the document has none.
    pub fn utm_30lx() -> Self {
        Self {
            generation: Generation::Top,
            model: "UTM-30LX(Hokuyo Automatic Co.,Ltd.)",
            product: "SOKUIKI Sensor TOP-URG UTM-30LX",
            firmware: "P.1.05(01/Apr./2008)".to_owned(),
            serial: "H0800001".to_owned(),
            scip1: None,
            min_range_mm: 23,
            max_range_mm: 60_000,
            steps_per_revolution: 1440,
            first_step: 0,
            last_step: 1080,
            front_step: 540,
            max_step: 1080,
            speed_rpm: 2400,
            usb_only_text: Some("USB Full Speed"),
            ..Self::urg_04lx()
        }
    }

    /// A UST-20LX on TCP (section 10). The document has no full log of one: its numbers are the UTM-30LX's, its wordings
    /// those that the document's simulator of the family uses, its serial number is made up.
    pub fn ust_20lx() -> Self {
        Self {
            generation: Generation::Ethernet,
            vendor: "Hokuyo Automatic Co., Ltd.",
            model: "UST-20LX",
            product: "UST-20LX",
            firmware: "1.1.0 (2011-09-30)".to_owned(),
            serial: "H1400001".to_owned(),
            protocol: "SCIP 2.2",
            usb_only_text: Some("Ethernet 100 [Mbps]"),
            ..Self::utm_30lx()
        }
    }

    /// The profiles by the names a command line takes.
    pub const NAMES: [&'static str; 4] = ["urg-04lx", "urg-04lx-ug01", "utm-30lx", "ust-20lx"];

    /// The profile of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        match name {
            "urg-04lx" => Some(Self::urg_04lx()),
            "urg-04lx-ug01" => Some(Self::urg_04lx_ug01()),
            "utm-30lx" => Some(Self::utm_30lx()),
            "ust-20lx" => Some(Self::ust_20lx()),
            _ => None,
        }
    }
}

impl Default for Profile {
    fn default() -> Self {
        Self::urg_04lx()
    }
}
